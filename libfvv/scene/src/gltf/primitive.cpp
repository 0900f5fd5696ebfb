// The base colour of a primitive (glTF 2.0 clause 3.9.2): its image and texture coordinates. An atlas needs
// nothing else of a material.

#include "fvv_cxx/untrusted.h"
#include "fvv_media/colour.h"
#include "scene/src/drc_points.h"
#include "scene/src/gltf/scene.h"

#include <algorithm>
#include <cmath>

namespace fvv::scene::gltf {

namespace {

void read_pair(const JsonValue &transform, const char *key, double (&out)[2]) {
  const auto pair = transform.find(key);
  for (size_t k = 0; pair && k < 2; k++) out[k] = pair->items(2, k).number();
}

// Cosine and sine by their series: those of libraries differ between machines in their last bit.
std::array<double, 2> direction_of(double angle) {
  constexpr double quarter = 1.5707963267948966;
  const double turns = std::nearbyint(angle / quarter), rest = angle - turns * quarter;
  std::array<double, 2> out = {};
  double term = 1;
  for (int n = 0; n < 20; n++) {
    out[n % 2] += n / 2 % 2 ? -term : term;
    term *= rest / (n + 1);
  }
  for (double left = turns - 4 * std::floor(turns / 4); left > 0; left--) out = {-out[1], out[0]};
  return out;
}

// The extension KHR_texture_transform of Khronos: scale, then rotation, then offset. The rotation is
// counter-clockwise for who sees v point down, as all viewers have it; the shader in the extension's text
// turns the other way.
void read_transform(const JsonValue &transform, BaseColour &out) {
  double scale[2] = {1, 1};
  read_pair(transform, "offset", out.offset);
  read_pair(transform, "scale", scale);
  double angle = 0;
  if (const auto rotation = transform.find("rotation")) {
    angle = rotation->number();
    constexpr double most = 1e6; // beyond, radians in float32 have no direction
    if (!(std::abs(angle) <= most)) rotation->fail("expected radians, found " + rotation->found());
  }
  const auto [cosine, sine] = direction_of(angle);
  out.turn = {{{cosine * scale[0], sine * scale[1]}, {-sine * scale[0], cosine * scale[1]}}};
  if (const auto set = transform.find("texCoord")) out.set = set->integer(0, INT32_MAX);
}

// Where a texture has its picture in a format that glTF itself does not have.
JsonValue other_source(const JsonValue &texture) {
  if (const auto extensions = texture.find("extensions"))
    for (const char *name :
         {"EXT_texture_webp", "KHR_texture_basisu", "EXT_texture_avif", "MSFT_texture_dds"})
      if (const auto extension = extensions->find(name))
        if (const auto source = extension->find("source")) return *source;
  return texture.at("source");
}

} // namespace

std::optional<JsonValue> colour_texture(const JsonValue &material) {
  const auto inside = [&](const std::optional<JsonValue> &object, const char *key) {
    return object ? object->find(key) : std::nullopt;
  };
  if (auto base = inside(material.find("pbrMetallicRoughness"), "baseColorTexture")) return base;
  const auto extensions = material.find("extensions");
  if (auto diffuse = inside(inside(extensions, "KHR_materials_pbrSpecularGlossiness"), "diffuseTexture"))
    return diffuse;
  return material.find("emissiveTexture");
}

std::optional<std::array<double, 3>> base_factor(const JsonValue &material) {
  std::optional<JsonValue> factor;
  if (const auto metallic = material.find("pbrMetallicRoughness")) factor = metallic->find("baseColorFactor");
  if (const auto extensions = material.find("extensions"); extensions && !factor)
    if (const auto glossy = extensions->find("KHR_materials_pbrSpecularGlossiness"))
      factor = glossy->find("diffuseFactor");
  if (!factor) return std::nullopt;
  std::array<double, 3> out;
  for (size_t k = 0; k < 3; k++) out[k] = factor->items(4, k).number();
  return out;
}

uint8_t display_of_light(double light) {
  static const std::vector<float> thresholds = media::srgb_thresholds(255);
  return uint8_t(std::upper_bound(thresholds.begin(), thresholds.end(), light) - thresholds.begin());
}

BaseColour read_base_colour(const Container &container, const JsonValue &primitive) {
  BaseColour out;
  const auto reference = primitive.find("material");
  if (!reference) return out;
  const auto info = colour_texture(container.item("materials", *reference));
  if (!info) return out;
  const JsonValue texture = container.item("textures", info->at("index"));
  const auto plain = texture.find("source");
  const JsonValue source = plain ? *plain : other_source(texture);
  container.item("images", source);
  out.image = source.integer(0, INT32_MAX);
  if (const auto reference_of_sampler = texture.find("sampler")) {
    const JsonValue sampler = container.item("samplers", *reference_of_sampler);
    for (size_t k = 0; k < 2; k++)
      if (const auto code = sampler.find(k ? "wrapT" : "wrapS"))
        out.wrap[k] = code->integer(0, INT32_MAX) == 33071   ? Wrap::clamp
                      : code->integer(0, INT32_MAX) == 33648 ? Wrap::mirror
                                                             : Wrap::repeat;
  }
  if (const auto set = info->find("texCoord")) out.set = set->integer(0, INT32_MAX);
  if (const auto extensions = info->find("extensions"))
    if (const auto transform = extensions->find("KHR_texture_transform")) read_transform(*transform, out);
  return out;
}

void BaseColour::transform(std::vector<double> &texture) const {
  for (size_t i = 0; i + 1 < texture.size(); i += 2) {
    const double u = texture[i], v = texture[i + 1];
    for (size_t k = 0; k < 2; k++) texture[i + k] = u * turn[k][0] + v * turn[k][1] + offset[k];
  }
}

namespace {

constexpr int draco_sets = 16; // of texture coordinates, joints and weights, that are looked for

enum : int64_t { mode_triangles = 4, mode_strip = 5, mode_fan = 6 };

class PrimitiveReader {
public:
  PrimitiveReader(Container &source, const JsonValue &value)
      : container(source), json(value), attributes(value.at("attributes")) {}

