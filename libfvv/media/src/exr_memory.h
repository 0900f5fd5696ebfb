/* OpenEXR's streams and frame buffers over memory. Knows nothing of what files may hold. Internal to
 * fvv_media.
 */
#ifndef FVV_MEDIA_EXR_MEMORY_H
#define FVV_MEDIA_EXR_MEMORY_H

#include <ImfFrameBuffer.h>
#include <ImfIO.h>

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace fvv::media {

namespace exr = OPENEXR_IMF_NAMESPACE;

/* Bytes in memory as OpenEXR reads them. */
class Source : public exr::IStream {
public:
  Source(const uint8_t *bytes, size_t size) : IStream("memory"), bytes_(bytes), size_(size) {}
  bool read(char out[], int wanted) override {
    if (wanted < 0 || position_ > size_ || uint64_t(wanted) > size_ - position_)
      throw std::runtime_error("the file ends early");
    memcpy(out, bytes_ + position_, size_t(wanted));
    position_ += uint64_t(wanted);
    return position_ < size_;
  }
  uint64_t tellg() override { return position_; }
  void seekg(uint64_t position) override { position_ = position; }

private:
  const uint8_t *bytes_;
  uint64_t size_, position_ = 0;
};

/* And as OpenEXR writes them: blocks one after the other, then the table in front of them. */
class Sink : public exr::OStream {
public:
  Sink() : OStream("memory") {}
  void write(const char in[], int size) override {
    const size_t end = position_ + size_t(size);
    if (end > bytes.size()) bytes.resize(end);
    memcpy(bytes.data() + position_, in, size_t(size));
    position_ = end;
  }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = size_t(position); }

  std::vector<uint8_t> bytes;

private:
  size_t position_ = 0;
};

/* The channels of samples, half or float, that are interleaved, the first of which is that of pixel (left,
 * top). */
template <class Sample>
exr::FrameBuffer slices(const std::vector<std::string> &channels, Sample *samples, uint32_t width,
                        int32_t left, int32_t top) {
  constexpr exr::PixelType type = sizeof(Sample) == 2 ? exr::HALF : exr::FLOAT;
  const size_t pixel = channels.size() * sizeof(Sample), line = pixel * width;
  // OpenEXR counts from pixel (0, 0), which need not be in the image: an address, not a pointer.
  uintptr_t origin = reinterpret_cast<uintptr_t>(samples);
  origin -= uintptr_t(intptr_t(left) * intptr_t(pixel) + intptr_t(top) * intptr_t(line));
  exr::FrameBuffer buffer;
  for (size_t i = 0; i < channels.size(); i++)
    buffer.insert(channels[i],
                  exr::Slice(type, reinterpret_cast<char *>(origin + i * sizeof(Sample)), pixel, line));
  return buffer;
}

} // namespace fvv::media

#endif
