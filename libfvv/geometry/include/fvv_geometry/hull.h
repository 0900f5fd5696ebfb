// Surfaces from regular grids, and visual hulls carved from silhouettes.
#pragma once

#include "fvv/calibration.h"
#include "fvv_render/vector.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace fvv::hull {

using render::Vec3;

struct Surface {
  std::vector<Vec3> vertices;
  std::vector<uint32_t> faces; // three indices each, counter-clockwise seen from outside
};

using render::Vec3;

struct Grid {
  Vec3 origin;                 // of point (0, 0, 0), metres
  double cell;                 // distance of neighbours along each axis, metres
  std::array<size_t, 3> count; // points along x, y, z

  size_t points() const { return count[0] * count[1] * count[2]; }
  size_t at(size_t i, size_t j, size_t k) const { return (k * count[1] + j) * count[0] + i; }
  size_t stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? count[0] : count[0] * count[1]; }
  Vec3 point(double i, double j, double k) const { return origin + Vec3{i, j, k} * cell; }
};

// The smallest grid of that cell from low to high or beyond.
Grid grid_over(Vec3 low, Vec3 high, double cell);

class Silhouette {
public:
  // mask: width x height of the camera, 0 outside the silhouette. camera is copied.
  Silhouette(const fvv_camera &camera, const std::vector<uint8_t> &mask);

  // The position of a world point relative to the silhouette.
  struct View {
    bool seen = false;    // within the picture; the other members are invalid otherwise
    double pixels = 0;    // distance from the outline, negative inside
    double metres = 0;    // the same at the depth of the point
    double pixel[2]{};    // where it is seen
    double per_metre = 0; // pixels that a metre across the ray covers there
    double depth = 0;     // z_c
  };
  View view(const double world[3]) const;
  // Whether all points within radius metres of a point seen there are certainly outside.
  bool clear_of(const View &view, double radius) const;

private:
  double at(double u, double v) const;

  fvv_camera camera;
  std::vector<float> distance; // of pixel centres
};

// Makes a signed grid well composed (Latecki, "3D well-composed pictures", 1997): where inside touches
// inside, or outside outside, across a diagonal only, a surface between the two would have edges of four
// triangles. value: one for each point, negative inside. Points of the cells concerned change sides, the
// nearest to the surface first, until no such diagonal is left. Points on the border of the grid, which must
// be outside, stay there.
void compose_well(const Grid &grid, std::vector<double> &value);

// Where along the edge from a point to its next one on an axis (0 x, 1 y, 2 z) the surface crosses, 0..1.
using Crossing = std::function<double(size_t point, int axis)>;

// The surface between points of negative value and the others. value is made well composed first, and its
// border must be outside: so the surface is always closed and a manifold, without a table of ambiguous cases.
// Vertices stay this far from the ends of their edges, in cells, so that no triangle loses its area.
constexpr double edge_margin = 0.05;
// crossing is called after value was made well composed, for edges whose ends differ in sign.
Surface march(const Grid &grid, std::vector<double> &value, const Crossing &crossing);

// The crossing by linear interpolation of the values.
inline double interpolated_crossing(const Grid &grid, const std::vector<double> &value, size_t point,
                                    int axis) {
  const double a = value[point], b = value[point + grid.stride(axis)];
  return a / (a - b);
}

// A point has to be seen by this many cameras to be inside. Cameras that do not see it are ignored.
constexpr size_t hull_cameras = 3;

// Where the ground is: nothing below it is inside.
struct Floor {
  Vec3 up;       // unit vector
  double height; // of the ground along it, metres
};

// The surface of the hull, cut off at the border of the grid and at the floor, if there is one; closed, faces
// counter-clockwise seen from outside. It may be empty.
Surface carve(const Grid &grid, const std::vector<Silhouette> &silhouettes,
              const std::optional<Floor> &floor);

} // namespace fvv::hull
