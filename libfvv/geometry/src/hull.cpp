#include "fvv_geometry/hull.h"
#include "fvv_geometry/distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fvv::hull {

namespace {

// Binomial over 3 x 3 pixels: smooths the steps of the mask's edge. Rows and columns end at the border.
void smooth(std::vector<float> &d, size_t width, size_t height) {
  const auto line = [](float *value, size_t count, size_t stride) {
    float before = value[0];
    for (size_t i = 0; i < count; i++) {
      const float here = value[i * stride], after = value[std::min(i + 1, count - 1) * stride];
      value[i * stride] = 0.25f * before + 0.5f * here + 0.25f * after;
      before = here;
    }
  };
  for (size_t y = 0; y < height; y++) line(&d[y * width], width, 1);
  for (size_t x = 0; x < width; x++) line(&d[x], height, width);
}

} // namespace

Silhouette::Silhouette(const fvv_camera &from, const std::vector<uint8_t> &mask)
    : camera(from), distance(signed_distance(mask, from.width, from.height)) {
  camera.name = nullptr;
  camera.name_size = 0;
  smooth(distance, camera.width, camera.height);
}

double Silhouette::at(double u, double v) const {
  const double x = std::clamp(u - 0.5, 0.0, camera.width - 1.0),
               y = std::clamp(v - 0.5, 0.0, camera.height - 1.0);
  const size_t i = std::min(size_t(x), size_t(camera.width) - 2),
               j = std::min(size_t(y), size_t(camera.height) - 2);
  const double s = x - double(i), t = y - double(j);
  const float *d = &distance[j * camera.width + i];
  const double above = d[0] + (double(d[1]) - double(d[0])) * s;
  d += camera.width;
  const double below = d[0] + (double(d[1]) - double(d[0])) * s;
  return above + (below - above) * t;
}

Silhouette::View Silhouette::view(const double world[3]) const {
  View view;
  if (!fvv_camera_project(&camera, world, view.pixel, &view.depth)) return view;
  view.seen = view.pixel[0] >= 0 && view.pixel[1] >= 0 && view.pixel[0] <= camera.width &&
              view.pixel[1] <= camera.height;
  if (!view.seen) return view;
  view.per_metre = camera.fx / view.depth;
  view.pixels = at(view.pixel[0], view.pixel[1]);
  view.metres = view.pixels / view.per_metre;
  return view;
}

bool Silhouette::clear_of(const View &view, double radius) const {
  if (!view.seen || view.depth <= 2 * radius) return false;
  // Twice as far as a point moves in the middle of the picture: enough for perspective and lens at its edges,
  // and one pixel and a half for smoothing.
  const double reach = 2 * radius * view.per_metre * view.depth / (view.depth - radius) + 1.5;
  return view.pixels > reach && view.pixel[0] > reach && view.pixel[1] > reach &&
         view.pixel[0] + reach < camera.width && view.pixel[1] + reach < camera.height;
}

namespace {

constexpr size_t block = 8; // points along the side of a block that is tested as a whole

class Carving {
public:
  Carving(const Grid &points, const std::vector<Silhouette> &views, const std::optional<Floor> &ground)
      : grid(points), silhouettes(views), floor(ground), value(points.points(), points.cell) {
    if (!floor) return;
    // Empty blocks are not changed here: where one meets a full block at the floor, the depth below it
    // decides.
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
