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

constexpr double vote_points = 4e6, carve_points = 16e6;
// With fewer cameras, points that one denies and all others see are as likely an excess of their hull.
constexpr size_t cameras_for_a_vote = 6;
// A camera is wrong if it alone denies at least this number of points, this fraction of the remaining ones,
// and four times as many as the next camera. Consistent cameras deny some points each.
constexpr size_t denied_points = 16;
constexpr double denied_share = 0.05;

Vec3 centre_of(const fvv_camera &camera) {
  double c[3];
  fvv_camera_centre(&camera, c);
  return {c[0], c[1], c[2]};
}

// Of a grid over the box with about this number of points.
double cell_for(const hull::Box &box, double points) {
  const Vec3 size = box.high - box.low;
  return std::cbrt(size.x * size.y * size.z / points);
}

// Points of a grid, counted by the silhouettes of the cameras that see them.
struct Votes {
  size_t inside = 0;         // say all
  std::vector<size_t> alone; // for each camera: it alone says outside
};

Votes vote(const hull::Box &box, const std::vector<Silhouette> &silhouettes, uint32_t threads) {
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
double finest_cell(const hull::Box &box, const std::vector<fvv_camera> &cameras) {
  double finest = INFINITY;
  for (const fvv_camera &camera : cameras)
    finest = std::min(finest, length(centre_of(camera) - mix(box.low, box.high, 0.5)) / camera.fx / 2);
  return finest;
}

} // namespace

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
  hull::Options options;
  options.threads = threads;
  options.missed = wrong;
  std::optional<hull::Box> box = hull::bounds(silhouettes, options);
  options.missed = 0;
  if (box && wrong) {
    hull.excluded = dissenter(vote(*box, silhouettes, threads));
    if (hull.excluded) silhouettes.erase(silhouettes.begin() + std::ptrdiff_t(*hull.excluded));
    box = hull::bounds(silhouettes, options);
  }
  if (box) {
    const double cell = std::max(cell_for(*box, carve_points), finest_cell(*box, cameras));
    hull.surface = hull::carve(hull::grid_over(box->low, box->high, cell), silhouettes, options).surface;
  }
  return hull;
}

} // namespace fvv::fvvimport
