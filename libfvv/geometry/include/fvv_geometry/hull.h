// Visual hulls carved from silhouettes (Laurentini, "The visual hull concept for silhouette-based image
// understanding", 1994), by octree refinement (Szeliski, "Rapid octree construction from image sequences",
// 1993) and marching cubes.
#pragma once

#include "fvv_geometry/marching_cubes.h"
#include "fvv_geometry/silhouette.h"

#include <optional>
#include <vector>

namespace fvv::hull {

// A point has to be in the silhouettes of this number of cameras to be inside.
constexpr size_t hull_cameras = 3;

// Where the ground is: nothing below it is inside.
struct Floor {
  Vec3 up;       // unit vector
  double height; // of the ground along it, metres
};

// A point is inside when at least least_views cameras have it in their silhouettes, and at most missed of
// those that see it have not. Cameras that do not see it are ignored.
struct Options {
  size_t missed = 0;
  size_t least_views = hull_cameras; // 1 or more
  std::optional<Floor> floor;
  // Components whose volume is less than this fraction of the largest one's are dropped; 1 keeps the largest
  // alone. Cavities are components too: a dropped one is filled.
  double min_share = 0;
  // Rounds of Taubin's smoothing ("A signal processing approach to fair surface design", 1995). A vertex
  // moves only while it is within tolerance pixels of the outlines, or no farther from them than it was, and
  // by at most half a cell.
  size_t smoothing = 0;
  double tolerance = 0.5;
  unsigned threads = 1; // the result is the same for any number
};

struct Hull {
  // Closed, a manifold, faces counter-clockwise seen from outside; cut off at the border of the grid and at
  // the floor. It may be empty. Its crossings are where the vertices were before smoothing.
  Surface surface;
  Grid grid;
  std::vector<uint8_t> occupancy; // a bit for each point of the grid, the lowest first: 1 inside
  size_t components = 0;          // that are left, without cavities
  size_t dropped = 0;             // components, with cavities
};

// Limits, so that a cell that is too small is an error instead of an exhausted memory: about 130 MB of
// occupancy, and 1 GB of values near the surface.
constexpr size_t most_points = size_t(1) << 30;
constexpr size_t most_blocks = size_t(1) << 21; // of 4 x 4 x 4 points, in which values are known

// Values are known near the surface alone, so time and memory grow with the surface and not with the grid.
// Error when a limit is exceeded.
Hull carve(const Grid &grid, const std::vector<Silhouette> &silhouettes, const Options &options);

struct Box {
  Vec3 low, high;
};

// A box that holds the hull for these options (missed, least_views, floor and threads count): first in the
// cube around the space that the cameras look at (rig.h), then repeatedly in the box that a coarse octree
// leaves of it. Components with less than 0.5 % of the largest one's blocks are left out: a few pixels beside
// a camera are a body there when few others see the place. Nothing when nothing is inside.
std::optional<Box> bounds(const std::vector<Silhouette> &silhouettes, const Options &options);

// The cell that covers this number of pixels where the box is nearest to a camera; 0 when a camera is inside
// the box.
double cell_for(const std::vector<Silhouette> &silhouettes, const Box &box, double pixels);

} // namespace fvv::hull
