// The space that a rig of cameras looks at.
#pragma once

#include "fvv/calibration.h"
#include "fvv_render/vector.h"

#include <vector>

namespace fvv::geometry {

struct RigSpace {
  render::Vec3
      centre;    // the point nearest to all optical axes, metres; the cameras' mean when they are parallel
  double radius; // of the farthest camera from it, metres; 1 if all are there
};
// At least one camera.
RigSpace rig_space(const std::vector<fvv_camera> &cameras);

} // namespace fvv::geometry
