/* OpenEXR files as pictures: linear light becomes display values. */
#include "codecs.h"
#include "exr_file.h"
#include "fvv_media/exr.h"
#include "fvv_media/srgb.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fvv::media {
namespace {

template <class Sample> const std::vector<float> &thresholds() {
  static const std::vector<float> table = srgb_thresholds(std::numeric_limits<Sample>::max());
  return table;
}

int picture_channels(const std::vector<std::string> &channels, const std::string &name) {
  if (channels[0] == "Z") throw Error(name, "has the depth channel Z alone, expected R, G and B, or Y");
  return channels[0] == "R" ? 3 : 1;
}

/* Display values of linear light, rows of width * channels, out of samples of which count stand for a pixel.
 */
template <class Sample>
std::vector<Sample> display(const FloatImage &linear, int channels, const std::string &name) {
  const std::vector<float> &table = thresholds<Sample>();
  const size_t count = linear.channels.size(), pixels = size_t(linear.width) * linear.height;
  std::vector<Sample> codes;
  codes.reserve(pixels * size_t(channels));
  for (size_t i = 0; i < pixels; i++)
    for (size_t c = 0; c < size_t(channels); c++) {
      const float value = linear.samples[i * count + c];
      if (!std::isfinite(value))
        throw Error(name, "channel " + linear.channels[c] + " of pixel (" + std::to_string(i % linear.width) +
                              ", " + std::to_string(i / linear.width) + ") is " +
                              (std::isnan(value) ? "not a number" : "infinite"));
      codes.push_back(Sample(std::upper_bound(table.begin(), table.end(), value) - table.begin()));
    }
  return codes;
}

} // namespace

ImageInfo probe_exr(const uint8_t *bytes, size_t size, const std::string &name) {
  const ExrHeader header = read_exr_header(bytes, size, name);
  if (!header.chromaticities.empty())
    throw Error(name, "the OpenEXR file has the chromaticities " + header.chromaticities +
                          ", expected Rec.709: (0.64, 0.33) (0.3, 0.6) (0.15, 0.06) white (0.3127, 0.329)");
  return {header.width, header.height, picture_channels(header.chosen, name), ImageFormat::exr};
}

template <class Sample>
BasicImage<Sample> decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name) {
  const int channels = probe_exr(bytes, size, name).channels;
  const FloatImage linear = decode_exr(bytes, size, name);
  BasicImage<Sample> image;
  image.width = linear.width;
  image.height = linear.height;
  image.channels = channels;
  image.pixels = display<Sample>(linear, channels, name);
  return image;
}

template Image decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name);
template DeepImage decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name);

} // namespace fvv::media
