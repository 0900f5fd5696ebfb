// A glTF file as an environment: geometry through the scene's reader, materials and lights from here.

#include "fvv_scene/environment.h"
#include "fvv_cxx/untrusted.h"
#include "fvv_scene/file_io.h"
#include "scene/src/gltf/pose.h"
#include "scene/src/gltf/writer.h"
#include "scene/src/mesh_build.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace fvv::scene {

namespace gltf {

namespace {

constexpr int64_t clamp_to_edge = 33071, mirrored_repeat = 33648, repeat = 10497;
constexpr double quarter_turn = 0.78539816339744828, half_turn = 1.5707963267948966;

bool has_extension(const JsonValue &value, const char *name) {
  const auto extensions = value.find("extensions");
  return extensions && extensions->find(name);
}

class EnvironmentReader {
public:
  EnvironmentReader(std::string_view bytes, const std::string &path, const fvv_limits &limits)
      : container(bytes, path), root(container.root()),
        scene(read_scene(bytes, path, NoAnimation{}, limits, Texture::materials, true)) {}

  Environment read() {
    for (PosedPart &posed : pose_parts(scene)) add(std::move(posed));
    for (EnvironmentPart &part : out.parts)
      if (part.mesh.normals.size() != part.mesh.positions.size()) part.mesh.normals.clear();
    read_lights();
    if (scene.report.lines_and_points) note("lines and points");
    return std::move(out);
  }

private:
  void note(const std::string &what) {
    const std::string text = what + " are left out";
    if (std::find(out.notes.begin(), out.notes.end(), text) == out.notes.end()) out.notes.push_back(text);
  }

