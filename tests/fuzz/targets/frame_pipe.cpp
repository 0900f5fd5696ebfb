// Frames from a pipe: what is read has the description's sizes, or the reader throws Error. It takes the
// bytes in any parts alike.
#include "../fuzz.h"

#include "fvv_cxx/error.h"
#include "mux/src/realtime/frame_pipe.h"

#include <algorithm>

namespace {

using fvv::mux::FramePipe;

// What a reader found, until the end or an error.
std::string read(const fuzz::Bytes &bytes, size_t most) {
  size_t at = 0;
  std::string found;
  try {
    FramePipe pipe(
        [&](void *to, size_t size) {
          const size_t count = std::min({size, most, bytes.size() - at});
          if (count) std::memcpy(to, bytes.data() + at, count);
          at += count;
          return count;
        },
        "pipe", {16 << 20, "the limit"});
    const std::vector<fvv::scene::Camera> &cameras = pipe.capture().cameras;
    for (int i = 0; i < 100; i++) {
      const FramePipe::Record record = pipe.next();
      found += std::to_string(record.kind) + std::to_string(record.number) + record.reason + "\n";
      if (record.kind == FramePipe::Record::end) return found;
      if (record.kind != FramePipe::Record::frame || record.number % 3 == 2) continue; // passed over
      try {
        const fvv::mux::Frame frame = pipe.take(cameras);
        fuzz::expect(frame.pictures.size() == cameras.size(), "there is a picture of each camera");
        for (size_t k = 0; k < cameras.size(); k++) {
          const fvv_camera &camera = cameras[k].calibration;
          const fvv::media::Image &picture = std::get<fvv::media::Image>(frame.pictures[k]);
          fuzz::expect(!cameras[k].pictures ||
                           (picture.width == camera.width && picture.height == camera.height),
                       "pictures have their camera's size");
        }
        for (const uint32_t index : frame.mesh.faces)
          fuzz::expect(index < frame.mesh.vertex_count(), "indices are in range");
        found += std::to_string(frame.mesh.face_count()) + "\n";
      } catch (const fvv::Error &error) {
        found += error.line() + "\n";
      }
    }
  } catch (const fvv::Error &error) {
    found += error.line();
  }
  return found;
}

} // namespace

FVV_FUZZ_TARGET(frame_pipe, fuzz::Form::bytes) {
  if (!size) return;
  const fuzz::Bytes bytes(data + 1, data + size);
  fuzz::expect(read(bytes, 1 + data[0]) == read(bytes, SIZE_MAX), "the parts of a pipe do not matter");
}
