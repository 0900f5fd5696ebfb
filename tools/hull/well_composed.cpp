#include "hull/well_composed.h"

#include <cmath>
#include <cstdint>

namespace fvv::hull {

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
  // Changes to either side stay nearest to the surface, but may go to and fro for ever; growth comes to an
  // end.
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

} // namespace fvv::hull
