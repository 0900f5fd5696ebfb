// A closed surface cut into charts: pieces that lie flat, without overlap, when they are seen along one axis.
// Knows triangles and directions; knows no texels.
#pragma once

#include "fvv_geometry/hull.h"

#include <array>
#include <cstdint>
#include <vector>

namespace fvv::synth {

using hull::Surface;
using render::Mat3;
using render::Vec3;

using Flat = std::array<double, 2>;

// The orthographic projection of a piece of surface on a plane with the unit vectors right and up.
struct Chart {
  std::vector<uint32_t> faces; // connected; counter-clockwise on the plane, as seen from outside
  Vec3 right, up;

  Flat flat(Vec3 p) const { return {dot(p, right), dot(p, up)}; }
};

// Every face is in one chart. region: of each face, an index of axes; a chart lies in one region, and it is
// projected along one of its region's axes, which are orthonormal (y is up in most of its charts). Areas
// shrink to 1 / sqrt(3) at least where a face has its own nearest axis, and to 0.36 at least where it was
// given that of its neighbours, for fewer and smoother borders. Every face must have area. Triangles of a
// chart overlap nowhere; two of them that do, like a sleeve before an arm, go to different charts.
std::vector<Chart> make_charts(const Surface &surface, const std::vector<uint8_t> &region,
                               const std::vector<Mat3> &axes);

} // namespace fvv::synth
