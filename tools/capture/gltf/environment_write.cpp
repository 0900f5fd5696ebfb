// capture/gltf/environment_write.cpp: an environment as a GLB: one node and mesh for each part, one node for
// each light. Positions, normals and texture coordinates are float32, as glTF has them.
#include "capture/environment.h"
#include "capture/mesh_check.h"

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

namespace fvv::capture {

namespace {

using Json = nlohmann::ordered_json;

constexpr int float32 = 5126, uint32 = 5125, vertices = 34962, indices = 34963;
constexpr int clamp_to_edge = 33071;

class Writer {
public:
  Writer(const Environment &source, const Lattice &grid, const std::string &file)
      : environment(source), lattice(grid), name(file) {}

  std::string write() {
    document = {
        {"asset", {{"version", "2.0"}, {"generator", "fvv"}}}, {"scene", 0}, {"scenes", Json::array()}};
    for (const char *list : {"nodes", "meshes", "materials", "textures", "images", "samplers"})
      document[list] = Json::array();
    for (const char *list : {"accessors", "bufferViews"}) document[list] = Json::array();
    for (const std::string &picture : environment.pictures)
      document["images"].push_back({{"bufferView", view(picture, {})}, {"mimeType", mime(picture)}});
    for (const EnvironmentPart &part : environment.parts) add(part);
    if (!environment.lights.empty()) add_lights();
    Json roots = Json::array();
    for (size_t i = 0; i < document["nodes"].size(); i++) roots.push_back(i);
    document["scenes"].push_back({{"nodes", roots}});
    if (!used.empty()) document["extensionsUsed"] = used;
    for (const char *list : {"nodes", "meshes", "materials", "textures", "images", "samplers", "accessors"})
      if (document[list].empty()) document.erase(list);
    document["buffers"] = {{{"byteLength", binary.size()}}};
    return glb();
  }

private:
  static const char *mime(const std::string &picture) {
    return picture.compare(0, 4, "\x89PNG") == 0 ? "image/png" : "image/jpeg";
  }

  void use(const char *extension) {
    for (const Json &known : used)
      if (known == extension) return;
    used.push_back(extension);
  }

  size_t view(const std::string &bytes, std::optional<int> target) {
    Json entry = {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}};
    if (target) entry["target"] = *target;
    binary += bytes;
    while (binary.size() % 4) binary += '\0';
    document["bufferViews"].push_back(entry);
    return document["bufferViews"].size() - 1;
  }

  static void put(std::string &out, uint32_t bits) {
    for (int i = 0; i < 4; i++) out += char(bits >> (8 * i) & 255);
  }

  size_t floats(const std::vector<double> &values, size_t width, bool bounded) {
    std::string bytes;
    std::vector<float> low(width, INFINITY), high(width, -INFINITY);
    for (size_t i = 0; i < values.size(); i++) {
      const float value = float(values[i]);
      uint32_t bits;
      memcpy(&bits, &value, sizeof bits);
      put(bytes, bits);
      low[i % width] = std::min(low[i % width], value);
      high[i % width] = std::max(high[i % width], value);
    }
    Json accessor = {{"bufferView", view(bytes, vertices)},
                     {"componentType", float32},
                     {"count", values.size() / width},
                     {"type", width == 2 ? "VEC2" : "VEC3"}};
    if (bounded) {
      accessor["min"] = low;
      accessor["max"] = high;
    }
    document["accessors"].push_back(accessor);
    return document["accessors"].size() - 1;
  }

  size_t corners(const std::vector<uint32_t> &faces) {
    std::string bytes;
    for (const uint32_t corner : faces) put(bytes, corner);
    document["accessors"].push_back({{"bufferView", view(bytes, indices)},
                                     {"componentType", uint32},
                                     {"count", faces.size()},
                                     {"type", "SCALAR"}});
    return document["accessors"].size() - 1;
  }

  // As a float32, a coordinate is to round to the lattice point that it lies on.
  void check_positions(const EnvironmentPart &part) const {
    const Mesh &mesh = part.mesh;
    const Lattice grid = part.lattice.value_or(lattice);
    for (size_t i = 0; i < mesh.positions.size(); i++) {
      const double exact = (mesh.positions[i] - grid.origin[i % 3]) / grid.step;
      const double stored = (double(float(mesh.positions[i])) - grid.origin[i % 3]) / grid.step;
      if (std::fabs(stored - std::nearbyint(exact)) > 0.49)
        throw FileError(name + ": vertex " + std::to_string(i / 3) +
                        " of the environment lies too far out for float32 on a lattice of this step");
    }
  }

