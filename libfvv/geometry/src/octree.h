// Which cubes of points are certainly inside or outside of a hull.
#pragma once

#include "fvv_geometry/hull.h"

namespace fvv::hull {

// A cube of blocks of points: size of them along each side, from block (x, y, z) on. What is certain of a
// camera for the cube holds for its parts, so that these examine the other cameras alone.
struct Cube {
  uint32_t x, y, z, size;
  std::vector<uint32_t> unsure;   // cameras
  size_t inside = 0, outside = 0; // numbers of cameras that are certain
};

class Octree {
public:
  static constexpr size_t block = 4; // points along the side of a block

  Octree(const Grid &grid, const std::vector<Silhouette> &silhouettes, const Options &options);

  enum class Verdict { inside, outside, mixed };
  // Changes what is known of cameras.
  Verdict examine(Cube &cube) const;

  // The blocks that are neither certainly inside nor certainly outside, each once, and the cubes that are
  // certainly inside. The same for any number of threads. Error for more than most_blocks.
  struct Leaves {
    std::vector<Cube> mixed, inside;
  };
  Leaves refine() const;

  // Of a point of a leaf: metres, negative inside, at most two cells either way. Of the signed distances from
  // the silhouettes in rising order, the one after missed from the end, but not before the one of number
  // least_views: the surface of the options' definition of inside, at the precision of the distances. Cameras
  // that are certain for the leaf are farther from the surface than its points are from each other, and so
  // only their side counts. distances: memory for the call.
  double value(Vec3 p, const Cube &leaf, std::vector<double> &distances) const;

  const std::array<size_t, 3> blocks; // along each axis

private:
  const Grid &grid;
  const std::vector<Silhouette> &silhouettes;
  const Options &options;
};

// How far a point is below the floor, metres; minus infinity without a floor.
double depth_below(const std::optional<Floor> &floor, Vec3 p);

} // namespace fvv::hull
