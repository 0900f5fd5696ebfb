#include "fvvsynth/rig.h"

#include "fvvsynth/skeleton.h"

#include <cmath>
#include <limits>

namespace fvv::synth {

std::vector<fvv_camera> make_rig(Random &random, uint32_t count, uint32_t width, uint32_t height) {
  constexpr double turn = 6.283185307179586, distance = 5.3, footprint = 0.014;
  std::vector<fvv_camera> rig;
  for (uint32_t i = 0; i < count; i++) {
    const double angle = turn * (i + random.between(-0.12, 0.12) + 0.35) / count;
    const Vec3 centre{distance * 1.06 * std::cos(angle), random.between(1.5, 3.0),
                      distance * 0.94 * std::sin(angle)};
    const Vec3 target{random.between(-0.1, 0.1), random.between(0.90, 1.00), random.between(-0.1, 0.1)};
    // Camera axes in the world: x right, y down, z forward.
    const Vec3 forward = normalised(target - centre), right = normalised(cross(forward, {0, 1, 0}));
    const Vec3 down = cross(forward, right);
    const Vec3 axes[3] = {right, down, forward};

    fvv_camera camera = {};
    camera.id = uint16_t(i);
    camera.lens = FVV_LENS_NONE;
    camera.width = width;
    camera.height = height;
    const double focal = distance / footprint * width / 480 * random.between(0.97, 1.03);
    camera.fx = focal;
    camera.fy = focal * random.between(0.999, 1.001);
    camera.cx = width * (0.5 + random.between(-0.01, 0.01));
    camera.cy = height * (0.5 + random.between(-0.01, 0.01));
    camera.r_max = std::numeric_limits<double>::infinity();
    for (int row = 0; row < 3; row++) {
      const Vec3 axis = axes[row];
      camera.rotation[3 * row] = axis.x;
      camera.rotation[3 * row + 1] = axis.y;
      camera.rotation[3 * row + 2] = axis.z;
      camera.translation[row] = -dot(axis, centre);
    }
    rig.push_back(camera);
  }
  return rig;
}

} // namespace fvv::synth
