/* See linear.h. */
#include "linear.h"

#include "fvv_media/srgb.h"

#include <half.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace fvv::media {
namespace {

template <class Sample> const std::vector<float> &thresholds() {
  static const std::vector<float> table = srgb_thresholds(std::numeric_limits<Sample>::max());
  return table;
}

/* A picture of the same shape, each sample made of one. */
template <class To, class From, class Convert>
BasicImage<To> converted(const BasicImage<From> &image, const Convert &convert) {
  BasicImage<To> out = make_image<To>(image.width, image.height, image.channels, 0);
  std::transform(image.pixels.begin(), image.pixels.end(), out.pixels.begin(), convert);
  return out;
}

} // namespace

LinearImage linear_of(const DeepImage &image) {
  static const std::vector<float> table = linear_of_codes(65535);
  return converted<float>(image, [](uint16_t code) { return table[code]; });
}

template <class Sample> BasicImage<Sample> display_of(const LinearImage &image) {
  const std::vector<float> &table = thresholds<Sample>();
  return converted<Sample>(image, [&](float value) {
    return Sample(std::upper_bound(table.begin(), table.end(), value) - table.begin());
  });
}

template Image display_of(const LinearImage &image);
template DeepImage display_of(const LinearImage &image);

float srgb_of_half(float linear) {
  static const std::vector<float> table = [] {
    std::vector<float> values;
    for (uint32_t bits = 0; bits < 65536; bits++) {
      Imath::half value;
      value.setBits(uint16_t(bits));
      values.push_back(float(srgb_of_linear(double(float(value)))));
    }
    return values;
  }();
  return table[Imath::half(linear).bits()];
}

void check_finite(const LinearImage &image, const std::string &name) {
  const auto found = std::find_if_not(image.pixels.begin(), image.pixels.end(),
                                      [](float value) { return std::isfinite(value); });
  if (found == image.pixels.end()) return;
  const size_t index = size_t(found - image.pixels.begin()), channels = size_t(image.channels);
  const size_t pixel = index / channels;
  throw Error(name, std::string("channel ") + (channels == 1 ? 'Y' : "RGB"[index % channels]) +
                        " of pixel (" + std::to_string(pixel % image.width) + ", " +
                        std::to_string(pixel / image.width) + ") is " +
                        (std::isnan(*found) ? "not a number" : "infinite"));
}

} // namespace fvv::media
