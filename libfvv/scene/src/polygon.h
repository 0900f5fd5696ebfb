// Polygons of more than three corners as triangles.
#pragma once

#include "fvv_scene/mesh_file.h"

#include <algorithm>

namespace fvv::scene {

// Where the fan of a polygon is in the faces of a mesh: corners - 2 triangles from this one on.
struct Polygon {
  size_t first_triangle;
  uint32_t corners;
};

// Polygons whose fan leaves them, and how their corners (from 0) make triangles instead.
class ConcavePolygons {
public:
  // The faces of mesh hold the fan of each polygon; its vertices are there. Counts those that cross
  // themselves in report. Error if the work exceeds a bound that only made-up files reach.
  ConcavePolygons(const Mesh &mesh, const std::vector<Polygon> &polygons, MeshReport &report,
                  const std::string &name);

  // Rearranges values that belong to the corners of the faces, width of them to each, in the order of the
  // fans.
  template <class Value> void apply(std::vector<Value> &values, size_t width) const {
    if (values.empty()) return;
    std::vector<Value> of_corner;
    for (const auto &[polygon, triangles] : split) {
      Value *fan = &values[polygon.first_triangle * 3 * width];
      of_corner.assign(fan, fan + 2 * width); // corners 0 and 1
      for (size_t t = 0; t + 2 < polygon.corners; t++)
        of_corner.insert(of_corner.end(), fan + (3 * t + 2) * width, fan + (3 * t + 3) * width);
      for (const uint32_t corner : triangles) fan = std::copy_n(&of_corner[corner * width], width, fan);
    }
  }

private:
  struct Split {
    Polygon polygon;
    std::vector<uint32_t> triangles; // three corners each
  };
  std::vector<Split> split;
};

} // namespace fvv::scene
