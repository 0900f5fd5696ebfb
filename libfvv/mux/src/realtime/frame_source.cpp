#include "mux/src/realtime/frame_source.h"

namespace fvv::mux {

void add_calibrations(const scene::Capture &capture, int64_t number, Frame &frame) {
  for (const scene::Camera &camera : capture.cameras) {
    if (!camera.is_calibrated(number))
      throw Unusable(capture.path + ": " + scene::describe(camera) + " has no calibration");
    frame.calibrations.push_back(camera.calibration_at(number));
  }
}

} // namespace fvv::mux
