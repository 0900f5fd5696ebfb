#include "octree.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/parallel.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace fvv::hull {

namespace {

std::array<size_t, 3> blocks_of(const Grid &grid) {
  std::array<size_t, 3> out;
  for (size_t a = 0; a < 3; a++) out[a] = (grid.count[a] + Octree::block - 1) / Octree::block;
  return out;
}

} // namespace

double depth_below(const std::optional<Floor> &floor, Vec3 p) {
  return floor ? floor->height - dot(floor->up, p) : -std::numeric_limits<double>::infinity();
}

Octree::Octree(const Grid &over, const std::vector<Silhouette> &views, const Options &how)
    : blocks(blocks_of(over)), grid(over), silhouettes(views), options(how) {}

Octree::Verdict Octree::examine(Cube &cube) const {
  const double half = (double(cube.size * block) - 1) / 2, radius = half * grid.cell * 1.7321;
  const auto middle = [&](uint32_t at) { return double(at * block) + half; };
  const Vec3 p = grid.point(middle(cube.x), middle(cube.y), middle(cube.z));
  const double below = depth_below(options.floor, p), world[3] = {p.x, p.y, p.z};
  if (below > 2 * radius) return Verdict::outside;
  size_t kept = 0;
  for (const uint32_t camera : cube.unsure) switch (silhouettes[camera].ball(world, radius)) {
    case Silhouette::Ball::unseen:
      break;
    case Silhouette::Ball::outside:
      if (++cube.outside > options.missed) return Verdict::outside;
      break;
    case Silhouette::Ball::inside:
      cube.inside++;
      break;
    case Silhouette::Ball::unsure:
      cube.unsure[kept++] = camera;
      break;
    }
  cube.unsure.resize(kept);
  if (cube.inside + kept < options.least_views) return Verdict::outside;
  if (below > -2 * radius || cube.outside + kept > options.missed || cube.inside < options.least_views)
    return Verdict::mixed;
  // Points on the border of the grid are outside, so their neighbours are next to the surface.
  const uint32_t from[3] = {cube.x, cube.y, cube.z};
  for (size_t a = 0; a < 3; a++)
    if (from[a] * block < 2 || (from[a] + cube.size) * block + 2 > grid.count[a]) return Verdict::mixed;
  return Verdict::inside;
}

Octree::Leaves Octree::refine() const {
  constexpr size_t together = 32; // cubes that a thread examines in one piece of work
  Cube root{0, 0, 0, 1, std::vector<uint32_t>(silhouettes.size()), 0, 0};
  while (root.size < *std::max_element(blocks.begin(), blocks.end())) root.size *= 2;
  std::iota(root.unsure.begin(), root.unsure.end(), 0u);
  Leaves out;
  std::vector<Cube> level{root};
  while (!level.empty()) {
    std::vector<Verdict> verdicts(level.size());
    fvv::parallel(options.threads, (level.size() + together - 1) / together, [&](size_t piece) {
      for (size_t i = piece * together; i < std::min(level.size(), (piece + 1) * together); i++)
        verdicts[i] = examine(level[i]);
    });
    std::vector<Cube> next;
    for (size_t i = 0; i < level.size(); i++) {
      Cube &cube = level[i];
      if (verdicts[i] == Verdict::outside) continue;
      if (verdicts[i] == Verdict::inside || cube.size == 1) {
        (verdicts[i] == Verdict::inside ? out.inside : out.mixed).push_back(std::move(cube));
        continue;
      }
      const uint32_t half = cube.size / 2;
      for (uint32_t c = 0; c < 8; c++) {
        Cube part{cube.x + (c & 1) * half,
                  cube.y + (c >> 1 & 1) * half,
                  cube.z + (c >> 2) * half,
                  half,
                  cube.unsure,
                  cube.inside,
                  cube.outside};
        if (part.x < blocks[0] && part.y < blocks[1] && part.z < blocks[2]) next.push_back(std::move(part));
      }
      if (next.size() > 8 * most_blocks) break;
    }
    if (out.mixed.size() > most_blocks || next.size() > 8 * most_blocks)
      throw Error("cell: expected at most " + std::to_string(most_blocks) +
                      " blocks of 4 x 4 x 4 points near the surface, found more: use a larger cell",
                  Error::usage);
    level = std::move(next);
  }
  return out;
}

double Octree::value(Vec3 p, const Cube &leaf, std::vector<double> &distances) const {
  const double world[3] = {p.x, p.y, p.z}, enough = 2 * grid.cell, below = depth_below(options.floor, p);
  if (below > enough) return enough;
  size_t clear = leaf.outside;
  distances.clear();
  for (const uint32_t camera : leaf.unsure) {
    const Silhouette::View view = silhouettes[camera].view(world);
    if (!view.seen) continue;
    if (view.metres > enough && ++clear > options.missed) return enough;
    distances.push_back(view.metres);
  }
  const size_t seen = leaf.inside + distances.size() + leaf.outside;
  size_t wanted = seen > options.missed ? seen - 1 - options.missed : 0;
  wanted = std::max(wanted, std::min(options.least_views, seen) - 1);
  double value = -enough;
  if (seen == 0 || wanted >= leaf.inside + distances.size())
    value = enough;
  else if (wanted >= leaf.inside) {
    const auto at = distances.begin() + std::ptrdiff_t(wanted - leaf.inside);
    std::nth_element(distances.begin(), at, distances.end());
    value = *at;
  }
  value = std::clamp(std::max(value, below), -enough, enough);
  return seen < options.least_views ? std::max(value, grid.cell) : value;
}

} // namespace fvv::hull
