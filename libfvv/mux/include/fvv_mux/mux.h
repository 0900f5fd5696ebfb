// From a capture to a stream.
#pragma once

#include "fvv_cxx/input_file.h"
#include "fvv_mux/summary.h"

#include <chrono>

namespace fvv::mux {

// Encodes a capture as a stream: planned by the constructor, written by run().
class Muxer {
public:
  // Reads all files of the capture as far as needed and plans the stream. Throws Error.
  Muxer(const Options &options, const Observer &observer);

  size_t frame_count() const { return summary.plan.frame_count(); }

  // Writes the stream, once. The bytes depend on the capture and the options other than threads. Throws
  // Error, and exceptions of sink; then sink received an incomplete stream.
  Summary run(const Sink &sink);

private:
  std::chrono::steady_clock::time_point start;
  Summary summary;
};

// Reads the stream of a run with Options::verify back from a file and compares every frame with the capture.
// Throws Error.
void verify(Summary &summary, const InputFile &file);

} // namespace fvv::mux
