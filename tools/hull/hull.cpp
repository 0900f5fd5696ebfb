#include "hull/hull.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fvv::hull {

namespace {

constexpr size_t block = 8; // points along the side of a block that is looked at as a whole

class Carving {
public:
  Carving(const Grid &points, const std::vector<Silhouette> &views, const std::optional<Floor> &ground)
      : grid(points), silhouettes(views), floor(ground), value(points.points(), points.cell) {
    if (!floor) return;
    // Empty blocks stay as they are here: where one meets a full block at the floor, the depth below it has
    // the say.
    for (size_t k = 0; k < grid.count[2]; k++)
      for (size_t j = 0; j < grid.count[1]; j++)
        for (size_t i = 0; i < grid.count[0]; i++) {
          const double below = depth_below_floor(grid.point(double(i), double(j), double(k)));
          if (below > 0) value[grid.at(i, j, k)] = std::min(below, grid.cell);
        }
  }

  void fill() {
    for (size_t k = 1; k + 1 < grid.count[2]; k += block)
      for (size_t j = 1; j + 1 < grid.count[1]; j += block)
        for (size_t i = 1; i + 1 < grid.count[0]; i += block)
          if (!clear(i, j, k)) fill_block(i, j, k);
  }

  const Grid &grid;
  const std::vector<Silhouette> &silhouettes;
  const std::optional<Floor> &floor;
  std::vector<double> value; // metres, negative inside; the border stays outside

private:
  double depth_below_floor(Vec3 p) const {
    return floor ? floor->height - dot(floor->up, p) : -std::numeric_limits<double>::infinity();
  }

  // Whether one camera sees that the whole block is empty.
  bool clear(size_t i, size_t j, size_t k) const {
    const double half = (block - 1) / 2.0, radius = half * grid.cell * 1.7321;
    const Vec3 p = grid.point(double(i) + half, double(j) + half, double(k) + half);
    const double world[3] = {p.x, p.y, p.z};
    return std::any_of(silhouettes.begin(), silhouettes.end(),
                       [&](const Silhouette &s) { return s.clear_of(s.view(world), radius); });
  }

  void fill_block(size_t i0, size_t j0, size_t k0) {
    for (size_t k = k0; k < std::min(k0 + block, grid.count[2] - 1); k++)
      for (size_t j = j0; j < std::min(j0 + block, grid.count[1] - 1); j++)
        for (size_t i = i0; i < std::min(i0 + block, grid.count[0] - 1); i++)
          value[grid.at(i, j, k)] = at(grid.point(double(i), double(j), double(k)));
  }

  double at(Vec3 p) const {
    const double world[3] = {p.x, p.y, p.z}, enough = 2 * grid.cell;
    double farthest = depth_below_floor(p);
    size_t seen = 0;
    for (const Silhouette &silhouette : silhouettes) {
      const Silhouette::View view = silhouette.view(world);
      if (!view.seen) continue;
      seen++;
      farthest = std::max(farthest, view.metres);
      if (farthest > enough) return farthest; // no edge from there crosses the surface
    }
    return seen < hull_cameras ? std::max(farthest, grid.cell) : farthest;
  }
};

} // namespace

Surface carve(const Grid &grid, const std::vector<Silhouette> &silhouettes,
              const std::optional<Floor> &floor) {
  Carving carving(grid, silhouettes, floor);
  carving.fill();
  return march(grid, carving.value, [&](size_t point, int axis) {
    return interpolated_crossing(grid, carving.value, point, axis);
  });
}

} // namespace fvv::hull
