// The meshes of a glTF scene at a time: nodes, skins and morph targets applied.
#pragma once

#include "scene/src/gltf/accessor.h"
#include "scene/src/gltf/scene.h"

namespace fvv::scene::gltf {

// In the file's units and axes (+y up), with normals when they were read and every primitive has them. time
// in seconds; none: without animation. Where a node mirrors, its faces are turned round, so that they are
// counter-clockwise seen from outside. Error for coordinates that overflow. extras: NULL, or filled from a
// scene that was read with Texture::colours; white where only other primitives have colours.
Mesh pose(const Scene &scene, std::optional<double> time, MeshExtras *extras = nullptr);

// What each face of pose() shows, of a scene that was read with Texture::pictures.
FacePictures face_pictures(const Scene &scene);

// The same piece by piece: each primitive of each node that is drawn, with the material that it names.
struct PosedPart {
  Mesh mesh;
  std::optional<int64_t> material;
};
std::vector<PosedPart> pose_parts(const Scene &scene);

// From the space of each node to that of the scene, without animation.
std::vector<Transform> global_transforms(const Scene &scene);

} // namespace fvv::scene::gltf
