#include "fvv_geometry/marching_cubes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <set>
#include <unordered_map>
#include <utility>

namespace fvv::hull {

Grid grid_over(Vec3 low, Vec3 high, double cell) {
  const auto points = [&](double extent) { return size_t(std::ceil(extent / cell)) + 1; };
  return {low, cell, {points(high.x - low.x), points(high.y - low.y), points(high.z - low.z)}};
}

namespace {

// The corners of a cell, as bits x = 1, y = 2, z = 4 of their number, that a forbidden diagonal concerns; 0
// when there is none. inside: bit c for corner c.
int critical_corners(int inside) {
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
    if (inside == diagonal || inside == (0xff ^ diagonal)) critical = diagonal;
  return critical;
}

} // namespace

namespace {

class Dense : public Field {
public:
  explicit Dense(std::vector<double> &of) : values(of) {}
  double value(size_t point) const override { return values[point]; }
  void set(size_t point, double value) override { values[point] = value; }

private:
  std::vector<double> &values;
};

std::array<size_t, 8> corners_of(const Grid &grid, size_t cell) {
  std::array<size_t, 8> out;
  for (int c = 0; c < 8; c++)
    out[size_t(c)] =
        cell + size_t(c & 1) + size_t(c >> 1 & 1) * grid.stride(1) + size_t(c >> 2) * grid.stride(2);
  return out;
}

// Bit c for corner c, numbered by bits x = 1, y = 2, z = 4.
int signs(const Field &field, const std::array<size_t, 8> &corner) {
  int inside = 0;
  for (int c = 0; c < 8; c++) inside |= int(field.value(corner[size_t(c)]) < 0) << c;
  return inside;
}

std::vector<size_t> mixed_cells(const Grid &grid, const std::vector<double> &value) {
  std::vector<size_t> out;
  for (size_t k = 0; k + 1 < grid.count[2]; k++)
    for (size_t j = 0; j + 1 < grid.count[1]; j++)
      for (size_t i = 0; i + 1 < grid.count[0]; i++) {
        const std::array<size_t, 8> corner = corners_of(grid, grid.at(i, j, k));
        const bool first = value[corner[0]] < 0;
        if (std::any_of(corner.begin(), corner.end(), [&](size_t c) { return (value[c] < 0) != first; }))
          out.push_back(corner[0]);
      }
  return out;
}

// Calls visit with the first points of the up to eight cells around a point.
template <class Visit> void cells_around(const Grid &grid, size_t point, Visit visit) {
  const std::array<size_t, 3> p = grid.place(point);
  for (int c = 0; c < 8; c++) {
    const size_t back[3] = {size_t(c & 1), size_t(c >> 1 & 1), size_t(c >> 2)};
    bool there = true;
    for (size_t a = 0; a < 3; a++) there = there && p[a] >= back[a] && p[a] - back[a] + 1 < grid.count[a];
    if (there) visit(point - back[0] - back[1] * grid.stride(1) - back[2] * grid.stride(2));
  }
}

// Rounds over the cells in their order, each as if over all cells of the grid; those without a diagonal are
// passed over. mixed: as march() has it, before and after.
void compose(const Grid &grid, Field &field, std::vector<size_t> &mixed) {
  // Changes to either side stay nearest to the surface, but may alternate without end; growth terminates.
  constexpr int free_rounds = 8;
  std::set<size_t> now, next, touched;
  for (const size_t cell : mixed)
    if (critical_corners(signs(field, corners_of(grid, cell)))) now.insert(now.end(), cell);
  for (int round = 0; !now.empty(); round++) {
    while (!now.empty()) {
      const size_t cell = *now.begin();
      now.erase(now.begin());
      const std::array<size_t, 8> corner = corners_of(grid, cell);
      const int inside = signs(field, corner);
      int critical = critical_corners(inside);
      if (critical == 0) continue;
      if (round >= free_rounds) critical = (critical & ~inside) ? critical & ~inside : 0xff & ~inside;
      size_t nearest = SIZE_MAX;
      double least = 0;
      for (int c = 0; c < 8; c++) {
        const double size = std::abs(field.value(corner[size_t(c)]));
        if (critical >> c & 1 && (nearest == SIZE_MAX || size < least))
          nearest = corner[size_t(c)], least = size;
      }
      field.set(nearest, (field.value(nearest) < 0 ? 1e-3 : -1e-3) * grid.cell);
      cells_around(grid, nearest, [&](size_t around) {
        (around > cell ? now : next).insert(around);
        touched.insert(around);
      });
    }
    std::swap(now, next);
  }
  if (touched.empty()) return;
  std::vector<size_t> all;
  std::set_union(mixed.begin(), mixed.end(), touched.begin(), touched.end(), std::back_inserter(all));
  mixed.clear();
  for (const size_t cell : all) {
    const int inside = signs(field, corners_of(grid, cell));
    if (inside != 0 && inside != 0xff) mixed.push_back(cell);
  }
}

} // namespace

void compose_well(const Grid &grid, std::vector<double> &value) {
  Dense field(value);
  std::vector<size_t> mixed = mixed_cells(grid, value);
  compose(grid, field, mixed);
}

namespace {

// Corners of a cell are numbered by bits x = 1, y = 2, z = 4; its edges by axis (4 * axis) and by the other
// two bits of their lower corner.
int edge_between(int a, int b) {
  const int low = a & b, bit = a ^ b;
  const int axis = bit >> 1; // 1, 2, 4 -> 0, 1, 2
  const int others = axis == 0 ? low >> 1 : axis == 1 ? (low & 1) | (low >> 1 & 2) : low & 3;
  return 4 * axis + others;
}
int lower_corner(int edge) {
  const int others = edge % 4;
  return edge < 4 ? others << 1 : edge < 8 ? (others & 1) | (others & 2) << 1 : others;
}

// For each of the 256 cases the triangles as numbers of edges, ended by the size. Sides of a well-composed
// cell are crossed by one line or none, so the lines join into unambiguous loops.
struct Cases {
  std::array<std::array<int8_t, 36>, 256> edges;
  std::array<uint8_t, 256> size{};

