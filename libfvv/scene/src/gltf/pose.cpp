// Applies nodes, skins and morph targets.
#include "scene/src/gltf/pose.h"
#include "fvv_scene/transform.h"

#include <algorithm>
#include <cmath>

namespace fvv::scene::gltf {

namespace {

class Poser {
public:
  Poser(const Scene &source, std::optional<double> time) : scene(source), nodes(source.nodes) {
    if (time)
      for (const Channel &channel : scene.channels) move(channel, *time);
    global.resize(nodes.size());
    for (const uint32_t index : scene.order) {
      const Node &node = nodes[index];
      const Transform local =
          node.matrix ? *node.matrix : compose(node.translation, node.rotation, node.scale);
      global[index] = node.parent == none ? local : global[node.parent] * local;
    }
    for (const Skin &skin : scene.skins) {
      std::vector<Transform> &matrices = joints.emplace_back();
      for (size_t i = 0; i < skin.joints.size(); i++)
        matrices.push_back(global[skin.joints[i]] * skin.inverse_bind[i]);
    }
  }

  Mesh run() {
    for (const uint32_t index : scene.drawn) {
      const MeshData &data = scene.meshes[nodes[index].mesh];
      for (const Primitive &primitive : data.primitives) append(nodes[index], global[index], data, primitive);
    }
    check();
    return std::move(mesh);
  }

  // After run(). Of all vertices, or empty.
  std::vector<uint8_t> vertex_colours() {
    if (!colours.empty()) colours.resize(mesh_size, 255);
    return std::move(colours);
  }

  std::vector<PosedPart> run_parts() {
    std::vector<PosedPart> parts;
    for (const uint32_t index : scene.drawn) {
      const MeshData &data = scene.meshes[nodes[index].mesh];
      for (const Primitive &primitive : data.primitives) {
        mesh = {};
        append(nodes[index], global[index], data, primitive);
        check();
        parts.push_back({std::move(mesh), primitive.material});
      }
    }
    return parts;
  }

  std::vector<Transform> transforms() { return std::move(global); }

private:
  void check() {
    if (mesh.normals.size() != mesh.positions.size()) mesh.normals.clear();
    for (size_t i = 0; i < mesh.positions.size(); i++)
      if (!std::isfinite(mesh.positions[i]))
        throw Error(scene.file + ": vertex " + std::to_string(i / 3) + " of the posed scene is not finite");
  }

  void move(const Channel &channel, double time) {
    const std::vector<double> value = channel.at(time);
    Node &node = nodes[channel.node];
    switch (channel.path) {
    case Path::translation:
      std::copy_n(value.begin(), 3, node.translation);
      break;
    case Path::rotation:
      std::copy_n(value.begin(), 4, node.rotation);
      break;
    case Path::scale:
      std::copy_n(value.begin(), 3, node.scale);
      break;
    case Path::weights:
      node.weights = value;
      break;
    }
  }

  void append(const Node &node, const Transform &place, const MeshData &data, const Primitive &primitive) {
    const uint32_t base = static_cast<uint32_t>(mesh.vertex_count());
    const std::vector<double> &weights = node.weights.empty() ? data.weights : node.weights;
    const std::vector<double> positions = morphed(primitive.positions, primitive.targets, weights),
                              normals = morphed(primitive.normals, primitive.normal_targets, weights);
    for (size_t vertex = 0; vertex < primitive.vertex_count(); vertex++) {
      const double *at = &positions[vertex * 3];
      const double point[3] = {at[0], at[1], at[2]};
      double moved[3];
      if (node.skin == none)
        place.apply(point, moved);
      else
        blend(joints[node.skin], primitive, vertex, point, moved);
      mesh.positions.insert(mesh.positions.end(), moved, moved + 3);
      if (normals.empty()) continue;
      const double normal[3] = {normals[vertex * 3], normals[vertex * 3 + 1], normals[vertex * 3 + 2]};
      (node.skin == none ? place : blended(joints[node.skin], primitive, vertex)).apply_normal(normal, moved);
      mesh.normals.insert(mesh.normals.end(), moved, moved + 3);
    }
    if (!primitive.colours.empty()) colours.resize(3 * size_t(base), 255);
    colours.insert(colours.end(), primitive.colours.begin(), primitive.colours.end());
    mesh_size = mesh.positions.size();
    mesh.texture.insert(mesh.texture.end(), primitive.texture.begin(), primitive.texture.end());
    // Clause 3.7.4: the sign of the determinant decides which way a face turns. A skinned mesh does not
    // follow its node.
    const bool mirrored = node.skin == none && place.determinant() < 0;
    for (size_t i = 0; i < primitive.triangles.size(); i += 3) {
      const uint32_t *corner = &primitive.triangles[i];
      mesh.faces.insert(mesh.faces.end(),
                        {base + corner[0], base + corner[mirrored ? 2 : 1], base + corner[mirrored ? 1 : 2]});
    }
  }

  static std::vector<double> morphed(std::vector<double> values,
                                     const std::vector<std::vector<double>> &targets,
                                     const std::vector<double> &weights) {
    for (size_t t = 0; t < weights.size(); t++)
      if (weights[t] != 0)
        for (size_t i = 0; i < targets[t].size(); i++) values[i] += weights[t] * targets[t][i];
    return values;
  }

  static Transform blended(const std::vector<Transform> &matrices, const Primitive &primitive,
                           size_t vertex) {
    Transform sum;
    sum.m.fill(0);
    for (size_t i = primitive.first[vertex]; i < primitive.first[vertex + 1]; i++)
      for (size_t k = 0; k < sum.m.size(); k++)
        sum.m[k] += primitive.influences[i].weight * matrices[primitive.influences[i].joint].m[k];
    return sum;
  }

  static void blend(const std::vector<Transform> &matrices, const Primitive &primitive, size_t vertex,
                    const double (&point)[3], double (&out)[3]) {
    std::fill_n(out, 3, 0.0);
    for (size_t i = primitive.first[vertex]; i < primitive.first[vertex + 1]; i++) {
      const Influence &influence = primitive.influences[i];
      double moved[3];
      matrices[influence.joint].apply(point, moved);
      for (size_t k = 0; k < 3; k++) out[k] += influence.weight * moved[k];
    }
  }

  const Scene &scene;
  std::vector<Node> nodes; // as the animation leaves them
  std::vector<Transform> global;
  std::vector<std::vector<Transform>> joints; // per skin
  Mesh mesh;
  std::vector<uint8_t> colours; // R G B of vertices up to the last that have some
  size_t mesh_size = 0;         // coordinates so far
};

} // namespace

Mesh pose(const Scene &scene, std::optional<double> time, MeshExtras *extras) {
  Poser poser(scene, time);
  Mesh mesh = poser.run();
  if (extras) extras->colours = poser.vertex_colours();
  return mesh;
}

FacePictures face_pictures(const Scene &scene) {
  FacePictures out = scene.pictures;
  for (const uint32_t index : scene.drawn)
    for (const Primitive &primitive : scene.meshes[scene.nodes[index].mesh].primitives)
      out.of_face.insert(out.of_face.end(), primitive.triangles.size() / 3, primitive.picture);
  return out;
}

std::vector<PosedPart> pose_parts(const Scene &scene) {
  return Poser(scene, std::nullopt).run_parts();
}

std::vector<Transform> global_transforms(const Scene &scene) {
  return Poser(scene, std::nullopt).transforms();
}

} // namespace fvv::scene::gltf
