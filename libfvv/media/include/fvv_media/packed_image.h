/* fvv_media/packed_image.h: a picture in less memory, for keeping. Lossless; small for masks and for pictures
 * with a flat background. */
#ifndef FVV_MEDIA_PACKED_IMAGE_H
#define FVV_MEDIA_PACKED_IMAGE_H

#include "fvv_media/image.h"

#include <algorithm>
#include <cstring>

namespace fvv::media {

template <class SampleType> class PackedImage {
public:
  explicit PackedImage(const BasicImage<SampleType> &image)
      : width_(image.width), height_(image.height), channels_(image.channels) {
    if (image.pixels.empty()) return;
    const size_t step = size_t(channels_), count = image.pixels.size() / step;
    const SampleType *pixels = image.pixels.data();
    const auto repeats = [&](size_t i) {
      return i && !memcmp(pixels + i * step, pixels + (i - 1) * step, step * sizeof(SampleType));
    };
    for (size_t i = 0; i < count;) {
      const size_t begin = i, most = std::min<size_t>(count, begin + UINT16_MAX);
      while (i < most && !repeats(i)) i++;
      const size_t middle = i, end = std::min<size_t>(count, middle + UINT16_MAX);
      while (i < end && repeats(i)) i++;
      distinct_.insert(distinct_.end(), pixels + begin * step, pixels + middle * step);
      spans_.push_back({uint16_t(middle - begin), uint16_t(i - middle)});
    }
    spans_.shrink_to_fit();
    distinct_.shrink_to_fit();
  }

  BasicImage<SampleType> image() const {
    const size_t step = size_t(channels_);
    BasicImage<SampleType> image = {width_, height_, channels_, {}};
    image.pixels.resize(size_t(width_) * height_ * step);
    const SampleType *from = distinct_.data();
    SampleType *to = image.pixels.data();
    for (const PixelSpan &span : spans_) {
      to = std::copy_n(from, span.distinct * step, to);
      from += span.distinct * step;
      // What is repeated already is copied as a whole.
      const SampleType *const last = to - step;
      for (size_t left = span.repeated * step; left;) {
        const size_t length = std::min<size_t>(left, size_t(to - last));
        to = std::copy_n(last, length, to);
        left -= length;
      }
    }
    return image;
  }

  /* Of memory, about. */
  size_t bytes() const {
    return sizeof *this + spans_.size() * sizeof(PixelSpan) + distinct_.size() * sizeof(SampleType);
  }

private:
  struct PixelSpan {
    uint16_t distinct; /* pixels that differ from the one before, or continue where a span was full */
    uint16_t repeated; /* pixels after them, equal to the last one */
  };
  uint32_t width_, height_;
  int channels_;
  std::vector<PixelSpan> spans_;
  std::vector<SampleType> distinct_;
};

} // namespace fvv::media

#endif