  void add(const EnvironmentPart &part) {
    check_writable(part.mesh, name);
    check_positions(part);
    Json attributes = {{"POSITION", floats(part.mesh.positions, 3, true)}};
    if (!part.mesh.normals.empty()) attributes["NORMAL"] = floats(part.mesh.normals, 3, false);
    if (!part.mesh.texture.empty()) attributes["TEXCOORD_0"] = floats(part.mesh.texture, 2, false);
    Json surface = {{"baseColorFactor", {part.colour[0], part.colour[1], part.colour[2], 1}},
                    {"metallicFactor", 0},
                    {"roughnessFactor", 1}};
    if (part.picture) surface["baseColorTexture"] = {{"index", texture(part)}};
    Json material = {{"pbrMetallicRoughness", surface}};
    if (part.double_sided) material["doubleSided"] = true;
    if (part.unlit) {
      use("KHR_materials_unlit");
      material["extensions"] = {{"KHR_materials_unlit", Json::object()}};
    }
    document["materials"].push_back(material);
    document["meshes"].push_back({{"primitives",
                                   {{{"attributes", attributes},
                                     {"indices", corners(part.mesh.faces)},
                                     {"material", document["materials"].size() - 1}}}}});
    document["nodes"].push_back({{"mesh", document["meshes"].size() - 1}});
  }

  size_t texture(const EnvironmentPart &part) {
    Json entry = {{"source", *part.picture}};
    if (part.clamped) {
      document["samplers"] = {{{"wrapS", clamp_to_edge}, {"wrapT", clamp_to_edge}}};
      entry["sampler"] = 0;
    }
    document["textures"].push_back(entry);
    return document["textures"].size() - 1;
  }

  // The rotation that turns -z into a direction, the shortest way.
  static Json turn(const double (&d)[3]) {
    double q[4] = {d[1], -d[0], 0, 1 - d[2]};
    if (!gltf::normalise(q)) return {1, 0, 0, 0};
    return {q[0], q[1], q[2], q[3]};
  }

  void add_lights() {
    use("KHR_lights_punctual");
    Json list = Json::array();
    for (const fvv_light &light : environment.lights) {
      const bool directed = light.type != FVV_LIGHT_POINT, placed = light.type != FVV_LIGHT_DIRECTIONAL;
      Json entry = {{"type", !placed    ? "directional"
                             : directed ? "spot"
                                        : "point"},
                    {"color", {light.colour[0], light.colour[1], light.colour[2]}},
                    {"intensity", light.intensity},
                    {"extras", {{"casts_shadows", (light.flags & FVV_LIGHT_CASTS_SHADOWS) != 0}}}};
      if (light.range > 0) entry["range"] = light.range;
      if (light.type == FVV_LIGHT_SPOT)
        entry["spot"] = {{"innerConeAngle", light.inner_cone}, {"outerConeAngle", light.outer_cone}};
      Json node = Json::object();
      if (placed) node["translation"] = {light.position[0], light.position[1], light.position[2]};
      if (directed) node["rotation"] = turn(light.direction);
      node["extensions"] = {{"KHR_lights_punctual", {{"light", list.size()}}}};
      list.push_back(entry);
      document["nodes"].push_back(node);
    }
    document["extensions"] = {{"KHR_lights_punctual", {{"lights", list}}}};
  }

  std::string glb() const {
    std::string text = document.dump();
    while (text.size() % 4) text += ' ';
    const uint64_t size = 12 + 8 + uint64_t(text.size()) + 8 + binary.size();
    if (size > UINT32_MAX) throw FileError(name + ": the environment has more than 4 GiB");
    std::string out = "glTF";
    put(out, 2);
    put(out, uint32_t(size));
    put(out, uint32_t(text.size()));
    out += "JSON" + text;
    put(out, uint32_t(binary.size()));
    out.append("BIN\0", 4);
    return out + binary;
  }

  const Environment &environment;
  const Lattice &lattice;
  const std::string &name;
  Json document, used = Json::array();
  std::string binary;
};

} // namespace

std::string format_environment(const Environment &environment, const Lattice &lattice,
                               const std::string &name) {
  return Writer(environment, lattice, name).write();
}

} // namespace fvv::capture
