// Frames whose files appear in the folder of a capture.
#pragma once

#include "fvv_media/mask.h"
#include "fvv_media/video.h"
#include "fvv_scene/pictures.h"
#include "mux/src/realtime/frame_source.h"

#include <atomic>
#include <optional>

namespace fvv::mux {

class FolderSource : public FrameSource {
public:
  // capture: borrowed, restricted to what is sent. options: filled in. is_too_late: of the time at which a
  // frame arrived; such a frame is not read.
  FolderSource(const scene::Capture &capture, const Options &options, const RealtimeOptions &realtime,
               std::function<bool()> is_stopped, std::function<bool(Clock::time_point)> is_too_late);

  Item next() override;
  void close() override;

private:
  Item read(int64_t place, const Arrivals::Fate &fate);
  Frame read_frame(int64_t number);
  media::MaskRule mask_rule(size_t camera, const std::string &path);

  const scene::Capture &capture;
  const Options options;
  const std::function<bool(Clock::time_point)> is_too_late;
  scene::Videos videos;
  std::vector<scene::Camera> cameras; // with the rules of their masks, once these are decided
  std::vector<std::optional<media::MaskFacts>> mask_facts;
  int64_t place = 0; // the next one
  std::atomic<bool> closed{false};
  Arrivals arrivals; // last: it uses all others
};

} // namespace fvv::mux
