// A GLB that is being written: its document, and the bytes of its chunk BIN. The same calls produce the same
// bytes on every machine.
#pragma once

#include "fvv_scene/mesh_file.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::scene::gltf {

// Of an accessor's component.
enum Component : unsigned {
  component_int16 = 5122,
  component_uint16 = 5123,
  component_uint32 = 5125,
  component_float32 = 5126
};
// What the GPU uses a view for.
enum class Use { unstated = 0, vertices = 34962, indices = 34963 };

// A base colour, and a picture that it is a factor of.
struct Surface {
  double colour[3] = {1, 1, 1};
  std::optional<size_t> image;
  bool clamped = false, unlit = false, double_sided = false;
};

// Numbers in little-endian order, as buffers hold them.
void put_u16(std::string &out, uint16_t bits);
void put_u32(std::string &out, uint32_t bits);
void put_float(std::string &out, float value);

// Error "name: vertex N lies too far out ..." unless a coordinate as float32, stored, rounds to the lattice
// point of the exact one.
void check_on_lattice(double stored, double exact, size_t vertex, double step, const std::string &name);

// The lowest and the highest of each of three components.
template <class Number> struct Bounds {
  std::vector<Number> low, high;
  void add(size_t component, Number value) {
    if (low.size() <= component) {
      low.push_back(value);
      high.push_back(value);
    }
    low[component] = std::min(low[component], value);
    high[component] = std::max(high[component], value);
  }
};

// What positions within bounds are to be relative to, so that float32 has them to an eighth of a step of
// their lattice, or as near as their own size allows: a point of the lattice; none: to nothing.
std::optional<std::array<double, 3>> local_origin(const Lattice &lattice, const Bounds<double> &positions);

class Writer {
public:
  using Json = nlohmann::ordered_json;

  // file: its name for messages, which outlives this object. with_meshopt: elements() compresses.
  explicit Writer(const std::string &file, bool with_meshopt = false);

  // Lists of the document that are empty at the end are left out.
  Json &list(const char *key) { return document[key]; }
  Json &extensions() { return document["extensions"]; }
  void use(const char *extension, bool required = false);

  // A view as it is. stride: bytes of an element, where accessors share the view.
  size_t view(std::string_view bytes, Use use = Use::unstated, size_t stride = 0);
  // A view of elements of stride bytes, a multiple of 4, or of the corners of triangles, compressed by
  // EXT_meshopt_compression if this writer does. strided: several accessors share the view, or an element has
  // padding.
  size_t elements(const std::string &bytes, Use use, size_t stride, bool strided = false);
  // Part of a view, from offset on.
  size_t accessor(std::optional<size_t> view, Component component, size_t count, const char *type,
                  size_t offset = 0);
  // The bounds of an accessor's elements, as many numbers each as an element has.
  template <class Number>
  void bound(size_t accessor, const std::vector<Number> &low, const std::vector<Number> &high) {
    document["accessors"][accessor]["min"] = low;
    document["accessors"][accessor]["max"] = high;
  }
  // float32, width components an element.
  size_t floats(const std::vector<double> &values, size_t width, bool bounded);
  size_t corners(const std::vector<uint32_t> &faces);
  size_t image(const std::string &picture); // a file of PNG or JPEG
  size_t material(const Surface &surface);
  // Puts a node at a local origin, with the translation that it has: viewers compute in float32, those who
  // read extras need not.
  static void place(const std::array<double, 3> &origin, Json &node);

  // All nodes are roots of the scene. Error when the file would have more than 4 GiB.
  std::string glb();

private:
  std::string compressed(const std::string &bytes, Use use, size_t stride) const;

  const std::string &name;
  const bool compress;
  Json document, used = Json::array(), required = Json::array();
  std::string binary;
  uint64_t uncompressed = 0; // bytes of all compressed views
};

} // namespace fvv::scene::gltf