  // All of one material is one part.
  void add(PosedPart &&posed) {
    const int64_t key = posed.material.value_or(-1);
    const auto [found, fresh] = part_of.emplace(key, out.parts.size());
    if (fresh) {
      out.parts.emplace_back();
      if (posed.material) read_material(root.at("materials").item(size_t(*posed.material)), out.parts.back());
    }
    EnvironmentPart &part = out.parts[found->second];
    const uint32_t base = uint32_t(part.mesh.vertex_count());
    for (const uint32_t corner : posed.mesh.faces) part.mesh.faces.push_back(base + corner);
    const auto append = [](std::vector<double> &to, const std::vector<double> &from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(part.mesh.positions, posed.mesh.positions);
    append(part.mesh.texture, posed.mesh.texture);
    append(part.mesh.normals, posed.mesh.normals);
  }

  void read_material(const JsonValue &material, EnvironmentPart &part) {
    if (const auto sides = material.find("doubleSided")) part.double_sided = sides->boolean();
    part.unlit = has_extension(material, "KHR_materials_unlit");
    if (const auto alpha = material.find("alphaMode"); alpha && alpha->text() != "OPAQUE")
      note("transparency and cut-outs");
    if (material.find("emissiveTexture") || material.find("normalTexture"))
      note("emissive and normal textures");
    const auto metallic = material.find("pbrMetallicRoughness");
    if (!metallic) return;
    if (const auto factor = metallic->find("baseColorFactor"))
      for (size_t k = 0; k < 3; k++) {
        const JsonValue value = factor->items(4, k);
        part.colour[k] = value.number();
        if (!(part.colour[k] >= 0 && part.colour[k] <= 1))
          value.fail("expected 0 to 1, found " + value.found());
      }
    if (const auto info = metallic->find("baseColorTexture")) read_texture(*info, part);
  }

  void read_texture(const JsonValue &info, EnvironmentPart &part) {
    const JsonValue texture = container.item("textures", info.at("index"));
    const JsonValue source = texture.at("source");
    container.item("images", source);
    const int64_t image = source.integer(0, INT32_MAX);
    const auto [found, fresh] = picture_of.emplace(image, out.pictures.size());
    if (fresh) out.pictures.push_back(container.image(size_t(image)));
    part.picture = found->second;
    const auto reference = texture.find("sampler");
    if (!reference) return;
    const JsonValue sampler = container.item("samplers", *reference);
    const auto wrap = [&](const char *key) {
      const auto value = sampler.find(key);
      return value ? value->integer(0, INT32_MAX) : repeat;
    };
    const int64_t s = wrap("wrapS"), t = wrap("wrapT");
    part.clamped = s == clamp_to_edge && t == clamp_to_edge;
    if (s == mirrored_repeat || t == mirrored_repeat || s != t)
      note("mirrored and mixed repetition of textures, which repeat instead,");
  }

  void read_lights() {
    const std::vector<Transform> places = global_transforms(scene);
    for (uint32_t i = 0; i < scene.nodes.size(); i++) {
      if (!scene.visible[i]) continue;
      const auto extensions = root.at("nodes").item(i).find("extensions");
      const auto lights = extensions ? extensions->find("KHR_lights_punctual") : std::nullopt;
      if (lights) read_light(lights->at("light"), places[i]);
    }
  }

  void read_light(const JsonValue &reference, const Transform &place) {
    const JsonValue list = root.at("extensions").at("KHR_lights_punctual").at("lights");
    const int64_t index = reference.integer(0, INT32_MAX);
    if (size_t(index) >= list.size())
      reference.fail("expected one of " + std::to_string(list.size()) + " lights, found " +
                     reference.found());
    const JsonValue json = list.item(size_t(index));
    fvv_light light = {};
    const std::string type = json.at("type").text();
    if (type != "directional" && type != "point" && type != "spot")
      json.at("type").fail("expected directional, point or spot, found " + json.at("type").found());
    light.type = type == "directional" ? FVV_LIGHT_DIRECTIONAL
                 : type == "point"     ? FVV_LIGHT_POINT
                                       : FVV_LIGHT_SPOT;
    const auto extras = json.find("extras");
    const auto shadows = extras && extras->is_object() ? extras->find("casts_shadows") : std::nullopt;
    light.flags = !shadows || shadows->boolean() ? FVV_LIGHT_CASTS_SHADOWS : 0;
    const auto number = [](const JsonValue &from, const char *key, double absent, double most) {
      const auto value = from.find(key);
      if (!value) return absent;
      if (!(value->number() >= 0 && value->number() <= most))
        value->fail("expected a number from 0 on, at most " + std::to_string(most) + ", found " +
                    value->found());
      return value->number();
    };
    const auto colour = json.find("color");
    for (size_t k = 0; k < 3; k++) {
      light.colour[k] = colour ? colour->items(3, k).number() : 1;
      if (!(light.colour[k] >= 0 && light.colour[k] <= 1))
        colour->fail("expected numbers from 0 to 1, found " + colour->items(3, k).found());
    }
    light.intensity = number(json, "intensity", 1, 1e30);
    if (light.type != FVV_LIGHT_DIRECTIONAL) {
      light.range = number(json, "range", 0, 1e30);
      for (size_t k = 0; k < 3; k++) light.position[k] = place.m[4 * k + 3];
    }
    if (light.type != FVV_LIGHT_POINT) set_direction(reference, place, light);
    if (light.type == FVV_LIGHT_SPOT) {
      const auto spot = json.find("spot");
      light.inner_cone = spot ? number(*spot, "innerConeAngle", 0, half_turn) : 0;
      light.outer_cone = spot ? number(*spot, "outerConeAngle", quarter_turn, half_turn) : quarter_turn;
      if (!(light.inner_cone < light.outer_cone)) json.fail("expected innerConeAngle below outerConeAngle");
    }
    out.lights.push_back(light);
  }

  // Along -z of the node.
  static void set_direction(const JsonValue &reference, const Transform &place, fvv_light &light) {
    double square = 0;
    for (size_t k = 0; k < 3; k++) square += place.m[4 * k + 2] * place.m[4 * k + 2];
    const double length = std::sqrt(square);
    if (!(length > 0) || !std::isfinite(length)) reference.fail("expected a node with a direction");
    for (size_t k = 0; k < 3; k++) light.direction[k] = -place.m[4 * k + 2] / length;
  }

  Container container;
  const JsonValue root;
  const Scene scene;
  std::map<int64_t, size_t> part_of, picture_of; // by material and image
  Environment out;
};

} // namespace

} // namespace gltf

Environment parse_environment(std::string_view bytes, const std::string &name, const fvv_limits *limits) {
  return gltf::EnvironmentReader(bytes, name, limits_or_default(limits)).read();
}

void Environment::transform(const gltf::Transform &by) {
  const auto move = [&](double *at) {
    const double point[3] = {at[0], at[1], at[2]};
    double moved[3];
    by.apply(point, moved);
    std::copy_n(moved, 3, at);
  };
  // m[3], m[7] and m[11] move places, not directions.
  gltf::Transform turn = by;
  turn.m[3] = turn.m[7] = turn.m[11] = 0;
  const bool mirrors = by.determinant() < 0;
  for (EnvironmentPart &part : parts) {
    for (size_t i = 0; i < part.mesh.positions.size(); i += 3) move(&part.mesh.positions[i]);
    for (size_t i = 0; i < part.mesh.normals.size(); i += 3) {
      const double normal[3] = {part.mesh.normals[i], part.mesh.normals[i + 1], part.mesh.normals[i + 2]};
      double moved[3];
      by.apply_normal(normal, moved);
      std::copy_n(moved, 3, &part.mesh.normals[i]);
    }
    for (size_t i = 0; mirrors && i < part.mesh.faces.size(); i += 3)
      std::swap(part.mesh.faces[i + 1], part.mesh.faces[i + 2]);
  }
  const double scale = std::cbrt(std::fabs(by.determinant()));
  for (fvv_light &light : lights) {
    if (light.type != FVV_LIGHT_DIRECTIONAL) move(light.position);
    light.range *= scale;
    if (light.type == FVV_LIGHT_POINT) continue;
    const double direction[3] = {light.direction[0], light.direction[1], light.direction[2]};
    double moved[3];
    turn.apply(direction, moved);
    const double length = std::sqrt(moved[0] * moved[0] + moved[1] * moved[1] + moved[2] * moved[2]);
    for (size_t k = 0; k < 3; k++) light.direction[k] = moved[k] / length;
  }
}

namespace {

using Json = gltf::Writer::Json;

class EnvironmentWriter {
public:
  EnvironmentWriter(const Environment &source, const Lattice &grid, const std::string &file)
      : environment(source), lattice(grid), name(file), out(file) {
    gltf::Bounds<double> bounds;
    for (const EnvironmentPart &part : environment.parts)
      for (size_t i = 0; i < part.mesh.positions.size(); i++) bounds.add(i % 3, part.mesh.positions[i]);
    origin = gltf::local_origin(lattice, bounds);
  }
  bool is_local() const { return origin.has_value(); }

