// Nodes, skins and the animation of a file.

#include "scene/src/gltf/scene.h"
#include "fvv_cxx/untrusted.h"
#include "fvv_scene/file_io.h"

#include <algorithm>

namespace fvv::scene::gltf {

namespace {

// Spherical linear interpolation along the shorter arc, by halving it: the middle of two unit quaternions is
// their sum made as long as 1. Sines would do the same, but are not the same on every machine. After 27
// halvings arc and chord differ by less than a double can tell.
void slerp(const double *from, const double *to, double share, double *out) {
  double low[4], high[4], dot = 0;
  std::copy_n(from, 4, low);
  for (size_t k = 0; k < 4; k++) dot += from[k] * to[k];
  for (size_t k = 0; k < 4; k++) high[k] = dot < 0 ? -to[k] : to[k];
  for (int halving = 0; halving < 27; halving++) {
    double middle[4];
    for (size_t k = 0; k < 4; k++) middle[k] = low[k] + high[k];
    normalise(middle); // at most a right angle apart: never zero
    share *= 2;
    if (share < 1) {
      std::copy_n(middle, 4, high);
    } else {
      std::copy_n(middle, 4, low);
      share -= 1;
    }
  }
  for (size_t k = 0; k < 4; k++) out[k] = low[k] + share * (high[k] - low[k]);
}

Interpolation read_interpolation(const JsonValue &sampler) {
  const auto value = sampler.find("interpolation");
  if (!value) return Interpolation::linear;
  const std::string text = value->text();
  if (text == "STEP") return Interpolation::step;
  if (text == "LINEAR") return Interpolation::linear;
  if (text != "CUBICSPLINE") value->fail("expected STEP, LINEAR or CUBICSPLINE, found " + value->found());
  return Interpolation::cubic_spline;
}

Purpose purpose_of(Path path) {
  return path == Path::rotation  ? Purpose::rotations
         : path == Path::weights ? Purpose::amounts
                                 : Purpose::vectors;
}

} // namespace

Channel read_channel(Container &container, const JsonValue &channel, const JsonValue &samplers, Path path,
                     size_t width) {
  const JsonValue reference = channel.at("sampler");
  const int64_t index = reference.integer(0, INT32_MAX);
  if (static_cast<uint64_t>(index) >= samplers.size())
    reference.fail("expected one of " + std::to_string(samplers.size()) + " samplers, found " +
                   reference.found());
  const JsonValue sampler = samplers.item(static_cast<size_t>(index)), input = sampler.at("input"),
                  output = sampler.at("output");
  Channel out = {0, path, read_interpolation(sampler), width, {}, {}, channel.place()};
  out.times = accessor_numbers(container, input, Purpose::times);
  for (size_t i = 0; i < out.times.size(); i++)
    if (out.times[i] < 0 || (i && out.times[i] <= out.times[i - 1]))
      container.item("accessors", input)
          .fail("expected times that begin at 0 or later and increase, element " + std::to_string(i) +
                " does not");
  out.values = accessor_numbers(container, output, purpose_of(path));
  const size_t expected =
      out.times.size() * width * (out.interpolation == Interpolation::cubic_spline ? 3 : 1);
  if (out.values.size() != expected)
    container.item("accessors", output)
        .fail("expected " + std::to_string(expected) + " numbers for " + std::to_string(out.times.size()) +
              " times, found " + std::to_string(out.values.size()));
  if (path == Path::rotation && out.interpolation != Interpolation::cubic_spline)
    for (size_t i = 0; i < out.values.size(); i += 4)
      if (!normalise(&out.values[i]))
        container.item("accessors", output)
            .fail("element " + std::to_string(i / 4) +
                  ": expected a rotation, found a quaternion of length 0");
  return out;
}

std::vector<double> Channel::at(double time) const {
  // Keyframes are float32: without rounding, a step that falls onto a frame would come one frame late half
  // the time.
  const double now = interpolation == Interpolation::step ? double(float(time)) : time;
  const bool cubic = interpolation == Interpolation::cubic_spline;
  const size_t pitch = cubic ? 3 * width : width, inner = cubic ? width : 0;
  const auto next = std::upper_bound(times.begin(), times.end(), now);
  const size_t high = static_cast<size_t>(next - times.begin()), low = high ? high - 1 : 0;
  std::vector<double> out(width);
  const double *from = &values[low * pitch + inner], *to = from + pitch;
  if (high == 0 || high == times.size() || interpolation == Interpolation::step) {
    std::copy_n(from, width, out.begin());
  } else {
    const double span = times[high] - times[low], s = (now - times[low]) / span;
    if (cubic) {
      const double s2 = s * s, s3 = s2 * s;
      const double *leaving = from + width, *arriving = to - width;
      for (size_t k = 0; k < width; k++)
        out[k] = (2 * s3 - 3 * s2 + 1) * from[k] + span * (s3 - 2 * s2 + s) * leaving[k] +
                 (3 * s2 - 2 * s3) * to[k] + span * (s3 - s2) * arriving[k];
    } else if (path == Path::rotation) {
      slerp(from, to, s, out.data());
    } else {
      for (size_t k = 0; k < width; k++) out[k] = from[k] + s * (to[k] - from[k]);
    }
  }
  if (path == Path::rotation && !normalise(out.data()))
    throw Error(place + ": the rotation at " + std::to_string(time) + " s has no direction");
  return out;
}

namespace {

// A node takes three bytes of JSON and hundreds in memory.
constexpr size_t max_nodes = size_t(1) << 18;
// Nodes from a root down to a leaf. Skeletons have tens; all of a longer chain would move for every frame.
constexpr uint32_t max_depth = 1024;
// Counted once for each node that draws them: an empty target is three bytes for a mesh, and work for every
// node.
constexpr uint64_t max_targets = uint64_t(1) << 20;

class SceneReader {
public:
  SceneReader(std::string_view bytes, const std::string &path, const fvv_limits &bounds, Texture wanted,
              bool with_normals)
      : container(bytes, path), root(container.root()), limits(bounds), texture(wanted),
        normals(with_normals) {
    scene.file = path;
  }

