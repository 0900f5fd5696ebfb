// fvvmux/sample_frames.h: video frames that the choice of a quality has composed, kept for when they are
// encoded: reading them is a fifth of the pictures of a short clip. Knows images; reads nothing.
#pragma once

#include "fvv_media/image.h"

#include <map>
#include <mutex>
#include <optional>
#include <variant>

namespace fvv::mux {

class SampleFrames {
public:
  template <class Sample> void keep(size_t frame, media::BasicImage<Sample> image) {
    const std::lock_guard<std::mutex> lock(mutex);
    images.insert_or_assign(frame, std::move(image));
  }

  // Whoever asks first has it; nothing when the frame is not there, or no longer.
  template <class Sample> std::optional<media::BasicImage<Sample>> take(size_t frame) {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto node = images.extract(frame);
    if (node.empty()) return std::nullopt;
    return std::get<media::BasicImage<Sample>>(std::move(node.mapped()));
  }

private:
  std::mutex mutex;
  std::map<size_t, std::variant<media::Image, media::DeepImage, media::LinearImage>> images;
};

} // namespace fvv::mux
