// Normals of vertices, and on which side of its faces a mesh has its outside.
#pragma once

#include "fvv_render/rasteriser.h"

namespace fvv::render {

// For each vertex the sum of its faces' normals weighted with their areas, of unit length; zero where it
// cancels. A vertex is an index: where charts of an atlas meet, the two sides have a normal each.
std::vector<Vec3> vertex_normals(const Mesh &mesh);

// Whether the faces enclose a negative volume: they run anticlockwise seen from within. For open surfaces,
// which enclose none, the volume towards the mean of their vertices is used if it exceeds rounding errors.
bool inside_out(const Mesh &mesh);

} // namespace fvv::render
