#include "fvvmux/rig_space.h"

#include "cli/parallel.h"
#include "hull/hull.h"

#include <algorithm>
#include <memory>
#include <optional>

namespace fvv::mux {

namespace {

using hull::Silhouette;
using render::Vec3;

constexpr size_t coarse = 64, fine = 192; // cells along the longest side
constexpr int most_passes = 8;
constexpr double worthwhile = 0.8; // a pass that leaves more of the box than this is the last one

Vec3 centre_of(const fvv_camera &camera) {
  double c[3];
  fvv_camera_centre(&camera, c);
  return {c[0], c[1], c[2]};
}

// Low and high corner; empty until something was added.
struct Extent {
  Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};

  void add(Vec3 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  bool empty() const { return !(low.x <= high.x); }
  double longest() const { return std::max({high.x - low.x, high.y - low.y, high.z - low.z}); }
};

// Whether the hull may reach into the ball around a point.
bool possible(const std::vector<Silhouette> &silhouettes, Vec3 p, double radius) {
  const double world[3] = {p.x, p.y, p.z};
  size_t seen = 0;
  for (const Silhouette &silhouette : silhouettes) {
    const Silhouette::View view = silhouette.view(world);
    if (!view.seen) continue;
    seen++;
    if (silhouette.clear_of(view, radius)) return false;
  }
  return seen >= hull::hull_cameras;
}

// The box of all coarse cells that may hold a part of the hull.
Extent shrunk(const Extent &box, const std::vector<Silhouette> &silhouettes, uint32_t threads) {
  const double cell = box.longest() / coarse;
  const hull::Grid grid = hull::grid_over(box.low, box.high, cell);
  std::vector<Extent> slices(grid.count[2]);
  cli::parallel(threads, slices.size(), [&](size_t k) {
    for (size_t j = 0; j < grid.count[1]; j++)
      for (size_t i = 0; i < grid.count[0]; i++) {
        const Vec3 p = grid.point(double(i), double(j), double(k));
        if (possible(silhouettes, p, 0.87 * cell)) slices[k].add(p); // half a cell's diagonal
      }
  });
  Extent out;
  for (const Extent &slice : slices)
    if (!slice.empty()) {
      out.add(slice.low);
      out.add(slice.high);
    }
  if (out.empty()) return out;
  const Vec3 margin = Vec3{1, 1, 1} * cell;
  return {out.low - margin, out.high + margin};
}

} // namespace

RigSpace rig_space(const std::vector<fvv_camera> &cameras) {
  // Sum over the axes c + s d of (I - d d^T)(p - c) = 0, relative to the mean of the c.
  Vec3 mean;
  for (const fvv_camera &camera : cameras) mean += centre_of(camera) * (1.0 / double(cameras.size()));
  render::Mat3 m{{}, {}, {}};
  Vec3 right;
  for (const fvv_camera &camera : cameras) {
    const double *r = camera.rotation;
    const Vec3 d = normalised(Vec3{r[6], r[7], r[8]}), c = centre_of(camera) - mean;
    m.x += Vec3{1, 0, 0} - d * d.x;
    m.y += Vec3{0, 1, 0} - d * d.y;
    m.z += Vec3{0, 0, 1} - d * d.z;
    right += c - d * dot(d, c);
  }
  const double n = double(cameras.size()), determinant = dot(m.x, cross(m.y, m.z));
  RigSpace space{mean, 0};
  if (determinant > 1e-6 * n * n * n)
    space.centre +=
        Vec3{dot(right, cross(m.y, m.z)), dot(m.x, cross(right, m.z)), dot(m.x, cross(m.y, right))} *
        (1 / determinant);
  for (const fvv_camera &camera : cameras)
    space.radius = std::max(space.radius, length(centre_of(camera) - space.centre));
  if (!(space.radius > 0)) space.radius = 1;
  return space;
}

hull::Surface hull_of(const std::vector<fvv_camera> &cameras, const std::vector<std::vector<uint8_t>> &masks,
                      uint32_t threads) {
  if (cameras.size() < hull::hull_cameras) return {};
  std::vector<std::unique_ptr<Silhouette>> made(cameras.size());
  cli::parallel(threads, made.size(),
                [&](size_t i) { made[i] = std::make_unique<Silhouette>(cameras[i], masks[i]); });
  std::vector<Silhouette> silhouettes;
  for (auto &one : made) silhouettes.push_back(std::move(*one));
  const RigSpace space = rig_space(cameras);
  const Vec3 half = Vec3{1, 1, 1} * space.radius;
  Extent box{space.centre - half, space.centre + half};
  for (int pass = 0; pass < most_passes; pass++) {
    const double before = box.longest();
    box = shrunk(box, silhouettes, threads);
    if (box.empty()) return {};
    if (box.longest() > worthwhile * before) break;
  }
  return hull::carve(hull::grid_over(box.low, box.high, box.longest() / fine), silhouettes, std::nullopt);
}

} // namespace fvv::mux