  Primitive read(int64_t mode, Texture texture, bool normals) {
    if (const auto material = json.find("material")) {
      container.item("materials", *material);
      out.material = material->integer(0, INT32_MAX);
    }
    if (const auto extensions = json.find("extensions"))
      if (const auto compressed = extensions->find("KHR_draco_mesh_compression"))
        read_draco(*compressed, mode, normals, texture == Texture::colours || texture == Texture::pictures);
    out.positions = numbers("POSITION", attributes.at("POSITION"), Purpose::positions);
    read_triangles(mode);
    if (texture == Texture::colours) read_colours();
    const bool optional = texture == Texture::materials || texture == Texture::pictures,
               uses_pairs = texture != Texture::colours;
    if (uses_pairs && texture != Texture::skipped && (!optional || read_base_colour(container, json).image))
      read_texture();
    if (texture == Texture::pictures) {
      out.texture.resize(2 * out.vertex_count());
      read_tint();
    }
    if (const auto reference = attributes.find("NORMAL"); normals && reference)
      out.normals = per_vertex("NORMAL", *reference, Purpose::normals, 3);
    read_joints();
    if (const auto targets = json.find("targets"))
      for (size_t i = 0; i < targets->size(); i++) read_target(targets->item(i));
    return std::move(out);
  }

private:
  // Draco holds indices and some of the attributes; accessors still declare their layout.
  void read_draco(const JsonValue &compressed, int64_t mode, bool normals, bool colours) {
    if (mode != mode_triangles) json.fail("expected triangles (mode 4) in a mesh compressed by Draco");
    identifiers = compressed.at("attributes");
    std::vector<uint32_t> wanted;
    const auto want = [&](const std::string &semantic) {
      if (const auto id = identifiers->find(semantic.c_str())) {
        wanted.push_back(static_cast<uint32_t>(id->integer(0, UINT32_MAX)));
        draco_ids[semantic] = wanted.back();
      }
    };
    want("POSITION");
    if (normals) want("NORMAL");
    if (colours) want("COLOR_0");
    for (const char *kind : {"TEXCOORD_", "JOINTS_", "WEIGHTS_"})
      for (int set = 0; set < draco_sets; set++) want(kind + std::to_string(set));
    draco = parse_drc_points(container.view(compressed.at("bufferView")).bytes, compressed.place(),
                             limits_or_default(nullptr), wanted);
    container.charge(json, draco->triangles.size());
  }

  // The numbers of an attribute, compressed or not.
  std::vector<double> numbers(const std::string &semantic, const JsonValue &reference, Purpose purpose) {
    const auto id = draco_ids.find(semantic);
    if (id == draco_ids.end()) {
      if (identifiers && identifiers->find(semantic.c_str()))
        identifiers->fail("expected at most " + std::to_string(draco_sets) + " sets, found " + semantic);
      return accessor_numbers(container, reference, purpose);
    }
    const Layout layout = accessor_layout(container, reference, purpose);
    const JsonValue accessor = container.item("accessors", reference);
    const DrcValues &values = draco->attributes.at(id->second);
    if (values.type != layout.type || values.components != layout.components || draco->count != layout.count)
      accessor.fail("expected what Draco holds: " + std::to_string(draco->count) + " elements of " +
                    std::to_string(values.components) + " components of type " + std::to_string(values.type));
    container.charge(accessor, layout.count * layout.components);
    return unpack(layout, values.bytes, layout.element_size(), accessor);
  }

