#include "fvvmux/moving.h"

#include "cli/cli.h"

#include <algorithm>

namespace fvv::mux {

fvv_camera described(const capture::Capture &capture, const capture::Camera &camera) {
  fvv_camera out = camera.calibration;
  for (int64_t i = capture.frames.count; camera.moves() && i-- > 0;)
    if (camera.is_calibrated(capture.frames.number(i))) out = camera.calibration_at(capture.frames.number(i));
  out.flags = camera.moves() ? FVV_CAMERA_MOVES : 0;
  return out;
}

bool any_moves(const capture::Capture &capture) {
  return std::any_of(capture.cameras.begin(), capture.cameras.end(), [](const auto &c) { return c.moves(); });
}

std::vector<fvv_camera> MovingCameras::cameras_at(int64_t number) const {
  std::vector<fvv_camera> out;
  for (const capture::Camera &camera : capture.cameras)
    if (camera.moves() && camera.is_calibrated(number)) out.push_back(camera.calibration_at(number));
  return out;
}

MovingCameras::MovingCameras(const capture::Capture &source, double lattice_step)
    : capture(source), encoder(nullptr, fvv_calibration_destroy) {
  std::vector<fvv_camera> all;
  for (const capture::Camera &camera : capture.cameras) constant.push_back(described(capture, camera));
  for (const int64_t number : capture.frames.numbers())
    for (const fvv_camera &camera : cameras_at(number)) all.push_back(camera);
  fvv_calibration_choose(all.data(), all.size(), lattice_step / 128, calibration_error, &bits);
  fvv_calibration *created = nullptr;
  const fvv_status status = fvv_calibration_create(constant.data(), constant.size(), nullptr, &created);
  encoder.reset(created);
  cli::check(status, capture.path, {});
}

// What stands in a CALB does not depend on those before, but for how it is written.
std::vector<fvv_camera> MovingCameras::decoded(size_t frame) const {
  std::vector<fvv_camera> cameras = cameras_at(capture.frames.number(int64_t(frame)));
  fvv_calibration *created = nullptr;
  fvv_diagnostic diagnostic = {};
  cli::OwnedBytes scratch;
  fvv_status status = fvv_calibration_create(constant.data(), constant.size(), nullptr, &created);
  const decltype(encoder) key(created, fvv_calibration_destroy);
  if (status == FVV_OK)
    status =
        fvv_calibration_encode(created, &bits, cameras.data(), cameras.size(), true, &scratch, &diagnostic);
  cli::check(status, capture.path, diagnostic);
  for (fvv_camera &camera : cameras)
    cli::check(fvv_calibration_camera(created, camera.id, &camera), capture.path, {});
  return cameras;
}

const fvv_bytes &MovingCameras::payload(size_t frame, bool key) {
  const int64_t number = capture.frames.number(int64_t(frame));
  const std::vector<fvv_camera> cameras = cameras_at(number);
  fvv_diagnostic diagnostic = {};
  const fvv_status status =
      fvv_calibration_encode(encoder.get(), &bits, cameras.data(), cameras.size(), key, &bytes, &diagnostic);
  if (status < 0)
    throw cli::Failure(capture.path + ": frame " + std::to_string(number) + ": " + diagnostic.message);
  return bytes;
}

} // namespace fvv::mux
