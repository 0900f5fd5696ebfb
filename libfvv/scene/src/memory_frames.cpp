#include "fvv_scene/memory_frames.h"

#include "fvv_cxx/error.h"

#include <algorithm>

namespace fvv::scene {

void MemoryFrames::put(int64_t number, Frame frame) {
  // Masks of 0 and 1, as truth values become, mean 0 and 255.
  for (media::Image &mask : frame.masks)
    if (std::all_of(mask.pixels.begin(), mask.pixels.end(), [](uint8_t value) { return value <= 1; }))
      for (uint8_t &value : mask.pixels) value = value ? 255 : 0;
  const std::lock_guard<std::mutex> lock(mutex);
  frames.insert_or_assign(number, std::make_shared<const Frame>(std::move(frame)));
}

void MemoryFrames::drop_before(int64_t number) {
  const std::lock_guard<std::mutex> lock(mutex);
  frames.erase(frames.begin(), frames.lower_bound(number));
}

std::shared_ptr<const MemoryFrames::Frame> MemoryFrames::at(int64_t number) const {
  const std::lock_guard<std::mutex> lock(mutex);
  const auto found = frames.find(number);
  if (found == frames.end()) throw Error("frame " + std::to_string(number) + " is not in memory");
  return found->second;
}

geometry::Mesh MemoryFrames::mesh(int64_t number, bool normals) const {
  geometry::Mesh mesh = at(number)->mesh;
  if (!normals) mesh.normals.clear();
  return mesh;
}

template <class Sample> media::BasicImage<Sample> MemoryFrames::picture(int64_t number, size_t camera) const {
  const std::shared_ptr<const Frame> frame = at(number);
  const auto *image = std::get_if<media::BasicImage<Sample>>(&frame->pictures.at(camera));
  if (!image)
    throw Error(
        "frame " + std::to_string(number) + ": camera " + std::to_string(camera) +
        ": expected a picture with samples as the codec and its bit depth ask for, found another kind");
  return *image;
}

template media::Image MemoryFrames::picture(int64_t, size_t) const;
template media::DeepImage MemoryFrames::picture(int64_t, size_t) const;
template media::LinearImage MemoryFrames::picture(int64_t, size_t) const;

media::Image MemoryFrames::mask(int64_t number, size_t camera) const {
  return at(number)->masks.at(camera);
}

media::Sample MemoryFrames::sample(int64_t number, size_t track) const {
  return at(number)->samples.at(track);
}

std::vector<uint8_t> MemoryFrames::visibility(int64_t number, size_t camera) const {
  return at(number)->visibility.at(camera);
}

} // namespace fvv::scene
