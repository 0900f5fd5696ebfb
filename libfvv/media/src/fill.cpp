/* The smooth background of a frame: pull and push. See fvv_media/frame.h. */
#include "fvv_media/frame.h"

#include "codecs.h"

#include <algorithm>

namespace fvv::media {
namespace {

/* Integers carry a few bits behind the point, so that levels do not add up their rounding. */
template <class Sample> struct Arithmetic {
  using Value = int32_t;
  static Value of(Sample sample) { return Value(sample) * 64; }
  static Value divided(Value value, int32_t by) { return (value + by / 2) / by; }
  static Sample sample(Value value) { return Sample(divided(value, 64)); }
};
template <> struct Arithmetic<float> {
  using Value = float;
  static Value of(float sample) { return sample; }
  static Value divided(Value value, int32_t by) { return value / float(by); }
  static float sample(Value value) { return value; }
};

template <class Sample> struct Level {
  size_t width, height;
  std::vector<typename Arithmetic<Sample>::Value> values; /* channels interleaved */
  std::vector<uint8_t> known;
};

template <class Sample> Level<Sample> halved(const Level<Sample> &fine, size_t channels) {
  Level<Sample> out = {(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
  out.values.resize(out.width * out.height * channels);
  out.known.resize(out.width * out.height);
  for (size_t y = 0; y < out.height; y++)
    for (size_t x = 0; x < out.width; x++) {
      int32_t count = 0;
      auto *to = &out.values[(y * out.width + x) * channels];
      for (size_t row = 2 * y; row < std::min(2 * y + 2, fine.height); row++)
        for (size_t column = 2 * x; column < std::min(2 * x + 2, fine.width); column++) {
          const size_t i = row * fine.width + column;
          if (!fine.known[i]) continue;
          count++;
          for (size_t c = 0; c < channels; c++) to[c] += fine.values[i * channels + c];
        }
      if (!count) continue;
      out.known[y * out.width + x] = 1;
      for (size_t c = 0; c < channels; c++) to[c] = Arithmetic<Sample>::divided(to[c], count);
    }
  return out;
}

/* Pixel centres of the fine level lie a quarter from those of the coarse one: weights 3 and 1 on each axis.
 */
template <class Sample> void interpolate(Level<Sample> &fine, const Level<Sample> &coarse, size_t channels) {
  for (size_t y = 0; y < fine.height; y++) {
    const size_t near_y = y / 2,
                 far_y = y % 2 ? std::min(near_y + 1, coarse.height - 1) : near_y - (near_y > 0);
    for (size_t x = 0; x < fine.width; x++) {
      if (fine.known[y * fine.width + x]) continue;
      const size_t near_x = x / 2,
                   far_x = x % 2 ? std::min(near_x + 1, coarse.width - 1) : near_x - (near_x > 0);
      const auto at = [&](size_t row, size_t column, size_t c) {
        return coarse.values[(row * coarse.width + column) * channels + c];
      };
      for (size_t c = 0; c < channels; c++)
        fine.values[(y * fine.width + x) * channels + c] =
            Arithmetic<Sample>::divided(9 * at(near_y, near_x, c) + 3 * at(near_y, far_x, c) +
                                            3 * at(far_y, near_x, c) + at(far_y, far_x, c),
                                        16);
    }
  }
}

} // namespace

template <class Sample> void fill_smoothly(BasicImage<Sample> &image, const Image &keep) {
  check_image(image);
  check_image(keep);
  if (keep.channels != 1 || keep.width != image.width || keep.height != image.height)
    throw Error("a mask must be grey and of the size of the picture");
  const size_t channels = size_t(image.channels);
  std::vector<Level<Sample>> levels = {{image.width, image.height, {}, {}}};
  levels[0].values.resize(image.pixels.size());
  levels[0].known.resize(keep.pixels.size());
  bool any = false;
  for (size_t i = 0; i < keep.pixels.size(); i++) {
    if (keep.pixels[i] <= 127) continue;
    levels[0].known[i] = 1;
    any = true;
    for (size_t c = 0; c < channels; c++)
      levels[0].values[i * channels + c] = Arithmetic<Sample>::of(image.pixels[i * channels + c]);
  }
  if (!any) {
    std::fill(image.pixels.begin(), image.pixels.end(), flat_grey_of<Sample>);
    return;
  }
  while (levels.back().width > 1 || levels.back().height > 1)
    levels.push_back(halved(levels.back(), channels));
  for (size_t i = levels.size() - 1; i-- > 0;) interpolate(levels[i], levels[i + 1], channels);
  for (size_t i = 0; i < keep.pixels.size(); i++)
    if (!levels[0].known[i])
      for (size_t c = 0; c < channels; c++)
        image.pixels[i * channels + c] = Arithmetic<Sample>::sample(levels[0].values[i * channels + c]);
}

template void fill_smoothly(Image &, const Image &);
template void fill_smoothly(DeepImage &, const Image &);
template void fill_smoothly(LinearImage &, const Image &);

} // namespace fvv::media
