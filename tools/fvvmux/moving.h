// fvvmux/moving.h: the calibration track of a stream, of all cameras that move. Knows the capture's
// calibrations and libfvv's encoder; nothing of the container.
#pragma once

#include "capture/capture.h"
#include "cli/owned.h"

#include <memory>
#include <optional>

namespace fvv::mux {

// Pixels by which the steps of a calibration may move a point of a picture, for all but the centre, which
// is off by less than a hundredth of what the lattice rounds away of a vertex.
constexpr double calibration_error = 0.01;

// The camera as its CAMR has it: one that moves, as it is in the first frame in which it is calibrated, and
// with the flag that says so.
fvv_camera described(const capture::Capture &capture, const capture::Camera &camera);

bool any_moves(const capture::Capture &capture);

class MovingCameras {
public:
  // The bits are chosen for all frames. lattice_step: metres. Throws cli::Failure.
  MovingCameras(const capture::Capture &capture, double lattice_step);

  // The payload of frame i of the capture; valid until the next call. Frames come in order, key at the first
  // of each group. Throws cli::Failure, naming the frame.
  const fvv_bytes &payload(size_t frame, bool key);

  // The cameras that are calibrated in frame i as decoders have them, by rising identifier. Any thread may
  // ask.
  std::vector<fvv_camera> decoded(size_t frame) const;

private:
  std::vector<fvv_camera> cameras_at(int64_t number) const;

  const capture::Capture &capture;
  std::vector<fvv_camera> constant; // as CAMR has them
  fvv_calibration_bits bits = {};
  std::unique_ptr<fvv_calibration, void (*)(fvv_calibration *)> encoder;
  cli::OwnedBytes bytes;
};

} // namespace fvv::mux
