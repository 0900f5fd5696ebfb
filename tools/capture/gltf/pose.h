// capture/gltf/pose.h: a scene at a moment as one triangle mesh: animation, morph targets, linear-blend
// skinning and the transforms of the nodes. The same vertices and faces in the same order at every time.
#pragma once

#include "capture/gltf/scene.h"

namespace fvv::capture::gltf {

// In the file's units and axes (+y up), with normals when they were read and every primitive has them. time
// in seconds; nothing: as the nodes stand. Where a node mirrors, its faces are turned round, so that they are
// counter-clockwise seen from outside. FileError for coordinates that overflow.
Mesh pose(const Scene &scene, std::optional<double> time);

} // namespace fvv::capture::gltf
