// The outer shell of glTF 2.0 (clauses 2 to 4 of the Khronos specification): the JSON text, alone or in a
// GLB, and the bytes of buffers, be they in the GLB, in data: URIs or in files beside it.
//
// Debian's one small library for glTF, tinygltf 2.7, is not used: it takes the last of two equal keys,
// replaces values of the wrong type by defaults, checks no range of a view or an accessor, and opens "../" in
// URIs. With all that checked here, it would only do what nlohmann-json does.
#pragma once

#include "fvv/types.h"
#include "fvv_scene/strict_json.h"

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::scene::gltf {

// The bytes of a bufferView; stride 0: elements follow one another without gaps.
struct View {
  std::string_view bytes;
  uint64_t stride;
};

// Borrows bytes and path. Every function throws Error with path and JSON pointer.
class Container {
public:
  // path: for messages; buffers are searched in its folder and below.
  Container(std::string_view bytes, const std::string &path);

  JsonValue root() const { return {document, file}; }
  // Resolves reference, an index: an item of the top-level array of that name ("accessors").
  JsonValue item(const char *list, const JsonValue &reference) const;
  // reference: an index among bufferViews. Reads the buffer, and decompresses the view, on the first call.
  View view(const JsonValue &reference);

  // The bytes of an item of images: PNG or JPEG, if the file follows the specification.
  std::string image(size_t index);

  // Called before count numbers are taken out of the file. Accessors may share bytes or have none at all
  // (then they are zero), so that a small file could ask for any amount of memory.
  void charge(const JsonValue &place, uint64_t count);

private:
  void open_glb(std::string_view bytes);
  void check_version() const;
  void check_extensions() const;
  std::string_view buffer(const JsonValue &reference);
  // The bytes given by buffer, byteOffset and byteLength of an object.
  std::string_view range(const JsonValue &place);
  // Called before that number of bytes is read or decoded.
  void charge_bytes(const JsonValue &place, uint64_t size);
  std::string load(const JsonValue &uri, uint64_t limit) const;

  const std::string &file;
  nlohmann::json document;
  std::string_view binary; // chunk BIN of a GLB
  bool has_binary = false;
  std::map<int64_t, std::string> loaded;       // external buffers
  std::map<int64_t, std::string> decompressed; // bufferViews
  uint64_t buffer_bytes = 0, numbers = 0;
};

// The files beside it that a glTF file refers to, as paths. Error for what is no glTF.
std::vector<std::string> external_files(std::string_view bytes, const std::string &path);

// The extensions that a file uses and that may change what it shows: neither understood nor of materials,
// textures or lights.
std::vector<std::string> unknown_extensions(std::string_view bytes, const std::string &path);

// Names of the materials of primitives through which others may be seen (alphaMode MASK and BLEND); "material
// 2" for one without.
std::vector<std::string> transparent_materials(std::string_view bytes, const std::string &path);

} // namespace fvv::scene::gltf
