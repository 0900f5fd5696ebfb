#include "fvvimport/rig_hull.h"
#include "fvv_cxx/parallel.h"
#include "fvv_geometry/hull.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>

namespace fvv::fvvimport {

namespace {

using hull::Silhouette;
using render::Vec3;

constexpr size_t coarse = 64; // cells along the longest side of the box in which the hull is searched
constexpr double vote_points = 4e6, carve_points = 16e6;
// With fewer cameras, points that one denies and all others see are as likely an excess of their hull.
constexpr size_t cameras_for_a_vote = 6;
// A camera is wrong if it alone denies at least this number of points, this fraction of the remaining ones,
// and four times as many as the next camera. Consistent cameras deny some points each.
constexpr size_t denied_points = 16;
constexpr double denied_share = 0.05;
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

// Whether the hull may reach into the ball around a point if this number of cameras is wrong.
bool possible(const std::vector<Silhouette> &silhouettes, Vec3 p, double radius, size_t wrong) {
  const double world[3] = {p.x, p.y, p.z};
  size_t inside = 0, outside = 0;
  for (const Silhouette &silhouette : silhouettes) {
    const Silhouette::View view = silhouette.view(world);
    if (!view.seen) continue;
    if (!silhouette.clear_of(view, radius))
      inside++;
    else if (++outside > wrong)
      return false;
  }
  return inside >= hull::hull_cameras;
}

// Of a grid over the box with about this number of points.
double cell_for(const Extent &box, double points) {
  const Vec3 size = box.high - box.low;
  return std::cbrt(size.x * size.y * size.z / points);
}

// The box of all coarse cells that may hold a part of the hull.
Extent shrunk(const Extent &box, const std::vector<Silhouette> &silhouettes, size_t wrong, uint32_t threads) {
  const double cell = box.longest() / coarse;
  const hull::Grid grid = hull::grid_over(box.low, box.high, cell);
  std::vector<Extent> slices(grid.count[2]);
  fvv::parallel(threads, slices.size(), [&](size_t k) {
    for (size_t j = 0; j < grid.count[1]; j++)
      for (size_t i = 0; i < grid.count[0]; i++) {
        const Vec3 p = grid.point(double(i), double(j), double(k));
        if (possible(silhouettes, p, 0.87 * cell, wrong)) slices[k].add(p); // half a cell's diagonal
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

// A box that contains the hull even if this number of cameras is wrong.
Extent find(const std::vector<fvv_camera> &cameras, const std::vector<Silhouette> &silhouettes, size_t wrong,
            uint32_t threads) {
  const RigSpace space = rig_space(cameras);
  const Vec3 half = Vec3{1, 1, 1} * space.radius;
  Extent box{space.centre - half, space.centre + half};
  for (int pass = 0; pass < most_passes; pass++) {
    const double before = box.longest();
    box = shrunk(box, silhouettes, wrong, threads);
    if (box.empty() || box.longest() > worthwhile * before) break;
  }
  return box;
}

// Points of a grid, counted by the silhouettes of the cameras that see them.
struct Votes {
  size_t inside = 0;         // say all
  std::vector<size_t> alone; // for each camera: it alone says outside
};

Votes vote(const Extent &box, const std::vector<Silhouette> &silhouettes, uint32_t threads) {
  const hull::Grid grid = hull::grid_over(box.low, box.high, cell_for(box, vote_points));
  std::vector<Votes> slices(grid.count[2]);
  fvv::parallel(threads, slices.size(), [&](size_t k) {
    Votes &votes = slices[k];
    votes.alone.resize(silhouettes.size());
    for (size_t j = 0; j < grid.count[1]; j++)
      for (size_t i = 0; i < grid.count[0]; i++) {
        const Vec3 p = grid.point(double(i), double(j), double(k));
        const double world[3] = {p.x, p.y, p.z};
        size_t inside = 0, outside = 0, last = 0;
        for (size_t camera = 0; camera < silhouettes.size() && outside < 2; camera++) {
          const Silhouette::View view = silhouettes[camera].view(world);
          if (!view.seen) continue;
          inside += view.pixels <= 0;
          if (view.pixels > 0) outside++, last = camera;
        }
        if (inside < hull::hull_cameras) continue;
        votes.inside += outside == 0;
        if (outside == 1) votes.alone[last]++;
      }
  });
  Votes sum;
  sum.alone.resize(silhouettes.size());
  for (const Votes &slice : slices) {
    sum.inside += slice.inside;
    for (size_t i = 0; i < sum.alone.size(); i++) sum.alone[i] += slice.alone[i];
  }
  return sum;
}

// The camera that alone denies much of what all others see, and far more than any other does.
std::optional<size_t> dissenter(const Votes &votes) {
  std::vector<size_t> order(votes.alone.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::partial_sort(order.begin(), order.begin() + 2, order.end(),
                    [&](size_t a, size_t b) { return votes.alone[a] > votes.alone[b]; });
  const size_t most = votes.alone[order[0]], next = votes.alone[order[1]];
  if (most >= denied_points && most > denied_share * double(votes.inside + most) && most > 4 * next)
    return order[0];
  return std::nullopt;
}

// Half the width of a pixel of the camera with the finest view in the middle of the box, metres: finer cells
// would show no more.
double finest_cell(const Extent &box, const std::vector<fvv_camera> &cameras) {
  double finest = INFINITY;
  for (const fvv_camera &camera : cameras)
    finest = std::min(finest, length(centre_of(camera) - mix(box.low, box.high, 0.5)) / camera.fx / 2);
  return finest;
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

RigHull hull_of(const std::vector<fvv_camera> &cameras, const std::vector<std::vector<uint8_t>> &masks,
                uint32_t threads) {
  RigHull hull;
  if (cameras.size() < hull::hull_cameras) return hull;
  std::vector<std::unique_ptr<Silhouette>> made(cameras.size());
  fvv::parallel(threads, made.size(),
                [&](size_t i) { made[i] = std::make_unique<Silhouette>(cameras[i], masks[i]); });
  std::vector<Silhouette> silhouettes;
  for (auto &one : made) silhouettes.push_back(std::move(*one));
  const size_t wrong = cameras.size() < cameras_for_a_vote ? 0 : 1;
  Extent box = find(cameras, silhouettes, wrong, threads);
  if (!box.empty() && wrong) {
    hull.excluded = dissenter(vote(box, silhouettes, threads));
    if (hull.excluded) silhouettes.erase(silhouettes.begin() + std::ptrdiff_t(*hull.excluded));
    box = find(cameras, silhouettes, 0, threads);
  }
  if (!box.empty()) {
    const double cell = std::max(cell_for(box, carve_points), finest_cell(box, cameras));
    hull.surface = hull::carve(hull::grid_over(box.low, box.high, cell), silhouettes, std::nullopt);
  }
  return hull;
}

} // namespace fvv::fvvimport
