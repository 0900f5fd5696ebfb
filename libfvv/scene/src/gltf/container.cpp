// GLB, JSON and buffers.

#include "scene/src/gltf/container.h"
#include "fvv_cxx/input_file.h"
#include "fvv_cxx/untrusted.h"
#include "fvv_scene/file_io.h"
#include "fvv_scene/mesh_file.h"
#include "scene/src/gltf/uri.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <map>
#include <meshoptimizer.h>
#include <string_view>

namespace fvv::scene::gltf {

namespace {

// ---- compressed views: EXT_meshopt_compression and what KHR_meshopt_compression shares with it; not the
// filter COLOR, and attributes of version 1 only where the library does.

// What the extension of a view declares.
struct Compressed {
  JsonValue extension;
  uint64_t stride, count;                          // bytes of an element, elements
  uint64_t size() const { return stride * count; } // bytes when decoded
};

constexpr const char *names[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

enum class Mode { attributes, triangles, indices };

Mode mode_of(const JsonValue &extension) {
  const JsonValue mode = extension.at("mode");
  if (mode.text() == "ATTRIBUTES") return Mode::attributes;
  if (mode.text() == "TRIANGLES") return Mode::triangles;
  if (mode.text() == "INDICES") return Mode::indices;
  mode.fail("expected ATTRIBUTES, TRIANGLES or INDICES, found " + mode.found());
}

std::string filter_of(const JsonValue &extension) {
  const auto filter = extension.find("filter");
  if (!filter) return "NONE";
  for (const char *known : {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"})
    if (filter->text() == known) return known;
  filter->fail("expected NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL, found " + filter->found());
}

// "JSON schema updates", the list of what must hold.
void check_stride(const JsonValue &extension, uint64_t stride) {
  const JsonValue place = extension.at("byteStride");
  const std::string filter = filter_of(extension);
  const auto expect = [&](bool fits, const char *what) {
    if (!fits) place.fail(std::string("expected ") + what + ", found " + place.found());
  };
  if (mode_of(extension) != Mode::attributes) {
    expect(stride == 2 || stride == 4, "2 or 4 bytes an index");
    if (filter != "NONE") extension.at("filter").fail("expected NONE for indices, found " + filter);
    return;
  }
  expect(stride % 4 == 0, "a multiple of 4");
  if (filter == "OCTAHEDRAL") expect(stride == 4 || stride == 8, "4 or 8 for OCTAHEDRAL");
  if (filter == "QUATERNION") expect(stride == 8, "8 for QUATERNION");
}

// Appendix A: the least bytes that a number of elements can take.
uint64_t least_size(Mode mode, uint64_t stride, uint64_t count) {
  switch (mode) {
  case Mode::attributes:
    return 1 + stride * ((count + 63) / 64) + std::max<uint64_t>(stride, 32);
  case Mode::triangles:
    return 1 + count / 3 + 16;
  case Mode::indices:
    break;
  }
  return 1 + count + 4;
}

bool decode(Mode mode, const Compressed &c, std::string_view bytes, std::string &out) {
  const auto *data = reinterpret_cast<const unsigned char *>(bytes.data());
  const auto count = static_cast<size_t>(c.count), stride = static_cast<size_t>(c.stride);
  if (mode == Mode::attributes)
    return !meshopt_decodeVertexBuffer(out.data(), count, stride, data, bytes.size());
  if (mode == Mode::triangles)
    return !meshopt_decodeIndexBuffer(out.data(), count, stride, data, bytes.size());
  return !meshopt_decodeIndexSequence(out.data(), count, stride, data, bytes.size());
}

void apply(const std::string &filter, const Compressed &c, std::string &out) {
  const auto count = static_cast<size_t>(c.count), stride = static_cast<size_t>(c.stride);
  if (filter == "OCTAHEDRAL") meshopt_decodeFilterOct(out.data(), count, stride);
  if (filter == "QUATERNION") meshopt_decodeFilterQuat(out.data(), count, stride);
  if (filter == "EXPONENTIAL") meshopt_decodeFilterExp(out.data(), count, stride);
}

// The extension of a view, if it has one: mode, filter, stride and count fit each other and the view.
std::optional<Compressed> compression_of(const JsonValue &view) {
  const auto extensions = view.find("extensions");
  if (!extensions) return std::nullopt;
  std::optional<JsonValue> extension;
  for (const char *name : names)
    if (const auto found = extensions->find(name)) {
      if (extension) view.fail("expected one of EXT_ and KHR_meshopt_compression, found both");
      extension = found;
    }
  if (!extension) return std::nullopt;
  const auto stride = static_cast<uint64_t>(extension->at("byteStride").integer(1, 256));
  const auto count = static_cast<uint64_t>(extension->at("count").integer(1, UINT32_MAX));
  check_stride(*extension, stride);
  if (mode_of(*extension) == Mode::triangles && count % 3)
    extension->at("count").fail("expected a multiple of 3 for TRIANGLES, found " + std::to_string(count));
  const JsonValue size = view.at("byteLength");
  if (static_cast<uint64_t>(size.integer(1, INT64_MAX)) != stride * count)
    size.fail("expected the " + std::to_string(stride * count) + " bytes that are compressed, found " +
              size.found());
  const auto outer = view.find("byteStride");
  if (outer && static_cast<uint64_t>(outer->integer(4, 252)) != stride)
    outer->fail("expected the byteStride of what is compressed, " + std::to_string(stride) + ", found " +
                outer->found());
  return Compressed{*extension, stride, count};
}

// The view's bytes. Before anything is allocated, count is compared with the compressed bytes: one decodes to
// at most 64. Error at the extension when they do not decode.
std::string decompress(const Compressed &compressed, std::string_view bytes) {
  const JsonValue &place = compressed.extension;
  const Mode mode = mode_of(place);
  const uint64_t least = least_size(mode, compressed.stride, compressed.count);
  if (bytes.size() < least)
    place.fail("expected at least " + std::to_string(least) + " bytes for " +
               std::to_string(compressed.count) + " elements, found " + std::to_string(bytes.size()));
  std::string out(static_cast<size_t>(compressed.size()), '\0');
  if (!decode(mode, compressed, bytes, out))
    place.fail("expected " + place.at("mode").text() + " that meshoptimizer decodes, found " +
               std::to_string(bytes.size()) + " other bytes, which begin with " +
               std::to_string(static_cast<unsigned char>(bytes[0])));
  apply(filter_of(place), compressed, out);
  return out;
}

// Of messages about older files.
constexpr const char *way_to_version_2 = ": gltf-pipeline converts it (gltf-pipeline -i old.gltf -o new.glb)";

constexpr uint32_t glb_version = 2, type_json = 0x4e4f534a, type_bin = 0x004e4942;

// As for other mesh files: a scene at the default limits stays far below.
constexpr uint64_t max_buffer_bytes = uint64_t(1) << 30;

// The limit for all numbers of accessors: ordinary files have at most one for every byte, four leave room for
// accessors that share bytes, and the constant for accessors that have none.
constexpr uint64_t numbers_per_byte = 4, numbers_for_free = uint64_t(1) << 24;

// Extensions that a file may require here: those that are supported, and families that change the look of a
// surface but not its shape.
constexpr std::string_view understood[] = {
    "KHR_node_visibility",        "EXT_mesh_gpu_instancing", "KHR_mesh_quantization",  "KHR_lights_punctual",
    "KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"};
constexpr std::string_view looks[] = {"KHR_materials_", "EXT_materials_", "ADOBE_materials_",
                                      "KHR_texture_",   "EXT_texture_",   "MSFT_texture_"};
// Families that describe what is there, or add what is not a surface; only in extensionsUsed.
constexpr std::string_view descriptions[] = {"KHR_xmp",
                                             "EXT_lights_",
                                             "EXT_structural_metadata",
                                             "EXT_mesh_features",
                                             "EXT_instance_features",
                                             "EXT_feature_metadata",
                                             "EXT_mesh_manifold",
                                             "FB_ngon_encoding",
                                             "GODOT_",
                                             "VRM",
                                             "MSFT_lod",
                                             "KHR_audio",
                                             "MSFT_audio",
                                             "KHR_physics",
                                             "KHR_collision",
                                             "OMI_"};

template <size_t N> bool begins_with_one(std::string_view name, const std::string_view (&prefixes)[N]) {
  return std::any_of(std::begin(prefixes), std::end(prefixes),
                     [&](std::string_view prefix) { return name.substr(0, prefix.size()) == prefix; });
}

bool is_harmless(std::string_view name) {
  for (const std::string_view extension : understood)
    if (name == extension) return true;
  return begins_with_one(name, looks);
}

[[noreturn]] void fail_at(const std::string &file, size_t offset, const std::string &what) {
  char text[32];
  snprintf(text, sizeof text, ": 0x%zx: ", offset);
  throw Error(file + text + what);
}

} // namespace

Container::Container(std::string_view bytes, const std::string &path) : file(path) {
  if (bytes.substr(0, 4) == "glTF") {
    open_glb(bytes);
  } else {
    const size_t start = bytes.find_first_not_of(" \t\r\n");
    if (start == bytes.npos || bytes[start] != '{')
      fail_at(file, 0, "expected glTF 2.0, which begins with \"glTF\" (GLB) or with { (JSON)");
    document = parse_strict_json(bytes, file);
  }
  check_version();
  check_extensions();
}

void Container::open_glb(std::string_view bytes) {
  const auto *data = reinterpret_cast<const uint8_t *>(bytes.data());
  constexpr size_t header = 12, chunk_header = 8;
  if (bytes.size() < header) fail_at(file, bytes.size(), "the file ends within the GLB header");
  if (load_u32(data + 4) != glb_version)
    fail_at(file, 4,
            "expected GLB version 2, found " + std::to_string(load_u32(data + 4)) +
                (load_u32(data + 4) < glb_version ? way_to_version_2 : ""));
  if (load_u32(data + 8) != bytes.size())
    fail_at(file, 8,
            "expected a file of " + std::to_string(load_u32(data + 8)) + " bytes, found " +
                std::to_string(bytes.size()));
  bool has_json = false;
  for (size_t at = header; at < bytes.size();) {
    const size_t left = bytes.size() - at;
    if (left < chunk_header) fail_at(file, at, "the file ends within the header of a chunk");
    const uint32_t size = load_u32(data + at), type = load_u32(data + at + 4);
    if (size > left - chunk_header)
      fail_at(file, at,
              "expected a chunk of at most " + std::to_string(left - chunk_header) + " bytes, found " +
                  std::to_string(size));
    const std::string_view body = bytes.substr(at + chunk_header, size);
    if (!has_json && type != type_json) fail_at(file, at + 4, "expected the chunk JSON first");
    if (type == type_json) {
      if (has_json) fail_at(file, at + 4, "expected one chunk JSON, found two");
      has_json = true;
      document = parse_strict_json(body, file);
    } else if (type == type_bin) {
      if (has_binary) fail_at(file, at + 4, "expected one chunk BIN, found two");
      has_binary = true;
      binary = body;
    }
    at += chunk_header + size;
  }
  if (!has_json) fail_at(file, header, "expected the chunk JSON first");
}

void Container::check_version() const {
  const auto asset_key = root().find("asset");
  const auto version_key = asset_key ? asset_key->find("version") : std::nullopt;
  // Before 1.0 a file needed none; until then lists were objects with names as their keys.
  const auto old = root().find("meshes");
  if (!version_key && old && old->is_object())
    root().fail(std::string("expected glTF 2, found an older one without a version") + way_to_version_2);
  const JsonValue asset = root().at("asset"), version = asset.at("version");
  if (version.text().compare(0, 2, "2."))
    version.fail("expected glTF 2, found " + version.found() +
                 (version.text() < std::string("2") ? way_to_version_2 : ""));
  if (const auto least = asset.find("minVersion"); least && least->text() != "2.0")
    least->fail("expected a file that a reader of glTF 2.0 can read, found " + least->found());
}

void Container::check_extensions() const {
  const auto required = root().find("extensionsRequired");
  for (size_t i = 0; required && i < required->size(); i++) {
    const JsonValue extension = required->item(i);
    if (!is_harmless(extension.text()))
      extension.fail(
          "expected KHR_mesh_quantization or an extension of materials, textures or lights, found " +
          extension.found());
  }
}

JsonValue Container::item(const char *list, const JsonValue &reference) const {
  const auto array = root().find(list);
  const size_t count = array ? array->size() : 0;
  const int64_t index = reference.integer(0, INT32_MAX);
  if (static_cast<uint64_t>(index) >= count)
    reference.fail("expected one of " + std::to_string(count) + " " + list + ", found " + reference.found());
  return array->item(static_cast<size_t>(index));
}

View Container::view(const JsonValue &reference) {
  const JsonValue view = item("bufferViews", reference);
  const auto stride_key = view.find("byteStride");
  const uint64_t stride = stride_key ? static_cast<uint64_t>(stride_key->integer(4, 252)) : 0;
  const std::optional<Compressed> compressed = compression_of(view);
  if (!compressed) return {range(view), stride};
  const int64_t index = reference.integer(0, INT32_MAX);
  const auto known = decompressed.find(index);
  if (known != decompressed.end()) return {known->second, stride};
  const std::string_view bytes = range(compressed->extension);
  charge_bytes(view, compressed->size());
  return {decompressed.emplace(index, decompress(*compressed, bytes)).first->second, stride};
}

std::string_view Container::range(const JsonValue &place) {
  const std::string_view bytes = buffer(place.at("buffer"));
  const auto offset_key = place.find("byteOffset");
  const uint64_t offset = offset_key ? static_cast<uint64_t>(offset_key->integer(0, INT64_MAX)) : 0;
  const uint64_t size = static_cast<uint64_t>(place.at("byteLength").integer(1, INT64_MAX));
  if (offset > bytes.size() || size > bytes.size() - offset)
    place.fail("expected bytes " + std::to_string(offset) + " to " + std::to_string(offset + size) +
               " in a buffer of " + std::to_string(bytes.size()));
  return bytes.substr(static_cast<size_t>(offset), static_cast<size_t>(size));
}

void Container::charge_bytes(const JsonValue &place, uint64_t size) {
  if (size > max_buffer_bytes || buffer_bytes + size > max_buffer_bytes)
    place.fail("expected buffers of at most " + std::to_string(max_buffer_bytes) + " bytes together");
  buffer_bytes += size;
}

std::string_view Container::buffer(const JsonValue &reference) {
  const JsonValue buffer = item("buffers", reference);
  const int64_t index = reference.integer(0, INT32_MAX);
  const uint64_t size = static_cast<uint64_t>(buffer.at("byteLength").integer(1, INT64_MAX));
  const auto check = [&](uint64_t found) {
    if (found < size)
      buffer.fail("expected " + std::to_string(size) + " bytes, found " + std::to_string(found));
  };
  const auto uri = buffer.find("uri");
  if (!uri) {
    if (index != 0 || !has_binary)
      buffer.fail("expected a uri, or the chunk BIN for buffer 0 of a GLB, found neither");
    check(binary.size());
    if (loaded.emplace(index, "").second) buffer_bytes += size;
    return binary.substr(0, static_cast<size_t>(size));
  }
  const auto known = loaded.find(index);
  if (known != loaded.end()) return known->second;
  charge_bytes(buffer, size);
  // Some writers pad a buffer's file; more than that is another file.
  constexpr uint64_t padding = 4096;
  std::string bytes = load(*uri, size + padding);
  check(bytes.size());
  bytes.resize(static_cast<size_t>(size));
  return loaded.emplace(index, std::move(bytes)).first->second;
}

std::string Container::image(size_t index) {
  const JsonValue image = root().at("images").item(index);
  if (const auto uri = image.find("uri")) return load(*uri, max_mesh_picture);
  return std::string(view(image.at("bufferView")).bytes);
}

std::string Container::load(const JsonValue &uri, uint64_t limit) const {
  const std::string text = uri.text();
  if (is_data_uri(text)) {
    std::optional<std::string> bytes = data_uri(text);
    if (!bytes) uri.fail("expected base64 in a data: URI, found " + uri.found());
    return std::move(*bytes);
  }
  const std::optional<std::string> name = relative_file(text);
  if (!name) uri.fail("expected a data: URI or a file below the folder of this one, found " + uri.found());
  const std::filesystem::path folder = std::filesystem::path(file).parent_path(), path = folder / *name;
  // The author of a file must not choose what else is read.
  if (!is_below(folder, path))
    uri.fail("expected a file below the folder of this one, found a symbolic link out of it: " + uri.found());
  try {
    return read_file(path.string(), limit);
  } catch (const Error &error) {
    uri.fail(error.what());
  }
}

void Container::charge(const JsonValue &place, uint64_t count) {
  const uint64_t most = buffer_bytes * numbers_per_byte + numbers_for_free;
  if (count > most || numbers > most - count)
    place.fail("expected accessors that hold at most " + std::to_string(most) +
               " numbers together in buffers of " + std::to_string(buffer_bytes) + " bytes");
  numbers += count;
}

std::vector<std::string> external_files(std::string_view bytes, const std::string &path) {
  const Container container(bytes, path);
  std::vector<std::string> out;
  for (const char *list : {"buffers", "images"}) {
    const auto items = container.root().find(list);
    for (size_t i = 0; items && i < items->size(); i++) {
      const auto uri = items->item(i).find("uri");
      if (!uri || is_data_uri(uri->text())) continue;
      if (const auto name = relative_file(uri->text()))
        out.push_back((std::filesystem::path(path).parent_path() / *name).string());
    }
  }
  return out;
}

std::vector<std::string> unknown_extensions(std::string_view bytes, const std::string &path) {
  const Container container(bytes, path);
  std::vector<std::string> out;
  const auto used = container.root().find("extensionsUsed");
  for (size_t i = 0; used && i < used->size(); i++)
    if (const std::string name = used->item(i).text();
        !is_harmless(name) && !begins_with_one(name, descriptions))
      out.push_back(name);
  return out;
}

std::vector<std::string> transparent_materials(std::string_view bytes, const std::string &path) {
  const Container container(bytes, path);
  std::map<int64_t, std::string> out;
  const auto meshes = container.root().find("meshes");
  for (size_t i = 0; meshes && i < meshes->size(); i++) {
    const JsonValue primitives = meshes->item(i).at("primitives");
    for (size_t k = 0; k < primitives.size(); k++) {
      const auto reference = primitives.item(k).find("material");
      if (!reference) continue;
      const JsonValue material = container.item("materials", *reference);
      const auto mode = material.find("alphaMode");
      if (!mode || mode->text() == "OPAQUE") continue;
      const int64_t number = reference->integer(0, INT32_MAX);
      const auto name = material.find("name");
      out[number] = name ? quote(name->text()) : "material " + std::to_string(number);
    }
  }
  std::vector<std::string> names;
  for (const auto &[number, name] : out) names.push_back(name);
  return names;
}

} // namespace fvv::scene::gltf
