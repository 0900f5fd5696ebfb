// Making a signed grid well composed (Latecki, "3D well-composed pictures", 1997): where inside touches
// inside, or outside outside, across a diagonal only, a surface between the two would have edges of four
// triangles. Knows values on a grid; knows no surface.
#pragma once

#include "hull/grid.h"

#include <vector>

namespace fvv::hull {

// value: one for each point, negative inside. Points of the cells concerned change sides, the nearest to the
// surface first, until no such diagonal is left. Points on the border of the grid, which must be outside,
// stay there.
void compose_well(const Grid &grid, std::vector<double> &value);

} // namespace fvv::hull
