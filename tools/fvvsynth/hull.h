// Visual hull (Laurentini, "The visual hull concept for silhouette-based image understanding", 1994): the
// largest body that fits all silhouettes, carved from a regular grid. Knows masks and cameras, as a real
// capture does; knows nothing of the scene's own meshes.
#pragma once

#include "fvvsynth/marching_cubes.h"
#include "fvvsynth/silhouette.h"

namespace fvv::synth {

// A point has to be seen by this many cameras to be inside. Cameras that don't see it have no say.
constexpr size_t hull_cameras = 3;

// The grid over the space of the action with so many cells along its longest side, x. The floor y = 0 lies
// half a cell above its lowest points.
Grid hull_grid(size_t cells);

// The surface of the hull above the floor, cut off at the border of the grid; closed, faces counter-clockwise
// seen from outside. It may be empty.
Surface carve(const Grid &grid, const std::vector<Silhouette> &silhouettes);

} // namespace fvv::synth
