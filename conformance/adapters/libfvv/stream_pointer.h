// A stream of libfvv that closes itself.
#pragma once

#include "fvv/stream.h"

#include <memory>

namespace fvv::conformance {

struct StreamCloser {
  void operator()(fvv_stream *stream) const { fvv_stream_close(stream); }
};
using StreamPointer = std::unique_ptr<fvv_stream, StreamCloser>;

} // namespace fvv::conformance
