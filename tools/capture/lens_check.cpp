#include "capture/lens_check.h"

#include <cstdio>

namespace fvv::capture {

namespace {

// On a grid from corner to corner.
double share_beyond(const fvv_camera &camera, int grid) {
  int beyond = 0;
  for (int i = 0; i < grid * grid; i++) {
    const double pixel[2] = {(i % grid) * double(camera.width) / (grid - 1),
                             (i / grid) * double(camera.height) / (grid - 1)};
    double ray[3];
    beyond += !fvv_camera_unproject(&camera, pixel, ray);
  }
  return double(beyond) / (grid * grid);
}

// The corners are farthest from the axis: where they have rays, so has all else.
double share_beyond(const fvv_camera &camera) {
  return share_beyond(camera, 2) > 0 ? share_beyond(camera, 64) : 0;
}

} // namespace

std::vector<LensGap> lens_gaps(const Capture &capture) {
  std::vector<LensGap> out;
  for (const Camera &camera : capture.cameras) {
    LensGap gap = {camera.calibration.id, camera.calibration.r_max, 0};
    const auto add = [&](const fvv_camera &one) {
      const double share = one.lens == FVV_LENS_NONE ? 0 : share_beyond(one);
      if (share > gap.share) gap = {gap.camera, one.r_max, share};
    };
    if (!camera.moves()) add(camera.calibration);
    for (const auto &[frame, calibration] : camera.per_frame) add(calibration);
    if (gap.share > 0) out.push_back(gap);
  }
  return out;
}

std::string text_of(const std::vector<LensGap> &gaps) {
  std::string out;
  for (const LensGap &gap : gaps) {
    char line[160];
    std::snprintf(line, sizeof line,
                  "  lens      camera %u: %.1f %% of the picture lie beyond r_max %.4g and are not used\n",
                  gap.camera, 100 * gap.share, gap.r_max);
    out += line;
  }
  return out;
}

} // namespace fvv::capture
