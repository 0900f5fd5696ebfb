#include "fvvsynth/remesh.h"

#include "fvvsynth/random.h"

#include <algorithm>
#include <cmath>

namespace fvv::synth {

using hull::grid_over;

namespace {

// Where the lines of a grid along one axis enter and leave the union.
class Lines {
public:
  Lines(const Grid &points, int along, const std::vector<float> &vertices, const std::vector<uint32_t> &faces)
      : grid(points), axis(along), u((along + 1) % 3), v((along + 2) % 3),
        hits(points.count[size_t(u)] * points.count[size_t(v)]) {
    for (size_t i = 0; i < faces.size(); i += 3) add(vertices, faces.data() + i);
  }

  // Calls crossed(point, share) for every place where a line enters or leaves the union: share of the way
  // from the grid point to its next one. Calls inside(point) for every point inside.
  template <class Crossed, class Inside> void walk(Crossed crossed, Inside inside) {
    for (size_t line = 0; line < hits.size(); line++) {
      std::array<size_t, 3> p{};
      p[size_t(u)] = line % grid.count[size_t(u)];
      p[size_t(v)] = line / grid.count[size_t(u)];
      const size_t first = grid.at(p[0], p[1], p[2]), stride = grid.stride(axis);
      std::sort(hits[line].begin(), hits[line].end());
      int depth = 0;
      double entered = 0;
      for (const auto &[at, turn] : hits[line]) {
        const bool before = depth > 0;
        depth += turn;
        if (before == (depth > 0)) continue;
        crossed(first + size_t(at) * stride, at - std::floor(at));
        if (!before) entered = at;
        if (before)
          for (double i = std::ceil(entered); i <= at; i++) inside(first + size_t(i) * stride);
      }
    }
  }

private:
  // The grid point (a, b) is to the left of the edge from p to q, computed alike for both faces at the edge.
  static bool left(const std::array<double, 3> &p, const std::array<double, 3> &q, bool swap, double a,
                   double b, int u, int v) {
    const auto &s = swap ? q : p, &e = swap ? p : q;
    const double side = (e[size_t(u)] - s[size_t(u)]) * (b - s[size_t(v)]) -
                        (e[size_t(v)] - s[size_t(v)]) * (a - s[size_t(u)]);
    return (side >= 0) != swap;
  }

  void add(const std::vector<float> &vertices, const uint32_t *face) {
    std::array<double, 3> p[3]; // in cells
    for (size_t c = 0; c < 3; c++) {
      const float *at = vertices.data() + size_t(3) * face[c];
      p[c] = {(double(at[0]) - grid.origin.x) / grid.cell, (double(at[1]) - grid.origin.y) / grid.cell,
              (double(at[2]) - grid.origin.z) / grid.cell};
    }
    const size_t su = size_t(u), sv = size_t(v), sa = size_t(axis);
    const double area =
        (p[1][su] - p[0][su]) * (p[2][sv] - p[0][sv]) - (p[1][sv] - p[0][sv]) * (p[2][su] - p[0][su]);
    if (area == 0) return;
    const auto low = [&](size_t i) { return std::ceil(std::min({p[0][i], p[1][i], p[2][i]})); };
    const auto high = [&](size_t i) { return std::floor(std::max({p[0][i], p[1][i], p[2][i]})); };
    for (double b = low(sv); b <= high(sv); b++)
      for (double a = low(su); a <= high(su); a++) {
        bool within = true;
        for (size_t c = 0; c < 3; c++)
          within =
              within && left(p[c], p[(c + 1) % 3], face[c] > face[(c + 1) % 3], a, b, u, v) == (area > 0);
        if (!within) continue;
        const auto weight = [&](size_t q, size_t r) {
          return ((p[q][su] - a) * (p[r][sv] - b) - (p[q][sv] - b) * (p[r][su] - a)) / area;
        };
        const double at = weight(1, 2) * p[0][sa] + weight(2, 0) * p[1][sa] + weight(0, 1) * p[2][sa];
        // A face whose normal points along the line is one by which the line leaves.
        hits[size_t(b) * grid.count[su] + size_t(a)].push_back({at, area > 0 ? -1 : 1});
      }
  }

  const Grid &grid;
  const int axis, u, v;
  std::vector<std::vector<std::pair<double, int>>> hits;
};

} // namespace

Surface remesh(const Grid &grid, const std::vector<float> &positions, const std::vector<uint32_t> &faces) {
  std::vector<double> value(grid.points(), grid.cell); // about the distance from the surface
  std::vector<float> share(3 * grid.points(), -1);     // of the way along an edge; -1: not crossed
  std::vector<bool> inside(grid.points());
  for (int axis = 0; axis < 3; axis++) {
    const auto crossed = [&](size_t point, double at) {
      share[3 * point + size_t(axis)] = float(at);
      double &here = value[point], &next = value[point + grid.stride(axis)];
      here = std::min(here, std::max(at, 1e-6) * grid.cell);
      next = std::min(next, std::max(1 - at, 1e-6) * grid.cell);
    };
    Lines(grid, axis, positions, faces).walk(crossed, [&](size_t point) {
      if (axis == 0) inside[point] = true;
    });
  }
  for (size_t i = 0; i < value.size(); i++)
    if (inside[i]) value[i] = -value[i];
  return march(grid, value, [&](size_t point, int axis) {
    const float known = share[3 * point + size_t(axis)];
    return known >= 0 ? double(known) : interpolated_crossing(grid, value, point, axis);
  });
}

Grid remesh_grid(const std::vector<float> &positions, double cell, uint64_t key) {
  Vec3 low{1e9, 1e9, 1e9}, high = -low;
  for (size_t i = 0; i < positions.size(); i += 3) {
    const Vec3 p{positions[i], positions[i + 1], positions[i + 2]};
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  Random random(key);
  const auto step = [&] { return cell * random.between(1.5, 2.5); };
  const double x = step(), y = step(), z = step(), margin = 2 * cell;
  return grid_over(low - Vec3{x, y, z}, high + Vec3{margin, margin, margin}, cell);
}

} // namespace fvv::synth
