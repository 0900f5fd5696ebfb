/* OpenEXR's streams and frame buffers over memory. Knows nothing of what files may hold. Internal to
 * fvv_media.
 */
#ifndef FVV_MEDIA_EXR_MEMORY_H
#define FVV_MEDIA_EXR_MEMORY_H

#include "fvv_cxx/error.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>

#include <cstdint>
#include <cstring>
#include <new>
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

/* A whole file of interleaved samples, half or float. dwa_level: of DWA; 0: the compression has none. */
template <class Sample>
std::vector<uint8_t> write_exr(const std::vector<std::string> &channels, const Sample *samples,
                               uint32_t width, uint32_t height, exr::Compression compression,
                               int dwa_level = 0) {
  try {
    exr::Header header{int(width), int(height)};
    header.compression() = compression;
    if (dwa_level) header.dwaCompressionLevel() = float(dwa_level);
    const exr::Channel channel(sizeof(Sample) == 2 ? exr::HALF : exr::FLOAT);
    for (const std::string &name : channels) header.channels().insert(name, channel);
    Sink sink;
    {
      exr::OutputFile file(sink, header, 0);
      // OpenEXR's buffers serve both ways and know no const; writing leaves them as they are.
      file.setFrameBuffer(slices<Sample>(channels, const_cast<Sample *>(samples), width, 0, 0));
      file.writePixels(int(height));
    } // writes the table of blocks
    return std::move(sink.bytes);
  } catch (const std::bad_alloc &) {
    throw;
  } catch (const std::exception &error) {
    throw Error(std::string("a picture cannot be written as OpenEXR: ") + error.what());
  }
}

} // namespace fvv::media

#endif
