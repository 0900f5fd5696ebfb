// Surface nets: one vertex for each crossed cell, one quadrilateral for each crossed edge.
#include "fvvsynth/surface_nets.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fvv::synth {

namespace {

constexpr uint32_t no_vertex = UINT32_MAX;
constexpr int evening_rounds = 6;

class Grid {
public:
  Grid(const std::function<double(Vec3)> &distance, Vec3 low, Vec3 high, double cell_size)
      : origin(low),
        cell(cell_size), count{points(high.x - low.x), points(high.y - low.y), points(high.z - low.z)} {
    value.reserve(count[0] * count[1] * count[2]);
    for (size_t k = 0; k < count[2]; k++)
      for (size_t j = 0; j < count[1]; j++)
        for (size_t i = 0; i < count[0]; i++)
          value.push_back(distance(point(double(i), double(j), double(k))));
    vertex.assign(value.size(), no_vertex);
    compose_well();
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
  size_t points(double extent) const { return size_t(std::ceil(extent / cell)) + 1; }
  Vec3 point(double i, double j, double k) const { return origin + Vec3{i, j, k} * cell; }
  size_t at(size_t i, size_t j, size_t k) const { return (k * count[1] + j) * count[0] + i; }

  // Where inside touches inside, or outside outside, across a diagonal only, the triangles would meet in
  // edges of four. There the point nearest to the surface changes sides, until none is left (a
  // "well-composed" grid: Latecki, "3D well-composed pictures", 1997).
  void compose_well() {
    for (bool changed = true; changed;) {
      changed = false;
      for (size_t k = 0; k + 1 < count[2]; k++)
        for (size_t j = 0; j + 1 < count[1]; j++)
          for (size_t i = 0; i + 1 < count[0]; i++) changed |= compose_cell(i, j, k);
    }
  }

  bool compose_cell(size_t i, size_t j, size_t k) {
    size_t corner[8];
    int inside = 0;
    for (int c = 0; c < 8; c++) {
      corner[c] = at(i + size_t(c & 1), j + size_t(c >> 1 & 1), k + size_t(c >> 2));
      inside |= int(value[corner[c]] < 0) << c;
    }
    if (inside == 0 || inside == 255) return false;
    // The two diagonals of each side as bits, then the four diagonals of the cell.
    constexpr int sides[6][2] = {{0x09, 0x06}, {0x90, 0x60}, {0x21, 0x12},
                                 {0x84, 0x48}, {0x41, 0x14}, {0x82, 0x28}};
    constexpr int diagonals[4] = {0x81, 0x42, 0x24, 0x18};
    int critical = 0;
    for (const auto &side : sides) {
      const int both = side[0] | side[1];
      if ((inside & both) == side[0] || (inside & both) == side[1]) critical = both;
    }
    for (const int diagonal : diagonals)
      if (inside == diagonal || inside == (255 ^ diagonal)) critical = diagonal;
    if (critical == 0) return false;
    size_t nearest = SIZE_MAX;
    for (int c = 0; c < 8; c++)
      if (critical >> c & 1 && (nearest == SIZE_MAX || std::abs(value[corner[c]]) < std::abs(value[nearest])))
        nearest = corner[c];
    value[nearest] = value[nearest] < 0 ? 1e-3 * cell : -1e-3 * cell;
    return true;
  }

  // The mean of the points where edges of the cell cross the surface.
  void add_vertex(size_t i, size_t j, size_t k, Surface &out) {
    Vec3 sum;
    int crossings = 0;
    for (int a = 0; a < 8; a++)
      for (int bit = 1; bit < 8; bit *= 2) {
        if (a & bit) continue;
        const int b = a | bit;
        const auto corner = [&](int c) {
          return value[at(i + size_t(c & 1), j + size_t(c >> 1 & 1), k + size_t(c >> 2))];
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
    vertex[at(i, j, k)] = uint32_t(out.vertices.size());
    out.vertices.push_back(point(double(i) + mean.x, double(j) + mean.y, double(k) + mean.z));
  }

  void add_quadrilateral(std::array<size_t, 3> p, int axis, Surface &out) {
    std::array<size_t, 3> next = p;
    next[size_t(axis)]++;
    const bool inside = value[at(p[0], p[1], p[2])] < 0;
    if (inside == (value[at(next[0], next[1], next[2])] < 0)) return;
    // The four cells around the edge, in the turn of a right hand whose thumb points along the axis.
    const size_t u = size_t(axis + 1) % 3, v = size_t(axis + 2) % 3;
    std::array<uint32_t, 4> corner;
    for (size_t c = 0; c < 4; c++) {
      std::array<size_t, 3> q = p;
      q[u] -= c == 0 || c == 3;
      q[v] -= c < 2;
      corner[c] = vertex[at(q[0], q[1], q[2])];
    }
    if (!inside) std::swap(corner[1], corner[3]);
    const auto span = [&](size_t a, size_t b) {
      return length(out.vertices[corner[a]] - out.vertices[corner[b]]);
    };
    const size_t first = span(0, 2) <= span(1, 3) ? 0 : 1; // split along the shorter diagonal
    for (size_t t = 0; t < 2; t++)
      for (const size_t c : {first, first + 1 + t, first + 2 + t}) out.faces.push_back(corner[c % 4]);
  }

  Vec3 origin;
  double cell;
  std::array<size_t, 3> count;
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
  Surface surface = Grid(distance, low, high, cell).surface();
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
