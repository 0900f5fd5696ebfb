// The frames of a show from a pipe, as spec/frame-pipe.md has them.
#pragma once

#include "fvv_mux/encoder.h"
#include "fvv_scene/capture.h"

#include <functional>
#include <string>
#include <vector>

namespace fvv::mux {

class FramePipe {
public:
  struct Record {
    enum Kind { frame, lost, end };
    Kind kind = end;
    int64_t number = 0;      // of frame and lost, in the description's frames
    int64_t time = 0;        // of frame: microseconds since 1970 at which it was filmed; 0: not known
    std::string reason = ""; // of lost
  };
  // Reads 1 byte or more, at most size; returns 0 when there are no more. What it throws is passed on.
  using Read = std::function<size_t(void *bytes, size_t size)>;

  // Reads the description. name begins messages. limit: of what a frame takes. Throws Error with the offset.
  FramePipe(Read read, const std::string &name, const media::MemoryLimit &limit);

  const scene::Capture &capture() const { return description; }
  // The next record, of a frame without what it holds. What is not taken of the frame before is passed over.
  // Throws Error, with the offset, for what breaks the rules: nothing can be read after that.
  Record next();
  // What the frame holds: the mesh in metres, and pictures of 8 bits of the cameras that are wanted, in their
  // order. Once for each frame. Throws Error, also for a mesh that is unusable; then next() goes on.
  Frame take(const std::vector<scene::Camera> &wanted);

private:
  void fill(void *bytes, size_t size, const char *what);
  void pass(uint64_t size);
  [[noreturn]] void fail(uint64_t offset, const std::string &text) const;
  media::Image picture(const fvv_camera &camera, int channels);

  const Read read;
  const std::string name;
  const media::MemoryLimit limit;
  scene::Capture description;
  uint64_t pictures_size = 0; // of a frame
  uint64_t at = 0;            // offset of the next byte
  uint64_t left = 0;          // bytes of the current frame
  uint32_t vertices = 0, faces = 0;
  std::string current; // record, for messages
};

} // namespace fvv::mux
