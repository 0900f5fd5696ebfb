// Surface nets: one vertex for each crossed cell, one quadrilateral for each crossed edge.
#include "fvvsynth/surface_nets.h"

#include "fvv_geometry/hull.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fvv::synth {

using hull::Grid;
using hull::grid_over;

namespace {

constexpr uint32_t no_vertex = UINT32_MAX;
constexpr int evening_rounds = 6;

class Net {
public:
  Net(const std::function<double(Vec3)> &distance, const Grid &points) : grid(points), count(grid.count) {
    value.reserve(grid.points());
    for (size_t k = 0; k < count[2]; k++)
      for (size_t j = 0; j < count[1]; j++)
        for (size_t i = 0; i < count[0]; i++)
          value.push_back(distance(grid.point(double(i), double(j), double(k))));
    vertex.assign(value.size(), no_vertex);
    compose_well(grid, value);
  }

  Surface surface() {
    Surface out;
    for (size_t k = 0; k + 1 < count[2]; k++)
      for (size_t j = 0; j + 1 < count[1]; j++)
        for (size_t i = 0; i + 1 < count[0]; i++) add_vertex(i, j, k, out);
    for (size_t k = 1; k + 1 < count[2]; k++)
      for (size_t j = 1; j + 1 < count[1]; j++)
        for (size_t i = 1; i + 1 < count[0]; i++)
          for (int axis = 0; axis < 3; axis++) add_quadrilateral({i, j, k}, axis, out);
    return out;
  }

private:
  // The mean of the points where edges of the cell cross the surface.
  void add_vertex(size_t i, size_t j, size_t k, Surface &out) {
    Vec3 sum;
    int crossings = 0;
    for (int a = 0; a < 8; a++)
      for (int bit = 1; bit < 8; bit *= 2) {
        if (a & bit) continue;
        const int b = a | bit;
        const auto corner = [&](int c) {
          return value[grid.at(i + size_t(c & 1), j + size_t(c >> 1 & 1), k + size_t(c >> 2))];
        };
        const double va = corner(a), vb = corner(b);
        if ((va < 0) == (vb < 0)) continue;
        const double t = va / (va - vb);
        sum += Vec3{double(a & 1), double(a >> 1 & 1), double(a >> 2)} +
               Vec3{double(bit & 1), double(bit >> 1 & 1), double(bit >> 2)} * t;
        crossings++;
      }
    if (crossings == 0) return;
    const Vec3 mean = sum * (1.0 / crossings);
    vertex[grid.at(i, j, k)] = uint32_t(out.vertices.size());
    out.vertices.push_back(grid.point(double(i) + mean.x, double(j) + mean.y, double(k) + mean.z));
  }

  void add_quadrilateral(std::array<size_t, 3> p, int axis, Surface &out) {
    std::array<size_t, 3> next = p;
    next[size_t(axis)]++;
    const bool inside = value[grid.at(p[0], p[1], p[2])] < 0;
    if (inside == (value[grid.at(next[0], next[1], next[2])] < 0)) return;
    // The four cells around the edge, in the turn of a right hand whose thumb points along the axis.
    const size_t u = size_t(axis + 1) % 3, v = size_t(axis + 2) % 3;
    std::array<uint32_t, 4> corner;
    for (size_t c = 0; c < 4; c++) {
      std::array<size_t, 3> q = p;
      q[u] -= c == 0 || c == 3;
      q[v] -= c < 2;
      corner[c] = vertex[grid.at(q[0], q[1], q[2])];
    }
    if (!inside) std::swap(corner[1], corner[3]);
    const auto span = [&](size_t a, size_t b) {
      return length(out.vertices[corner[a]] - out.vertices[corner[b]]);
    };
    const size_t first = span(0, 2) <= span(1, 3) ? 0 : 1; // split along the shorter diagonal
    for (size_t t = 0; t < 2; t++)
      for (const size_t c : {first, first + 1 + t, first + 2 + t}) out.faces.push_back(corner[c % 4]);
  }

  const Grid grid;
  const std::array<size_t, 3> &count;
  std::vector<double> value;
  std::vector<uint32_t> vertex; // of the cell whose lowest corner is this point
};

Vec3 gradient(const std::function<double(Vec3)> &distance, Vec3 p) {
  constexpr double h = 1e-3;
  return Vec3{distance({p.x + h, p.y, p.z}) - distance({p.x - h, p.y, p.z}),
              distance({p.x, p.y + h, p.z}) - distance({p.x, p.y - h, p.z}),
              distance({p.x, p.y, p.z + h}) - distance({p.x, p.y, p.z - h})} *
         (0.5 / h);
}

} // namespace

std::vector<std::vector<uint32_t>> neighbours(const Surface &surface) {
  std::vector<std::vector<uint32_t>> result(surface.vertices.size());
  for (size_t i = 0; i < surface.faces.size(); i += 3)
    for (size_t c = 0; c < 3; c++) {
      const uint32_t a = surface.faces[i + c], b = surface.faces[i + (c + 1) % 3];
      result[a].push_back(b);
      result[b].push_back(a);
    }
  for (auto &list : result) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return result;
}

Surface extract(const std::function<double(Vec3)> &distance, Vec3 low, Vec3 high, double cell) {
  Surface surface = Net(distance, grid_over(low, high, cell)).surface();
  const auto around = neighbours(surface);
  for (int round = 0; round < evening_rounds; round++) {
    std::vector<Vec3> moved = surface.vertices;
    for (size_t i = 0; i < moved.size(); i++) {
      Vec3 mean;
      for (const uint32_t n : around[i]) mean += surface.vertices[n];
      const Vec3 slope = gradient(distance, moved[i]);
      const Vec3 normal = normalised(slope);
      const Vec3 step = mean * (1.0 / double(around[i].size())) - moved[i];
      // Half a step of evening out within the tangent plane, then at most a quarter of a cell towards the
      // surface.
      Vec3 p = moved[i] + (step - normal * dot(normal, step)) * 0.5;
      const double off = distance(p) / std::max(length(slope), 0.3);
      moved[i] = p - normal * std::clamp(off, -0.25 * cell, 0.25 * cell);
    }
    surface.vertices = moved;
  }
  return surface;
}

} // namespace fvv::synth
