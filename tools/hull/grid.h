// A regular grid of points in space. Knows positions and indices; knows nothing of what stands at its points.
#pragma once

#include "fvv_render/vector.h"

#include <array>
#include <cstddef>

namespace fvv::hull {

using render::Vec3;

struct Grid {
  Vec3 origin;                 // of point (0, 0, 0), metres
  double cell;                 // distance of neighbours along each axis, metres
  std::array<size_t, 3> count; // points along x, y, z

  size_t points() const { return count[0] * count[1] * count[2]; }
  size_t at(size_t i, size_t j, size_t k) const { return (k * count[1] + j) * count[0] + i; }
  size_t stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? count[0] : count[0] * count[1]; }
  Vec3 point(double i, double j, double k) const { return origin + Vec3{i, j, k} * cell; }
};

// The smallest grid of that cell from low to high or beyond.
Grid grid_over(Vec3 low, Vec3 high, double cell);

} // namespace fvv::hull
