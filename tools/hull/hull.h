// Visual hull (Laurentini, "The visual hull concept for silhouette-based image understanding", 1994): the
// largest body that fits all silhouettes, carved from a regular grid. Knows masks and cameras, as a real
// capture does; knows nothing of the scene's own meshes.
#pragma once

#include "hull/marching_cubes.h"
#include "hull/silhouette.h"

#include <optional>

namespace fvv::hull {

// A point has to be seen by this many cameras to be inside. Cameras that don't see it have no say.
constexpr size_t hull_cameras = 3;

// Where the ground is: nothing below it is inside.
struct Floor {
  Vec3 up;       // unit vector
  double height; // of the ground along it, metres
};

// The surface of the hull, cut off at the border of the grid and at the floor, if there is one; closed, faces
// counter-clockwise seen from outside. It may be empty.
Surface carve(const Grid &grid, const std::vector<Silhouette> &silhouettes,
              const std::optional<Floor> &floor);

} // namespace fvv::hull
