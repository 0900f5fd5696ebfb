/* OpenEXR files as pictures, of linear light or of display values. */
#include "codecs.h"
#include "exr_file.h"
#include "fvv_media/exr.h"
#include "linear.h"

#include <type_traits>

namespace fvv::media {
namespace {

int picture_channels(const std::vector<std::string> &channels, const std::string &name) {
  if (channels[0] == "Z") throw Error(name, "has the depth channel Z alone, expected R, G and B, or Y");
  return channels[0] == "R" ? 3 : 1;
}

/* The first channels, without A. */
LinearImage picture_of(FloatImage &&file, int channels) {
  LinearImage image;
  image.width = file.width;
  image.height = file.height;
  image.channels = channels;
  const size_t count = file.channels.size(), pixels = size_t(file.width) * file.height;
  if (count == size_t(channels)) {
    image.pixels = std::move(file.samples);
    return image;
  }
  image.pixels.reserve(pixels * size_t(channels));
  for (size_t i = 0; i < pixels; i++)
    for (size_t c = 0; c < size_t(channels); c++) image.pixels.push_back(file.samples[i * count + c]);
  return image;
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
  LinearImage image = picture_of(decode_exr(bytes, size, name), channels);
  check_finite(image, name);
  if constexpr (std::is_same_v<Sample, float>)
    return image;
  else
    return display_of<Sample>(image);
}

template Image decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name);
template DeepImage decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name);
template LinearImage decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name);

} // namespace fvv::media
