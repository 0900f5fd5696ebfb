// What is done to the mesh of a hull.
#pragma once

#include "fvv_geometry/hull.h"

namespace fvv::hull {

// Counts components, and drops those whose volume is less than min_share of the largest one's, from the
// surface and from the occupancy.
void drop_components(Hull &hull, double min_share);

// As Options has it.
void smooth(Hull &hull, const std::vector<Silhouette> &silhouettes, const Options &options);

} // namespace fvv::hull