  Scene read(const AnimationChoice &choice) {
    if (count_of("nodes") > max_nodes)
      root.at("nodes").fail("expected at most " + std::to_string(max_nodes) + " nodes, found " +
                            std::to_string(count_of("nodes")));
    scene.nodes.resize(count_of("nodes"));
    for (uint32_t i = 0; i < scene.nodes.size(); i++) read_node(root.at("nodes").item(i), i);
    sort_nodes();
    select();
    scene.meshes.resize(count_of("meshes"));
    scene.skins.resize(count_of("skins"));
    for (const uint32_t node : scene.drawn) read_drawn(node);
    if (faces == 0) root.fail("expected a scene with at least one triangle, found none");
    if (texture == Texture::coordinates || texture == Texture::picture) read_image();
    if (texture == Texture::pictures) read_pictures();
    if (!std::holds_alternative<NoAnimation>(choice)) read_animation(choose(choice));
    return std::move(scene);
  }

private:
  size_t count_of(const char *list) const {
    const auto array = root.find(list);
    return array ? array->size() : 0;
  }
  // The index that reference is, checked.
  uint32_t index_of(const char *list, const JsonValue &reference) const {
    container.item(list, reference);
    return static_cast<uint32_t>(reference.integer(0, INT32_MAX));
  }
  // Of an instance, that of the node that it is an instance of.
  JsonValue node_json(uint32_t node) const {
    const size_t own = count_of("nodes");
    return root.at("nodes").item(node < own ? node : described_by[node - own]);
  }

  static void read_vector(const JsonValue &node, const char *key, double *out, size_t count) {
    const auto value = node.find(key);
    for (size_t k = 0; value && k < count; k++) out[k] = value->items(count, k).number();
  }

