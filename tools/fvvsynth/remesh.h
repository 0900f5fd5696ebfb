// The same surface with other triangles: where grid lines enter and leave closed surfaces, and marching cubes
// over that.
#pragma once

#include "fvv_geometry/hull.h"

namespace fvv::synth {

using hull::Grid;
using hull::Surface;

// The outer surface of the union of closed surfaces (positions x y z, faces counter-clockwise seen from
// outside, which may cut each other and themselves) by its crossings with the lines of grid, whose border it
// must not reach. Vertices lie on the given surface, except where well-composing moved it; details between
// grid lines are lost.
Surface remesh(const Grid &grid, const std::vector<float> &positions, const std::vector<uint32_t> &faces);

// A grid around positions whose origin depends on key: every key gives other triangles.
Grid remesh_grid(const std::vector<float> &positions, double cell, uint64_t key);

} // namespace fvv::synth
