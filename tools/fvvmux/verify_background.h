// fvvmux/verify_background.h: whether the environment that was read back is the capture's. Knows streams and
// the file that the capture names.
#pragma once

#include "fvv/stream.h"
#include "fvvmux/plan.h"

namespace fvv::mux {

// The environment that a reader finds for a group, if the plan has one: the one that was packed, all of it;
// for the first group also part by part and picture by picture what the capture has. Answers "" or what is
// wrong. Throws cli::Failure, named name, when the stream does not decode.
std::string verify_background(fvv_stream *stream, size_t group, const Plan &plan, const std::string &name);

} // namespace fvv::mux
