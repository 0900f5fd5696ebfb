// Frames that a program writes to a pipe.
#pragma once

#include "mux/src/realtime/frame_pipe.h"
#include "mux/src/realtime/frame_source.h"

#include <atomic>
#include <optional>

namespace fvv::mux {

// The bytes of a descriptor, as they come.
class PipeBytes {
public:
  // Why no more are waited for.
  struct Ended {
    FrameSource::Item::Kind kind;
    std::string reason;
  };

  PipeBytes(const std::string &shown, int from, double most_idle, std::function<bool()> stopped)
      : name(shown), descriptor(from), idle(most_idle), is_stopped_by_user(std::move(stopped)) {}

  // As FramePipe wants it. Throws Ended when the wait is over, and Error.
  size_t read(void *bytes, size_t size);
  bool is_stopped() const { return closed || (is_stopped_by_user && is_stopped_by_user()); }
  void close() { closed = true; }

private:
  const std::string name;
  const int descriptor; // borrowed
  const double idle;    // seconds
  const std::function<bool()> is_stopped_by_user;
  std::atomic<bool> closed{false};
};

// The pipe of a run, from its description on.
struct OpenPipe {
  PipeBytes bytes;
  FramePipe frames;

  // Reads the description. name: in messages. Throws Error, also when nothing comes.
  OpenPipe(const std::string &name, const RealtimeOptions &realtime, const std::function<bool()> &is_stopped,
           const media::MemoryLimit &limit);
};

class PipeSource : public FrameSource {
public:
  // capture: borrowed, that of the pipe, restricted to what is sent. options: filled in. is_too_late: of the
  // time at which a frame was filmed, or its head was read; such a frame is passed over.
  PipeSource(std::unique_ptr<OpenPipe> pipe, const scene::Capture &capture, const Options &options,
             std::function<bool(Clock::time_point)> is_too_late);

  Item next() override;
  void close() override { pipe->bytes.close(); }

private:
  Item read();
  Item missing();
  Item take(const FramePipe::Record &record);
  Item failed(const std::string &text) const;
  int64_t place_of(int64_t number) const;

  const std::unique_ptr<OpenPipe> pipe;
  const scene::Capture &capture;
  const Options options;
  const std::function<bool(Clock::time_point)> is_too_late;
  int64_t place = 0;                        // the next one
  std::optional<FramePipe::Record> waiting; // was read, and places before it are missing
  std::optional<Item> last;                 // follows the item that was returned
};

} // namespace fvv::mux
