// Closed surfaces from signed values on a regular grid.
#pragma once

#include "fvv_render/vector.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace fvv::hull {

using render::Vec3;

// An edge of a grid that a surface crosses.
struct Crossed {
  uint64_t edge; // 3 * point + axis (0 x, 1 y, 2 z): from the point to its next one on that axis
  float offset;  // 0..1 along it
};

struct Surface {
  std::vector<Vec3> vertices;
  std::vector<uint32_t> faces;         // three indices each, counter-clockwise seen from outside
  std::vector<Crossed> crossings = {}; // of each vertex, when march() made the surface; else empty
};

struct Grid {
  Vec3 origin;                 // of point (0, 0, 0), metres
  double cell;                 // distance of neighbours along each axis, metres
  std::array<size_t, 3> count; // points along x, y, z

  size_t points() const { return count[0] * count[1] * count[2]; }
  size_t at(size_t i, size_t j, size_t k) const { return (k * count[1] + j) * count[0] + i; }
  size_t stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? count[0] : count[0] * count[1]; }
  Vec3 point(double i, double j, double k) const { return origin + Vec3{i, j, k} * cell; }
  std::array<size_t, 3> place(size_t point) const {
    return {point % count[0], point / count[0] % count[1], point / (count[0] * count[1])};
  }
};

// The smallest grid of that cell from low to high or beyond.
Grid grid_over(Vec3 low, Vec3 high, double cell);

// Values of the points of a grid, negative inside.
class Field {
public:
  virtual ~Field() = default;
  virtual double value(size_t point) const = 0;
  virtual void set(size_t point, double value) = 0;
};

// Makes a signed grid well composed (Latecki, "3D well-composed pictures", 1997): where inside touches
// inside, or outside outside, across a diagonal only, a surface between the two would have edges of four
// triangles. value: one for each point, negative inside. Points of the cells concerned change sides, the
// nearest to the surface first, until no such diagonal is left. Points on the border of the grid, which must
// be outside, stay there.
void compose_well(const Grid &grid, std::vector<double> &value);

// Where along the edge from a point to its next one on an axis (0 x, 1 y, 2 z) the surface crosses, 0..1.
using Crossing = std::function<double(size_t point, int axis)>;

// The surface between points of negative value and the others. value is made well composed first, and its
// border must be outside: so the surface is always closed and a manifold, without a table of ambiguous cases.
// Vertices stay this far from the ends of their edges, in cells, so that no triangle loses its area.
constexpr double edge_margin = 0.05;
// crossing is called after value was made well composed, for edges whose ends differ in sign.
Surface march(const Grid &grid, std::vector<double> &value, const Crossing &crossing);
// The same, in time proportional to the surface. mixed: the first point of each cell whose corners differ in
// sign, rising.
Surface march(const Grid &grid, Field &field, std::vector<size_t> mixed, const Crossing &crossing);

// The crossing by linear interpolation of the values at the ends of an edge.
inline double interpolated_crossing(double from, double to) {
  return from / (from - to);
}
inline double interpolated_crossing(const Grid &grid, const std::vector<double> &value, size_t point,
                                    int axis) {
  return interpolated_crossing(value[point], value[point + grid.stride(axis)]);
}

} // namespace fvv::hull