  void read_node(const JsonValue &json, uint32_t index) {
    Node &node = scene.nodes[index];
    if (const auto matrix = json.find("matrix")) {
      node.matrix.emplace();
      // Columns, the last row of which is 0 0 0 1.
      for (size_t i = 0; i < 16; i++) {
        const double number = matrix->items(16, i).number();
        if (i % 4 < 3)
          node.matrix->m[i % 4 * 4 + i / 4] = number;
        else if (number != (i == 15 ? 1 : 0))
          matrix->fail("expected 0 0 0 1 as the last row of the matrix");
      }
    }
    read_vector(json, "translation", node.translation, 3);
    read_vector(json, "rotation", node.rotation, 4);
    read_vector(json, "scale", node.scale, 3);
    if (!normalise(node.rotation))
      json.at("rotation").fail("expected a rotation, found a quaternion without direction");
    if (const auto mesh = json.find("mesh")) node.mesh = index_of("meshes", *mesh);
    if (const auto skin = json.find("skin")) node.skin = index_of("skins", *skin);
    const auto children = json.find("children");
    for (size_t i = 0; children && i < children->size(); i++) {
      const JsonValue child = children->item(i);
      uint32_t &parent = scene.nodes[index_of("nodes", child)].parent;
      if (parent != none)
        child.fail("expected a node with one parent, found " + child.found() +
                   ", which is also a child of node " + std::to_string(parent));
      parent = index;
    }
  }

  // Every node has at most one parent: a node that cannot be reached from a root lies on a cycle or below
  // one.
  void sort_nodes() {
    std::vector<std::vector<uint32_t>> children(scene.nodes.size());
    for (uint32_t i = 0; i < scene.nodes.size(); i++) {
      const uint32_t parent = scene.nodes[i].parent;
      if (parent == none)
        scene.order.push_back(i);
      else
        children[parent].push_back(i);
    }
    std::vector<uint32_t> depth(scene.nodes.size()); // 0: not reached
    for (size_t next = 0; next < scene.order.size(); next++) {
      const uint32_t node = scene.order[next], parent = scene.nodes[node].parent;
      depth[node] = parent == none ? 1 : depth[parent] + 1;
      if (depth[node] > max_depth)
        node_json(node).fail("expected at most " + std::to_string(max_depth) +
                             " nodes one below the other, found more");
      scene.order.insert(scene.order.end(), children[node].begin(), children[node].end());
    }
    for (uint32_t i = 0; i < scene.nodes.size(); i++)
      if (!depth[i]) node_json(i).fail("expected a tree of nodes, found a cycle");
  }

  // The nodes with meshes below the roots of the default scene.
  void select() {
    const auto chosen = root.find("scene");
    if (!chosen && count_of("scenes") == 0) root.fail("expected a scene, found none");
    const JsonValue json = chosen ? container.item("scenes", *chosen) : root.at("scenes").item(0);
    std::vector<bool> &visible = scene.visible;
    visible.resize(scene.nodes.size());
    const auto roots = json.find("nodes");
    for (size_t i = 0; roots && i < roots->size(); i++) {
      const JsonValue reference = roots->item(i);
      const uint32_t node = index_of("nodes", reference);
      if (scene.nodes[node].parent != none)
        reference.fail("expected a node without parent, found a child of node " +
                       std::to_string(scene.nodes[node].parent));
      visible[node] = true;
    }
    for (const uint32_t node : scene.order) {
      if (scene.nodes[node].parent != none && visible[scene.nodes[node].parent]) visible[node] = true;
      // KHR_node_visibility: a node that is not shown hides all below it.
      if (visible[node] && is_hidden(node_json(node))) visible[node] = false;
    }
    for (uint32_t i = 0, count = uint32_t(scene.nodes.size()); i < count; i++)
      if (visible[i] && scene.nodes[i].mesh != none) add_instances(i);
    for (uint32_t i = 0; i < scene.nodes.size(); i++)
      if (visible[i] && scene.nodes[i].mesh != none) scene.drawn.push_back(i);
  }

