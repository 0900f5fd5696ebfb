// fvvmux/verify_visibility.h: whether the bits of a frame that was read back are what its cameras see of its
// mesh, both as the stream has them. Knows streams; knows nothing of the capture.
#pragma once

#include "fvv/stream.h"
#include "fvvmux/plan.h"
#include "fvvmux/visibility.h"

#include <utility>

namespace fvv::mux {

class VisibilityVerifier {
public:
  // plan is borrowed.
  VisibilityVerifier(const Plan &chosen, std::string file) : plan(chosen), name(std::move(file)) {}

  // For the frames of a group one after the other. mesh: of the frame, as it was read. Answers "" or what is
  // wrong. Throws cli::Failure, named after the file, when the stream does not decode.
  std::string frame(fvv_stream *stream, size_t frame, const fvv_mesh &mesh);

private:
  const Plan &plan;
  const std::string name;
  States former; // of the frame before
};

} // namespace fvv::mux