  void read_triangles(int64_t mode) {
    std::vector<uint32_t> corners;
    if (draco) {
      out.triangles = draco->triangles;
      return;
    }
    if (const auto reference = json.find("indices")) {
      const JsonValue accessor = container.item("accessors", *reference);
      for (const double index : accessor_numbers(container, *reference, Purpose::indices)) {
        if (index >= static_cast<double>(out.vertex_count()))
          accessor.fail("element " + std::to_string(corners.size()) + ": index " +
                        std::to_string(static_cast<uint64_t>(index)) + " of " +
                        std::to_string(out.vertex_count()) + " vertices");
        corners.push_back(static_cast<uint32_t>(index));
      }
    } else {
      for (size_t i = 0; i < out.vertex_count(); i++) corners.push_back(static_cast<uint32_t>(i));
    }
    if (corners.size() < 3 || (mode == mode_triangles && corners.size() % 3))
      json.fail(std::string("expected ") + (mode == mode_triangles ? "a multiple of 3" : "at least 3") +
                " corners, found " + std::to_string(corners.size()));
    if (mode == mode_triangles) {
      out.triangles = std::move(corners);
      return;
    }
    for (size_t i = 0; i + 2 < corners.size(); i++) {
      // Clause 3.7.2.1: every second triangle of a strip turns the other way.
      const size_t odd = i % 2;
      if (mode == mode_strip)
        out.triangles.insert(out.triangles.end(), {corners[i], corners[i + 1 + odd], corners[i + 2 - odd]});
      else
        out.triangles.insert(out.triangles.end(), {corners[i + 1], corners[i + 2], corners[0]});
    }
  }

  std::vector<double> per_vertex(const std::string &semantic, const JsonValue &reference, Purpose purpose,
                                 size_t width) {
    std::vector<double> found = numbers(semantic, reference, purpose);
    if (found.size() != out.vertex_count() * width)
      container.item("accessors", reference)
          .fail("expected an element for each of " + std::to_string(out.vertex_count()) +
                " vertices, found " + std::to_string(found.size() / width));
    return found;
  }

  void read_texture() {
    const BaseColour colour = read_base_colour(container, json);
    const std::string key = "TEXCOORD_" + std::to_string(colour.set);
    out.texture = per_vertex(key, attributes.at(key.c_str()), Purpose::texture, 2);
    colour.transform(out.texture);
    out.image = colour.image;
    out.wrap = colour.wrap;
  }

  std::array<double, 3> material_factor() {
    std::optional<std::array<double, 3>> factor;
    if (out.material) factor = base_factor(container.item("materials", json.at("material")));
    return factor.value_or(std::array<double, 3>{1, 1, 1});
  }

  // Of the picture that is shown: what a material emits has a factor of its own.
  std::array<double, 3> picture_factor() {
    if (!out.image) return material_factor();
    const JsonValue material = container.item("materials", json.at("material"));
    const auto shown = colour_texture(material), emitted = material.find("emissiveTexture");
    if (!emitted || shown->place() != emitted->place()) return material_factor();
    std::array<double, 3> factor = {1, 1, 1};
    if (const auto light = material.find("emissiveFactor"))
      for (size_t k = 0; k < 3; k++) factor[k] = light->items(3, k).number();
    return factor;
  }

  // COLOR_0: R G B of each vertex, linear; empty: there is none.
  std::vector<double> linear_colours() {
    const auto reference = attributes.find("COLOR_0");
    if (!reference) return {};
    container.charge(json, 3 * out.vertex_count());
    const bool alpha = container.item("accessors", *reference).at("type").text() == std::string("VEC4");
    const size_t width = alpha ? 4 : 3;
    const std::vector<double> values =
        per_vertex("COLOR_0", *reference, alpha ? Purpose::colours_alpha : Purpose::colours, width);
    std::vector<double> colours;
    for (size_t i = 0; i < values.size(); i += width)
      colours.insert(colours.end(), &values[i], &values[i] + 3);
    return colours;
  }

  // Of vertices times that of the material.
  void read_colours() {
    const std::array<double, 3> factor = material_factor();
    std::vector<double> colours = linear_colours();
    if (colours.empty()) {
      if (factor == std::array<double, 3>{1, 1, 1}) return;
      container.charge(json, 3 * out.vertex_count());
      colours.resize(3 * out.vertex_count(), 1);
    }
    for (size_t i = 0; i < colours.size(); i++)
      out.colours.push_back(display_of_light(colours[i] * factor[i % 3]));
  }