  static std::optional<JsonValue> extension(const JsonValue &json, const char *name) {
    const auto extensions = json.find("extensions");
    return extensions ? extensions->find(name) : std::nullopt;
  }

  static bool is_hidden(const JsonValue &json) {
    const auto visibility = extension(json, "KHR_node_visibility");
    const auto shown = visibility ? visibility->find("visible") : std::nullopt;
    return shown && !shown->boolean();
  }

  // EXT_mesh_gpu_instancing: the mesh of a node several times, each by a node of its own below it.
  void add_instances(uint32_t index) {
    const auto instancing = extension(node_json(index), "EXT_mesh_gpu_instancing");
    const auto attributes = instancing ? instancing->find("attributes") : std::nullopt;
    if (!attributes) return;
    const auto read = [&](const char *key, Purpose purpose) {
      const auto reference = attributes->find(key);
      return reference ? accessor_numbers(container, *reference, purpose) : std::vector<double>();
    };
    const std::vector<double> places = read("TRANSLATION", Purpose::vectors),
                              turns = read("ROTATION", Purpose::rotations),
                              sizes = read("SCALE", Purpose::vectors);
    const size_t count = std::max({places.size() / 3, turns.size() / 4, sizes.size() / 3});
    for (const auto &[numbers, width] : {std::pair(&places, 3), std::pair(&turns, 4), std::pair(&sizes, 3)})
      if (!numbers->empty() && numbers->size() != count * size_t(width))
        attributes->fail("expected as many instances in each attribute, found " + std::to_string(count) +
                         " and " + std::to_string(numbers->size() / size_t(width)));
    if (scene.nodes.size() + count > max_nodes)
      attributes->fail("expected at most " + std::to_string(max_nodes) + " nodes and instances, found more");
    for (size_t i = 0; i < count; i++) {
      Node instance;
      if (!places.empty()) std::copy_n(&places[3 * i], 3, instance.translation);
      if (!turns.empty()) std::copy_n(&turns[4 * i], 4, instance.rotation);
      if (!sizes.empty()) std::copy_n(&sizes[3 * i], 3, instance.scale);
      if (!normalise(instance.rotation))
        attributes->fail("instance " + std::to_string(i) +
                         ": expected a rotation, found a quaternion without direction");
      instance.parent = index;
      instance.mesh = scene.nodes[index].mesh;
      scene.order.push_back(uint32_t(scene.nodes.size()));
      scene.visible.push_back(true);
      described_by.push_back(index);
      scene.nodes.push_back(std::move(instance));
    }
    scene.nodes[index].mesh = none;
  }

  void read_drawn(uint32_t index) {
    Node &node = scene.nodes[index];
    const JsonValue json = node_json(index);
    MeshData &mesh = scene.meshes[node.mesh];
    if (!mesh.used)
      mesh = read_mesh_data(container, container.item("meshes", json.at("mesh")), scene.report, texture,
                            normals);
    if (const auto weights = json.find("weights")) {
      for (size_t i = 0; i < mesh.weights.size(); i++)
        node.weights.push_back(weights->items(mesh.weights.size(), i).number());
    }
    if (node.skin != none) {
      Skin &skin = scene.skins[node.skin];
      if (skin.joints.empty()) read_skin(container.item("skins", json.at("skin")), skin);
      for (const Primitive &primitive : mesh.primitives) {
        if (primitive.first.empty())
          json.fail("has a skin: expected JOINTS_0 and WEIGHTS_0 in every primitive of its mesh");
        if (primitive.joint_count > skin.joints.size())
          json.fail("joint " + std::to_string(primitive.joint_count - 1) + " moves its mesh, its skin has " +
                    std::to_string(skin.joints.size()) + " joints");
      }
    }
    targets += mesh.weights.size();
    if (targets > max_targets)
      json.fail("expected a scene of at most " + std::to_string(max_targets) + " morph targets");
    for (const Primitive &primitive : mesh.primitives) {
      vertices += primitive.vertex_count();
      faces += primitive.triangles.size() / 3;
      if (vertices > limits.max_vertices || faces > limits.max_faces)
        json.fail("expected a scene of at most " + std::to_string(limits.max_vertices) + " vertices and " +
                  std::to_string(limits.max_faces) + " triangles");
    }
  }

