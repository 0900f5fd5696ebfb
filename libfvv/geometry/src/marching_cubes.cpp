#include "fvv_geometry/hull.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
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

void compose_well(const Grid &grid, std::vector<double> &value) {
  // Changes to either side stay nearest to the surface, but may alternate without end; growth terminates.
  constexpr int free_rounds = 8;
  bool changed = true;
  for (int round = 0; changed; round++) {
    changed = false;
    for (size_t k = 0; k + 1 < grid.count[2]; k++)
      for (size_t j = 0; j + 1 < grid.count[1]; j++)
        for (size_t i = 0; i + 1 < grid.count[0]; i++) {
          size_t corner[8];
          int inside = 0;
          for (int c = 0; c < 8; c++) {
            corner[c] = grid.at(i + size_t(c & 1), j + size_t(c >> 1 & 1), k + size_t(c >> 2));
            inside |= int(value[corner[c]] < 0) << c;
          }
          if (inside == 0 || inside == 255) continue;
          int critical = critical_corners(inside);
          if (critical == 0) continue;
          if (round >= free_rounds) critical = (critical & ~inside) ? critical & ~inside : 0xff & ~inside;
          size_t nearest = SIZE_MAX;
          for (int c = 0; c < 8; c++)
            if (critical >> c & 1 &&
                (nearest == SIZE_MAX || std::abs(value[corner[c]]) < std::abs(value[nearest])))
              nearest = corner[c];
          value[nearest] = value[nearest] < 0 ? 1e-3 * grid.cell : -1e-3 * grid.cell;
          changed = true;
        }
  }
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
  static const Cases cases;
  compose_well(grid, value);
  constexpr uint32_t no_vertex = UINT32_MAX;
  std::vector<uint32_t> vertex(grid.points() * 3, no_vertex); // on the edge from a point along an axis
  Surface out;
  for (size_t k = 0; k + 1 < grid.count[2]; k++)
    for (size_t j = 0; j + 1 < grid.count[1]; j++)
      for (size_t i = 0; i + 1 < grid.count[0]; i++) {
        size_t inside = 0;
        for (int c = 0; c < 8; c++)
          inside |= size_t(value[grid.at(i + size_t(c & 1), j + size_t(c >> 1 & 1), k + size_t(c >> 2))] < 0)
                    << c;
        for (size_t n = 0; n < cases.size[inside]; n++) {
          const int edge = cases.edges[inside][n], corner = lower_corner(edge), axis = edge / 4;
          const std::array<size_t, 3> p = {i + size_t(corner & 1), j + size_t(corner >> 1 & 1),
                                           k + size_t(corner >> 2)};
          const size_t point = grid.at(p[0], p[1], p[2]);
          uint32_t &index = vertex[3 * point + size_t(axis)];
          if (index == no_vertex) {
            index = uint32_t(out.vertices.size());
            const double t = std::clamp(crossing(point, axis), edge_margin, 1 - edge_margin);
            out.vertices.push_back(grid.point(double(p[0]) + (axis == 0 ? t : 0),
                                              double(p[1]) + (axis == 1 ? t : 0),
                                              double(p[2]) + (axis == 2 ? t : 0)));
          }
          out.faces.push_back(index);
        }
      }
  return out;
}

} // namespace fvv::hull
