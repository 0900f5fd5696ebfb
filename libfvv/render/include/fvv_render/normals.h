// fvv_render/normals.h: normals of vertices from the faces around them. Knows triangles alone.
#pragma once

#include "fvv_render/rasteriser.h"

namespace fvv::render {

// For each vertex the sum of its faces' normals weighted with their areas, of unit length; zero where nothing
// is left of it. A vertex is an index: where charts of an atlas meet, the two sides have a normal each.
std::vector<Vec3> vertex_normals(const Mesh &mesh);

} // namespace fvv::render