  // One atlas for the whole scene: texture coordinates of another picture are meaningless on it.
  void read_image() {
    std::optional<std::optional<int64_t>> image;
    for (const uint32_t node : scene.drawn)
      for (const Primitive &primitive : scene.meshes[scene.nodes[node].mesh].primitives) {
        if (!image) image = primitive.image;
        if (primitive.image == *image) continue;
        const auto text = [](const std::optional<int64_t> &index) {
          return index ? "image " + std::to_string(*index) : std::string("none");
        };
        node_json(node).fail("expected one base colour image in the whole scene, found " + text(*image) +
                             " and " + text(primitive.image) + ": bake one atlas of them");
      }
    if (texture != Texture::picture) return;
    if (!*image) root.fail("expected a material with a baseColorTexture, found none");
    scene.picture = container.image(static_cast<size_t>(**image));
  }

  // What each primitive shows: a picture, or the colour of its material.
  void read_pictures() {
    for (const uint32_t node : scene.drawn)
      for (Primitive &primitive : scene.meshes[scene.nodes[node].mesh].primitives) {
        FacePicture one;
        std::string key;
        if (primitive.image) {
          one.wrap = primitive.wrap;
          one.tint = primitive.tint;
          key = "image " + std::to_string(*primitive.image) + " " + std::to_string(int(one.wrap[0])) +
                std::to_string(int(one.wrap[1]));
          for (const double factor : one.tint) append_double(key += " ", factor);
          one.name = scene.file + ": image " + std::to_string(*primitive.image);
          std::shared_ptr<const std::string> &bytes = images[*primitive.image];
          if (!bytes) bytes = std::make_shared<const std::string>(container.image(size_t(*primitive.image)));
          one.load = [bytes] { return *bytes; };
        } else {
          one.name = "colour";
          for (size_t k = 0; k < 3; k++) one.colour[k] = display_of_light(primitive.tint[k]);
          key.assign(one.colour.begin(), one.colour.end());
        }
        primitive.picture = uint32_t(scene.pictures.add(std::move(one), key));
      }
  }

  void read_skin(const JsonValue &json, Skin &skin) {
    const JsonValue joints = json.at("joints");
    for (size_t i = 0; i < joints.size(); i++) skin.joints.push_back(index_of("nodes", joints.item(i)));
    if (skin.joints.empty()) joints.fail("expected at least one joint, found none");
    skin.inverse_bind.resize(skin.joints.size());
    const auto reference = json.find("inverseBindMatrices");
    if (!reference) return;
    const std::vector<double> numbers = accessor_numbers(container, *reference, Purpose::matrices);
    if (numbers.size() < skin.joints.size() * 16)
      container.item("accessors", *reference)
          .fail("expected a matrix for each of " + std::to_string(skin.joints.size()) + " joints, found " +
                std::to_string(numbers.size() / 16));
    for (size_t i = 0; i < skin.joints.size(); i++)
      for (size_t row = 0; row < 3; row++)
        for (size_t column = 0; column < 4; column++)
          skin.inverse_bind[i].m[row * 4 + column] = numbers[i * 16 + column * 4 + row];
  }

