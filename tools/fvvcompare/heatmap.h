// fvvcompare/heatmap.h: a mesh whose colours tell how far each vertex is off, as a file for any viewer. Knows
// PLY; measures nothing.
#pragma once

#include "fvv_scene/mesh_file.h"

#include <string>
#include <vector>

namespace fvv::compare {

// PLY, binary_little_endian: x y z as double, the distance as float, red green blue as uchar, in the colours
// of viridis: dark blue for 0, yellow for most and beyond. distances: of each vertex; most: >= 0.
std::string format_heatmap(const geometry::Mesh &mesh, const std::vector<double> &distances, double most);

} // namespace fvv::compare
