// fvvmux/verify_visibility.h: whether the bits of a frame that was read back are what its cameras see of its
// mesh, both as the stream has them. Knows streams; knows nothing of the capture.
#pragma once

#include "fvv/stream.h"
#include "fvvmux/plan.h"

namespace fvv::mux {

// mesh: of the frame, as it was read. Answers "" or what is wrong. Throws cli::Failure, named name, when the
// stream does not decode.
std::string verify_visibility(fvv_stream *stream, size_t frame, const fvv_mesh &mesh, const Plan &plan,
                              const std::string &name);

} // namespace fvv::mux
