#include "scene/src/gltf/writer.h"
#include "fvv_cxx/error.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <meshoptimizer.h>

namespace fvv::scene::gltf {

namespace {

constexpr const char *meshopt = "EXT_meshopt_compression";

// What the extension has: version 0 of the vertex codec and 1 of the index codec, and the first bytes of
// them.
constexpr int vertex_version = 0, index_version = 1;
constexpr unsigned char vertex_head = 0xa0, index_head = 0xe1;

// A setting of the whole process, which libfvv's own meshes need too. A static local is set once, whatever
// the number of threads.
void choose_versions() {
  static const bool chosen = [] {
    meshopt_encodeVertexVersion(vertex_version);
    meshopt_encodeIndexVersion(index_version);
    return true;
  }();
  (void)chosen;
}

} // namespace

void put_u16(std::string &out, uint16_t bits) {
  out += char(bits & 255);
  out += char(bits >> 8);
}

void put_u32(std::string &out, uint32_t bits) {
  for (int i = 0; i < 4; i++) out += char(bits >> (8 * i) & 255);
}

void put_float(std::string &out, float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  put_u32(out, bits);
}

void check_on_lattice(double stored, double exact, size_t vertex, double step, const std::string &name) {
  if (!(std::fabs(stored - exact) <= 0.49 * step))
    throw Error(
        name + ": vertex " + std::to_string(vertex) +
        " lies too far out for float32, the numbers of glTF, on a lattice of this step: PLY has float64");
}

std::optional<std::array<double, 3>> local_origin(const Lattice &lattice, const Bounds<double> &positions) {
  const auto &[low, high] = positions;
  if (low.empty()) return std::nullopt;
  // Float32 has 24 bits: below this number of steps it errs by an eighth of one at most.
  constexpr double most_steps = 1 << 21;
  constexpr double block = 65536; // steps: frames that move little have the same origin
  bool is_near = true, is_by_lattice = true;
  for (size_t k = 0; k < 3; k++) {
    is_near = is_near && std::max(-low[k], high[k]) < most_steps * lattice.step;
    is_by_lattice = is_by_lattice && std::max(lattice.origin[k] - low[k], high[k] - lattice.origin[k]) <
                                         most_steps * lattice.step;
  }
  if (is_near) return std::nullopt;
  std::array<double, 3> origin;
  for (size_t k = 0; k < 3; k++) {
    const double blocks = std::floor((low[k] - lattice.origin[k]) / (lattice.step * block));
    origin[k] = lattice.origin[k] + (is_by_lattice ? 0 : lattice.step * block * blocks);
  }
  return origin;
}

Writer::Writer(const std::string &file, bool with_meshopt) : name(file), compress(with_meshopt) {
  document = {{"asset", {{"version", "2.0"}, {"generator", "fvv"}}}, {"scene", 0}, {"scenes", Json::array()}};
  for (const char *list : {"nodes", "meshes", "animations", "materials", "textures", "images", "samplers",
                           "accessors", "bufferViews"})
    document[list] = Json::array();
}

void Writer::use(const char *extension, bool is_required) {
  const auto add = [&](Json &names) {
    if (std::find(names.begin(), names.end(), extension) == names.end()) names.push_back(extension);
  };
  add(used);
  if (is_required) add(required);
}

size_t Writer::view(std::string_view bytes, Use use, size_t stride) {
  Json entry = {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}};
  if (stride) entry["byteStride"] = stride;
  if (use != Use::unstated) entry["target"] = int(use);
  binary += bytes;
  while (binary.size() % 4) binary += '\0';
  document["bufferViews"].push_back(entry);
  return document["bufferViews"].size() - 1;
}

std::string Writer::compressed(const std::string &bytes, Use use, size_t stride) const {
  choose_versions();
  const size_t count = bytes.size() / stride;
  std::vector<unsigned char> out;
  if (use == Use::indices) {
    std::vector<unsigned> corners(count);
    for (size_t i = 0; i < bytes.size(); i++)
      corners[i / 4] |= unsigned(static_cast<unsigned char>(bytes[i])) << (8 * (i % 4));
    out.resize(meshopt_encodeIndexBufferBound(count, UINT32_MAX));
    out.resize(meshopt_encodeIndexBuffer(out.data(), out.size(), corners.data(), count));
  } else {
    out.resize(meshopt_encodeVertexBufferBound(count, stride));
    out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), bytes.data(), count, stride));
  }
  if (out.empty() || out[0] != (use == Use::indices ? index_head : vertex_head))
    throw Error(name + ": meshoptimizer cannot encode " + std::to_string(count) +
                " elements as EXT_meshopt_compression has them");
  return std::string(out.begin(), out.end());
}

