// capture/gltf/pose.h: a scene at a moment as one triangle mesh: animation, morph targets, linear-blend
// skinning and the transforms of the nodes. The same vertices and faces in the same order at every time.
#pragma once

#include "capture/gltf/scene.h"

namespace fvv::capture::gltf {

// In the file's units and axes (+y up), with normals when they were read and every primitive has them. time
// in seconds; nothing: as the nodes stand. Where a node mirrors, its faces are turned round, so that they are
// counter-clockwise seen from outside. FileError for coordinates that overflow.
Mesh pose(const Scene &scene, std::optional<double> time);

// The same piece by piece: each primitive of each node that is drawn, with the material that it names.
struct PosedPart {
  Mesh mesh;
  std::optional<int64_t> material;
};
std::vector<PosedPart> pose_parts(const Scene &scene);

// From the space of each node to that of the scene, as the nodes stand.
std::vector<Transform> global_transforms(const Scene &scene);

} // namespace fvv::capture::gltf