  std::string write() {
    for (const std::string &picture : environment.pictures) out.image(picture);
    for (const EnvironmentPart &part : environment.parts) add(part);
    if (!environment.lights.empty()) add_lights();
    return out.glb();
  }

private:
  // As a float32, a coordinate has to round to its own lattice point.
  void check_positions(const EnvironmentPart &part) const {
    const Lattice grid = part.lattice.value_or(lattice);
    const std::vector<double> &positions = part.mesh.positions;
    for (size_t i = 0; i < positions.size(); i++) {
      const double index = std::nearbyint((positions[i] - grid.origin[i % 3]) / grid.step);
      const double from = origin ? (*origin)[i % 3] : 0;
      gltf::check_on_lattice(double(float(positions[i] - from)) + from,
                             grid.origin[i % 3] + index * grid.step, i / 3, grid.step, name);
    }
  }

  void add(const EnvironmentPart &part) {
    geometry::check(part.mesh, name);
    check_positions(part);
    std::vector<double> positions = part.mesh.positions;
    for (size_t i = 0; origin && i < positions.size(); i++) positions[i] -= (*origin)[i % 3];
    Json attributes = {{"POSITION", out.floats(positions, 3, true)}};
    if (!part.mesh.normals.empty()) attributes["NORMAL"] = out.floats(part.mesh.normals, 3, false);
    if (!part.mesh.texture.empty()) attributes["TEXCOORD_0"] = out.floats(part.mesh.texture, 2, false);
    const gltf::Surface surface = {{part.colour[0], part.colour[1], part.colour[2]},
                                   part.picture,
                                   part.clamped,
                                   part.unlit,
                                   part.double_sided};
    const size_t material = out.material(surface);
    out.list("meshes").push_back({{"primitives",
                                   {{{"attributes", attributes},
                                     {"indices", out.corners(part.mesh.faces)},
                                     {"material", material}}}}});
    Json node = {{"mesh", out.list("meshes").size() - 1}};
    if (origin) gltf::Writer::place(*origin, node);
    out.list("nodes").push_back(node);
  }

  // The rotation that turns -z into a direction, the shortest way.
  static Json turn(const double (&d)[3]) {
    double q[4] = {d[1], -d[0], 0, 1 - d[2]};
    if (!gltf::normalise(q)) return {1, 0, 0, 0};
    return {q[0], q[1], q[2], q[3]};
  }

  void add_lights() {
    out.use("KHR_lights_punctual");
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
      out.list("nodes").push_back(node);
    }
    out.extensions() = {{"KHR_lights_punctual", {{"lights", list}}}};
  }

  const Environment &environment;
  const Lattice &lattice;
  std::optional<std::array<double, 3>> origin; // of all positions; none: they are those of the world
  const std::string &name;
  gltf::Writer out;
};

} // namespace

std::string format_environment(const Environment &environment, const Lattice &lattice,
                               const std::string &name, bool *is_local) {
  EnvironmentWriter writer(environment, lattice, name);
  if (is_local) *is_local = writer.is_local();
  return writer.write();
}

} // namespace fvv::scene
