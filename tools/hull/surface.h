// A triangle mesh of points in space. Knows nothing of what it is the surface of.
#pragma once

#include "fvv_render/vector.h"

#include <cstdint>
#include <vector>

namespace fvv::hull {

using render::Vec3;

struct Surface {
  std::vector<Vec3> vertices;
  std::vector<uint32_t> faces; // three indices each, counter-clockwise seen from outside
};

} // namespace fvv::hull