  JsonValue choose(const AnimationChoice &choice) const {
    const size_t count = count_of("animations");
    if (!count) root.fail("expected an animation, found none");
    const JsonValue animations = root.at("animations");
    if (const int64_t *index = std::get_if<int64_t>(&choice)) {
      if (*index < 0 || static_cast<uint64_t>(*index) >= count)
        animations.fail("expected animation " + std::to_string(*index) + ", found " + std::to_string(count) +
                        " (they count from 0)");
      return animations.item(static_cast<size_t>(*index));
    }
    if (std::holds_alternative<OnlyAnimation>(choice) && count == 1) return animations.item(0);
    const std::string *wanted = std::get_if<std::string>(&choice);
    std::string names;
    std::optional<JsonValue> found;
    for (size_t i = 0; i < count; i++) {
      const auto name = animations.item(i).find("name");
      const std::string text = name ? name->text() : "";
      if (i < 8) names += (i ? ", " : "") + (name ? quote(text) : std::to_string(i));
      if (!wanted || !name || text != *wanted) continue;
      if (found) animations.fail("two animations are called " + quote(text) + ": name it by its index");
      found = animations.item(i);
    }
    if (count > 8) names += ", ...";
    if (!wanted)
      animations.fail("expected the index or name of one of " + std::to_string(count) +
                      " animations: " + names);
    if (!found) animations.fail("expected an animation called " + quote(*wanted) + ", found " + names);
    return *found;
  }

  void read_animation(const JsonValue &animation) {
    const JsonValue channels = animation.at("channels"), samplers = animation.at("samplers");
    for (size_t i = 0; i < channels.size(); i++) {
      const JsonValue channel = channels.item(i), target = channel.at("target"), path = target.at("path");
      const auto node_key = target.find("node");
      if (!node_key) continue; // clause 3.11: such a channel is to be ignored
      const uint32_t index = index_of("nodes", *node_key);
      const Node &node = scene.nodes[index];
      const std::string text = path.text();
      if (text == "weights") {
        // A mesh that is not drawn was not read either.
        if (node.mesh == none || !scene.meshes[node.mesh].used) continue;
        const size_t width = scene.meshes[node.mesh].weights.size();
        if (!width) path.fail("expected a node whose mesh has morph targets");
        scene.channels.push_back(read_channel(container, channel, samplers, Path::weights, width));
      } else {
        const Path kind = text == "translation" ? Path::translation
                          : text == "rotation"  ? Path::rotation
                                                : Path::scale;
        if (kind == Path::scale && text != "scale")
          path.fail("expected translation, rotation, scale or weights, found " + path.found());
        if (node.matrix) node_key->fail("expected a node without matrix, which cannot be animated");
        scene.channels.push_back(
            read_channel(container, channel, samplers, kind, kind == Path::rotation ? 4 : 3));
      }
      scene.channels.back().node = index;
    }
    if (scene.channels.empty()) animation.fail("expected an animation that moves something, found none");
  }

  Container container;
  const JsonValue root;
  const fvv_limits &limits;
  const Texture texture;
  const bool normals;
  Scene scene;
  std::map<int64_t, std::shared_ptr<const std::string>> images; // bytes
  std::vector<uint32_t> described_by;                           // of each instance: the node of the file
  uint64_t vertices = 0, faces = 0, targets = 0;                // as drawn
};

} // namespace

Scene read_scene(std::string_view bytes, const std::string &path, const AnimationChoice &choice,
                 const fvv_limits &limits, Texture texture, bool normals) {
  return SceneReader(bytes, path, limits, texture, normals).read(choice);
}

bool draws_nothing(std::string_view bytes, const std::string &path) {
  try {
    const Container container(bytes, path);
    const auto nodes = container.root().find("nodes");
    for (size_t i = 0; nodes && i < nodes->size(); i++)
      if (nodes->item(i).find("mesh")) return false;
    return true;
  } catch (const Error &) {
    return false;
  } // what is wrong is said when it is read
}

bool has_unlike_colours(std::string_view bytes, const std::string &path) {
  const Scene scene = read_scene(bytes, path, NoAnimation{}, limits_or_default(nullptr), Texture::pictures);
  return std::any_of(scene.drawn.begin(), scene.drawn.end(), [&](uint32_t node) {
    const std::vector<Primitive> &primitives = scene.meshes[scene.nodes[node].mesh].primitives;
    return std::any_of(primitives.begin(), primitives.end(),
                       [](const Primitive &one) { return one.has_unlike_colours; });
  });
}

} // namespace fvv::scene::gltf