  Cases() {
    // Each side's corners, counter-clockwise seen from outside the cell.
    constexpr int sides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 4, 6, 2},
                                 {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}};
    for (int inside = 0; inside < 256; inside++) {
      std::array<int, 12> next;
      next.fill(-1);
      for (const auto &side : sides) {
        int leaves = -1, enters = -1;
        for (int c = 0; c < 4; c++) {
          const int a = side[c], b = side[(c + 1) % 4];
          const bool in_a = inside >> a & 1, in_b = inside >> b & 1;
          if (in_a && !in_b) leaves = edge_between(a, b);
          if (!in_a && in_b) enters = edge_between(a, b);
        }
        if (enters >= 0) next[size_t(enters)] = leaves;
      }
      for (int start = 0; start < 12; start++) {
        std::vector<int> circle;
        for (int at = start; at >= 0 && next[size_t(at)] >= 0;) {
          circle.push_back(at);
          at = std::exchange(next[size_t(at)], -1);
        }
        // Two corners of the circle that are not neighbours share no side, so the lines of a fan never meet
        // those of the next cell.
        for (size_t i = 2; i < circle.size(); i++)
          for (const int e : {circle[0], circle[i - 1], circle[i]})
            edges[size_t(inside)][size[size_t(inside)]++] = int8_t(e);
      }
    }
  }
};

} // namespace

Surface march(const Grid &grid, std::vector<double> &value, const Crossing &crossing) {
  Dense field(value);
  return march(grid, field, mixed_cells(grid, value), crossing);
}

Surface march(const Grid &grid, Field &field, std::vector<size_t> mixed, const Crossing &crossing) {
  static const Cases cases;
  compose(grid, field, mixed);
  std::unordered_map<uint64_t, uint32_t> vertex; // on an edge
  vertex.reserve(mixed.size());
  Surface out;
  for (const size_t cell : mixed) {
    const std::array<size_t, 8> corner = corners_of(grid, cell);
    const size_t inside = size_t(signs(field, corner));
    for (size_t n = 0; n < cases.size[inside]; n++) {
      const int edge = cases.edges[inside][n], axis = edge / 4;
      const size_t point = corner[size_t(lower_corner(edge))];
      const auto [at, is_new] =
          vertex.try_emplace(3 * uint64_t(point) + uint64_t(axis), uint32_t(out.vertices.size()));
      if (is_new) {
        const double t = std::clamp(crossing(point, axis), edge_margin, 1 - edge_margin);
        const std::array<size_t, 3> p = grid.place(point);
        out.vertices.push_back(grid.point(double(p[0]) + (axis == 0 ? t : 0),
                                          double(p[1]) + (axis == 1 ? t : 0),
                                          double(p[2]) + (axis == 2 ? t : 0)));
        out.crossings.push_back({at->first, float(t)});
      }
      out.faces.push_back(at->second);
    }
  }
  return out;
}

} // namespace fvv::hull