size_t Writer::elements(const std::string &bytes, Use use, size_t stride, bool strided) {
  if (!compress) return view(bytes, use, strided ? stride : 0);
  this->use(meshopt, true);
  const std::string packed = compressed(bytes, use, stride);
  Json entry = {{"buffer", 1}, {"byteOffset", uncompressed}, {"byteLength", bytes.size()}};
  if (strided) entry["byteStride"] = stride;
  if (use != Use::unstated) entry["target"] = int(use);
  entry["extensions"] = {{meshopt,
                          {{"buffer", 0},
                           {"byteOffset", binary.size()},
                           {"byteLength", packed.size()},
                           {"byteStride", stride},
                           {"mode", use == Use::indices ? "TRIANGLES" : "ATTRIBUTES"},
                           {"count", bytes.size() / stride}}}};
  uncompressed += bytes.size();
  binary += packed;
  while (binary.size() % 4) binary += '\0';
  document["bufferViews"].push_back(entry);
  return document["bufferViews"].size() - 1;
}

size_t Writer::accessor(std::optional<size_t> view, Component component, size_t count, const char *type,
                        size_t offset) {
  Json entry = Json::object();
  if (view) entry["bufferView"] = *view;
  if (offset) entry["byteOffset"] = offset;
  entry["componentType"] = unsigned(component);
  entry["count"] = count;
  entry["type"] = type;
  document["accessors"].push_back(entry);
  return document["accessors"].size() - 1;
}

size_t Writer::floats(const std::vector<double> &values, size_t width, bool bounded) {
  std::string bytes;
  std::vector<float> low(width, INFINITY), high(width, -INFINITY);
  for (size_t i = 0; i < values.size(); i++) {
    const float value = float(values[i]);
    put_float(bytes, value);
    low[i % width] = std::min(low[i % width], value);
    high[i % width] = std::max(high[i % width], value);
  }
  const size_t out = accessor(elements(bytes, Use::vertices, 4 * width), component_float32,
                              values.size() / width, width == 2 ? "VEC2" : "VEC3");
  if (bounded) bound(out, low, high);
  return out;
}

size_t Writer::corners(const std::vector<uint32_t> &faces) {
  std::string bytes;
  for (const uint32_t corner : faces) put_u32(bytes, corner);
  return accessor(elements(bytes, Use::indices, 4), component_uint32, faces.size(), "SCALAR");
}

size_t Writer::image(const std::string &picture) {
  const bool png = picture.compare(0, 4, "\x89PNG") == 0;
  document["images"].push_back(
      {{"bufferView", view(picture)}, {"mimeType", png ? "image/png" : "image/jpeg"}});
  return document["images"].size() - 1;
}

size_t Writer::material(const Surface &surface) {
  Json colour = {{"baseColorFactor", {surface.colour[0], surface.colour[1], surface.colour[2], 1}},
                 {"metallicFactor", 0},
                 {"roughnessFactor", 1}};
  if (surface.image) {
    Json texture = {{"source", *surface.image}};
    if (surface.clamped) {
      constexpr int clamp_to_edge = 33071;
      document["samplers"] = {{{"wrapS", clamp_to_edge}, {"wrapT", clamp_to_edge}}};
      texture["sampler"] = 0;
    }
    document["textures"].push_back(texture);
    colour["baseColorTexture"] = {{"index", document["textures"].size() - 1}};
  }
  Json entry = {{"pbrMetallicRoughness", colour}};
  if (surface.double_sided) entry["doubleSided"] = true;
  if (surface.unlit) {
    use("KHR_materials_unlit");
    entry["extensions"] = {{"KHR_materials_unlit", Json::object()}};
  }
  document["materials"].push_back(entry);
  return document["materials"].size() - 1;
}

void Writer::place(const std::array<double, 3> &origin, Json &node) {
  Json moved = origin;
  if (node.contains("translation"))
    for (size_t k = 0; k < 3; k++) moved[k] = origin[k] + node["translation"][k].get<double>();
  node["translation"] = moved;
  node["extras"] = {{"origin", origin}};
}

std::string Writer::glb() {
  Json roots = Json::array();
  for (size_t i = 0; i < document["nodes"].size(); i++) roots.push_back(i);
  document["scenes"].push_back({{"nodes", roots}});
  if (!used.empty()) document["extensionsUsed"] = used;
  if (!required.empty()) document["extensionsRequired"] = required;
  for (const char *list : {"nodes", "meshes", "animations", "materials", "textures", "images", "samplers",
                           "accessors", "bufferViews"})
    if (document[list].empty()) document.erase(list);
  document["buffers"] = {{{"byteLength", binary.size()}}};
  // What compressed views would be without compression; its bytes exist nowhere.
  if (uncompressed)
    document["buffers"].push_back(
        {{"byteLength", uncompressed}, {"extensions", {{meshopt, {{"fallback", true}}}}}});
  std::string text = document.dump();
  while (text.size() % 4) text += ' ';
  const uint64_t size = 12 + 8 + uint64_t(text.size()) + 8 + binary.size();
  if (size > UINT32_MAX) throw Error(name + ": the file would have more than 4 GiB");
  std::string out = "glTF";
  put_u32(out, 2);
  put_u32(out, uint32_t(size));
  put_u32(out, uint32_t(text.size()));
  out += "JSON" + text;
  put_u32(out, uint32_t(binary.size()));
  out.append("BIN\0", 4);
  return out + binary;
}

} // namespace fvv::scene::gltf
