// fvvmux/sample_frames.h: what the choice of a quality has made already, kept for when the frames' turn
// comes: video frames that it has composed, or, where a group of the stream is what it has encoded, that.
// Knows images and samples; reads nothing.
#pragma once

#include "fvv_media/video.h"

#include <map>
#include <mutex>
#include <optional>
#include <utility>
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

  // Frames first ... first + group.samples.size() - 1, with the settings of the choice.
  void keep_encoded(size_t first, media::EncodedGroup group) {
    const std::lock_guard<std::mutex> lock(mutex);
    encoded_first = first;
    encoded = std::move(group);
  }

  // What encoding frames first ... first + count - 1 together would give; whoever asks first has it.
  std::optional<media::EncodedGroup> take_encoded(size_t first, size_t count) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (!encoded || encoded_first != first || encoded->samples.size() != count) return std::nullopt;
    return std::exchange(encoded, std::nullopt);
  }

private:
  std::mutex mutex;
  size_t encoded_first = 0;
  std::optional<media::EncodedGroup> encoded;
  std::map<size_t, std::variant<media::Image, media::DeepImage, media::LinearImage>> images;
};

} // namespace fvv::mux
