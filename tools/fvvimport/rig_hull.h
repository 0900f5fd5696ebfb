// The space that a rig of cameras looks at, and the visual hull of masks there.
#pragma once

#include "fvv/calibration.h"
#include "fvv_geometry/hull.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace fvv::fvvimport {

struct RigSpace {
  render::Vec3
      centre;    // the point nearest to all optical axes, metres; the cameras' mean when they are parallel
  double radius; // of the farthest camera from it, metres; 1 if all are there
};
// At least one camera.
RigSpace rig_space(const std::vector<fvv_camera> &cameras);

struct RigHull {
  hull::Surface surface; // empty when nothing is in as many silhouettes as hull::hull_cameras
  // The camera that was ignored, because it alone denies many points that all others see: one wrong camera
  // would reduce the hull everywhere, and all cameras would look equally wrong. Searched among six cameras or
  // more.
  std::optional<size_t> excluded;
};
// The visual hull of silhouettes: first in the cube around the space that the cameras look at, then
// repeatedly in the box that a coarse grid leaves of it. masks[i] is of the size of cameras[i], nonzero
// inside. The same for any number of threads.
RigHull hull_of(const std::vector<fvv_camera> &cameras, const std::vector<std::vector<uint8_t>> &masks,
                uint32_t threads);

} // namespace fvv::fvvimport
