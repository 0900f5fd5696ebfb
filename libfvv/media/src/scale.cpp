/* Exact area averaging and cropping. On the grid that has source width x destination width cells a row, every
 * source and every destination pixel is a whole number of cells, so weights are integers. Sums of linear
 * light are doubles, added in one order everywhere. */
#include "fvv_media/image.h"

#include "codecs.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace fvv::media {
namespace {

/* Source pixels first ... first + count - 1 weigh weights[offset ...] in one destination pixel; the weights
 * of one destination pixel add up to the source's length. */
struct Span {
  uint32_t first, count;
  size_t offset;
};

struct Axis {
  std::vector<Span> spans;
  std::vector<uint32_t> weights;

  Axis(uint32_t source, uint32_t destination) {
    for (uint32_t i = 0; i < destination; i++) {
      const uint64_t begin = uint64_t(i) * source, end = begin + source;
      const uint32_t first = uint32_t(begin / destination), last = uint32_t((end - 1) / destination);
      spans.push_back({first, last - first + 1, weights.size()});
      for (uint64_t j = first; j <= last; j++)
        weights.push_back(uint32_t(std::min(end, (j + 1) * destination) - std::max(begin, j * destination)));
    }
  }
};

/* Of weighted samples: at most 65535 * 16384 after the first axis, 65535 * 16384 * 16384 after the second. */
template <class Sample> using RowSum = std::conditional_t<std::is_floating_point_v<Sample>, double, uint32_t>;
template <class Sample> using Sum = std::conditional_t<std::is_floating_point_v<Sample>, double, uint64_t>;

template <class Sample> Sample mean(Sum<Sample> sum, uint64_t weights) {
  if constexpr (std::is_floating_point_v<Sample>)
    return Sample(sum / double(weights));
  else
    return Sample((sum + weights / 2) / weights);
}

template <int channels, class Sample>
void scale_row(const Sample *in, const Axis &axis, RowSum<Sample> *out) {
  for (const Span &span : axis.spans) {
    RowSum<Sample> sum[channels] = {};
    for (uint32_t j = 0; j < span.count; j++)
      for (int c = 0; c < channels; c++)
        sum[c] += axis.weights[span.offset + j] * in[size_t(span.first + j) * channels + size_t(c)];
    for (int c = 0; c < channels; c++) *out++ = sum[c];
  }
}

} // namespace

template <class Sample>
BasicImage<Sample> scale(const BasicImage<Sample> &image, uint32_t width, uint32_t height) {
  check_image(image);
  if (image.width == width && image.height == height) return image;
  BasicImage<Sample> out = make_image<Sample>(width, height, image.channels, 0);
  const Axis columns(image.width, width), rows(image.height, height);
  const size_t in_stride = size_t(image.width) * size_t(image.channels);
  const size_t out_stride = size_t(width) * size_t(image.channels);
  std::vector<RowSum<Sample>> row(out_stride);
  std::vector<Sum<Sample>> sums(out_stride);
  const uint64_t total = uint64_t(image.width) * image.height;
  // When rows shrink, neighbours share at most their border row; when they grow, many share the same one.
  uint32_t held = UINT32_MAX;
  for (uint32_t y = 0; y < height; y++) {
    const Span &span = rows.spans[y];
    std::fill(sums.begin(), sums.end(), 0);
    for (uint32_t j = 0; j < span.count; j++) {
      if (held != span.first + j) {
        held = span.first + j;
        const Sample *in = image.pixels.data() + held * in_stride;
        if (image.channels == 1)
          scale_row<1>(in, columns, row.data());
        else
          scale_row<3>(in, columns, row.data());
      }
      const Sum<Sample> weight = rows.weights[span.offset + j];
      for (size_t x = 0; x < out_stride; x++) sums[x] += weight * row[x];
    }
    Sample *to = out.pixels.data() + y * out_stride;
    for (size_t x = 0; x < out_stride; x++) to[x] = mean<Sample>(sums[x], total);
  }
  return out;
}

template <class Sample>
BasicImage<Sample> crop(const BasicImage<Sample> &image, uint32_t x, uint32_t y, uint32_t width,
                        uint32_t height) {
  check_image(image);
  if (width == 0 || height == 0 || uint64_t(x) + width > image.width || uint64_t(y) + height > image.height)
    throw Error("the rectangle " + std::to_string(width) + " x " + std::to_string(height) + " at " +
                std::to_string(x) + ", " + std::to_string(y) + " is not inside a picture of " +
                std::to_string(image.width) + " x " + std::to_string(image.height));
  if (width == image.width && height == image.height) return image;
  BasicImage<Sample> out = make_image<Sample>(width, height, image.channels, 0);
  const size_t channels = size_t(image.channels), stride = width * channels;
  for (uint32_t row = 0; row < height; row++)
    memcpy(&out.pixels[row * stride], &image.pixels[((size_t(y) + row) * image.width + x) * channels],
           stride * sizeof(Sample));
  return out;
}

template Image scale(const Image &, uint32_t, uint32_t);
template DeepImage scale(const DeepImage &, uint32_t, uint32_t);
template LinearImage scale(const LinearImage &, uint32_t, uint32_t);
template Image crop(const Image &, uint32_t, uint32_t, uint32_t, uint32_t);
template DeepImage crop(const DeepImage &, uint32_t, uint32_t, uint32_t, uint32_t);
template LinearImage crop(const LinearImage &, uint32_t, uint32_t, uint32_t, uint32_t);

} // namespace fvv::media
