// From signs on a grid to triangles whose vertices lie on its edges (Lorensen and Cline, "Marching cubes",
// 1987). Knows values on a grid; knows nothing of where they come from.
#pragma once

#include "hull/grid.h"
#include "hull/surface.h"

#include <functional>
#include <vector>

namespace fvv::hull {

// Where along the edge from a point to its next one on an axis (0 x, 1 y, 2 z) the surface crosses, 0..1.
using Crossing = std::function<double(size_t point, int axis)>;

// The surface between points of negative value and the others. value is made well composed first, and its
// border must be outside: so the surface is always closed and a manifold, without a table of ambiguous cases.
// Vertices stay this far from the ends of their edges, in cells, so that no triangle loses its area.
constexpr double edge_margin = 0.05;
// crossing is asked with the values that well-composing left, for edges whose ends differ.
Surface march(const Grid &grid, std::vector<double> &value, const Crossing &crossing);

// The crossing by linear interpolation of the values.
inline double interpolated_crossing(const Grid &grid, const std::vector<double> &value, size_t point,
                                    int axis) {
  const double a = value[point], b = value[point + grid.stride(axis)];
  return a / (a - b);
}

} // namespace fvv::hull
