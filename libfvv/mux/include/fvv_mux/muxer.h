// From a capture to a stream.
#pragma once

#include "fvv_mux/options.h"
#include "fvv_mux/report.h"

#include <memory>
#include <string>

namespace fvv::mux {

// Encodes a capture as a stream: planned by the constructor, written by run().
class Muxer {
public:
  // Reads all files of the capture as far as needed and plans the stream. Throws Error.
  Muxer(const Options &options, const Observer &observer);
  ~Muxer();
  Muxer(Muxer &&) noexcept;

  size_t frame_count() const;

  // Writes the stream, once. The bytes depend on the capture and the options other than threads. Throws
  // Error, and exceptions of sink; then sink received an incomplete stream.
  Report run(const Sink &sink);

  // After run() with Options::verify: reads its stream back from a file and compares every frame with the
  // capture; the result belongs into Report::verdict. Throws Error, naming file and frame, when a frame is
  // missing or does not decode, when a mesh is not that of the source, when a picture is more than 10 dB
  // worse than the sample by which the quality was judged, or not exact where it is lossless, when a camera
  // projects elsewhere, when visibility is not what the camera sees of the mesh that was read, when sound or
  // environment are not those of the capture. shown: what messages call the file.
  Verdict verify(const std::string &path, const std::string &shown) const;

private:
  struct State;
  std::unique_ptr<State> state;
};

} // namespace fvv::mux
