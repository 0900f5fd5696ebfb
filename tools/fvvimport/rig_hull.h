// The visual hull of the masks of a rig.
#pragma once

#include "fvv/calibration.h"
#include "fvv_geometry/hull.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace fvv::fvvimport {

struct RigHull {
  hull::Surface surface; // empty when nothing is in as many silhouettes as hull::hull_cameras
  // The camera that was ignored, because it alone denies many points that all others see: one wrong camera
  // would reduce the hull everywhere, and all cameras would look equally wrong. Searched among six cameras or
  // more.
  std::optional<size_t> excluded;
};
// masks[i] is of the size of cameras[i], nonzero inside. The same for any number of threads.
RigHull hull_of(const std::vector<fvv_camera> &cameras, const std::vector<std::vector<uint8_t>> &masks,
                uint32_t threads);

} // namespace fvv::fvvimport
