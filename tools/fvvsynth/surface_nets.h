// From an implicit surface to triangles. Knows a function of space, nothing of people.
#pragma once

#include "fvv_geometry/hull.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace fvv::synth {

using hull::Surface;
using render::Vec3;

// Triangles of the surface distance(p) = 0 inside the box low..high, which it must not touch: one vertex for
// each cell of the grid that the surface passes (Gibson, "Constrained elastic surface nets", 1998), evened
// out along the surface and moved onto it. Always closed and a manifold; details narrower than a cell go.
Surface extract(const std::function<double(Vec3)> &distance, Vec3 low, Vec3 high, double cell);

// For each vertex the vertices that share an edge with it, in rising order.
std::vector<std::vector<uint32_t>> neighbours(const Surface &surface);

} // namespace fvv::synth