  // A factor, and a colour that all vertices share, change a picture, or the one colour of a material; unlike
  // colours of vertices cannot.
  void read_tint() {
    constexpr double unlike = 0.5 / 255;
    out.tint = picture_factor();
    const std::vector<double> colours = linear_colours();
    for (size_t i = 3; i < colours.size(); i++)
      out.has_unlike_colours = out.has_unlike_colours || std::abs(colours[i] - colours[i % 3]) > unlike;
    for (size_t k = 0; k < 3 && !out.has_unlike_colours && !colours.empty(); k++) out.tint[k] *= colours[k];
  }

  void read_joints() {
    std::vector<std::vector<double>> joints, weights;
    for (;;) {
      const std::string set = std::to_string(joints.size());
      const auto joint_key = attributes.find(("JOINTS_" + set).c_str()),
                 weight_key = attributes.find(("WEIGHTS_" + set).c_str());
      if (!joint_key != !weight_key)
        attributes.fail("expected JOINTS_" + set + " and WEIGHTS_" + set + " together, found one of them");
      if (!joint_key) break;
      joints.push_back(per_vertex("JOINTS_" + set, *joint_key, Purpose::joints, 4));
      weights.push_back(per_vertex("WEIGHTS_" + set, *weight_key, Purpose::weights, 4));
    }
    if (joints.empty()) return;
    for (size_t vertex = 0; vertex < out.vertex_count(); vertex++) {
      out.first.push_back(out.influences.size());
      double sum = 0;
      for (size_t set = 0; set < joints.size(); set++)
        for (size_t i = vertex * 4; i < vertex * 4 + 4; i++) {
          const double weight = weights[set][i];
          if (weight < 0)
            attributes.fail("vertex " + std::to_string(vertex) + ": expected weights of 0 or more");
          if (weight == 0) continue;
          const uint32_t joint = static_cast<uint32_t>(joints[set][i]);
          out.joint_count = std::max(out.joint_count, joint + 1);
          out.influences.push_back({joint, weight});
          sum += weight;
        }
      if (!(sum > 0)) attributes.fail("vertex " + std::to_string(vertex) + ": its weights add up to 0");
      // Weights are rounded in the file: without this the vertex would move towards the origin.
      for (size_t i = out.first.back(); i < out.influences.size(); i++) out.influences[i].weight /= sum;
    }
    out.first.push_back(out.influences.size());
  }

  void read_target(const JsonValue &target) {
    const auto reference = target.find("POSITION");
    out.targets.push_back(reference ? per_vertex("", *reference, Purpose::displacements, 3)
                                    : std::vector<double>());
    const auto normals = target.find("NORMAL");
    out.normal_targets.push_back(normals && !out.normals.empty()
                                     ? per_vertex("", *normals, Purpose::displacements, 3)
                                     : std::vector<double>());
  }

  Container &container;
  const JsonValue &json;
  const JsonValue attributes;
  std::optional<JsonValue> identifiers;      // when the primitive is compressed: of its attributes
  std::optional<DrcPoints> draco;            // likewise
  std::map<std::string, uint32_t> draco_ids; // of the attributes in it
  Primitive out;
};

} // namespace

MeshData read_mesh_data(Container &container, const JsonValue &mesh, MeshReport &report, Texture texture,
                        bool normals) {
  MeshData out;
  out.used = true;
  const JsonValue primitives = mesh.at("primitives");
  size_t targets = 0;
  for (size_t i = 0; i < primitives.size(); i++) {
    const JsonValue primitive = primitives.item(i);
    const auto mode_key = primitive.find("mode");
    const int64_t mode = mode_key ? mode_key->integer(0, 6) : int64_t(mode_triangles);
    if (mode < mode_triangles) {
      report.lines_and_points++;
      continue;
    }
    out.primitives.push_back(PrimitiveReader(container, primitive).read(mode, texture, normals));
    const size_t found = out.primitives.back().targets.size();
    if (out.primitives.size() > 1 && found != targets)
      primitive.fail("expected " + std::to_string(targets) + " targets as in the first primitive, found " +
                     std::to_string(found));
    targets = found;
  }
  out.weights.resize(targets);
  if (const auto weights = mesh.find("weights"))
    for (size_t i = 0; i < targets; i++) out.weights[i] = weights->items(targets, i).number();
  return out;
}

} // namespace fvv::scene::gltf
