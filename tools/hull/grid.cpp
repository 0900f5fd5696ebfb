#include "hull/grid.h"

#include <cmath>

namespace fvv::hull {

Grid grid_over(Vec3 low, Vec3 high, double cell) {
  const auto points = [&](double extent) { return size_t(std::ceil(extent / cell)) + 1; };
  return {low, cell, {points(high.x - low.x), points(high.y - low.y), points(high.z - low.z)}};
}

} // namespace fvv::hull
