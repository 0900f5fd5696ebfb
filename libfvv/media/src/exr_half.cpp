/* Half floats in an OpenEXR file, as clause 10.12 of the format has samples. See fvv_media/exr.h. */
#include "codecs.h"
#include "exr_memory.h"
#include "fvv_media/exr.h"
#include "linear.h"

#include <half.h>

#include <algorithm>
#include <cstdio>

namespace fvv::media {
namespace {

const std::vector<std::string> rgb = {"R", "G", "B"};

} // namespace

void check_halves(const LinearImage &image, const std::string &name) {
  check_image(image);
  check_finite(image, name);
  const auto found = std::find_if(image.pixels.begin(), image.pixels.end(),
                                  [](float value) { return !Imath::half(value).isFinite(); });
  if (found == image.pixels.end()) return;
  const size_t index = size_t(found - image.pixels.begin()), channels = size_t(image.channels);
  const size_t pixel = index / channels;
  char value[40];
  snprintf(value, sizeof value, "%g", double(*found));
  throw Error(name, "channel " + (channels == 1 ? "Y" : rgb[index % channels]) + " of pixel (" +
                        std::to_string(pixel % image.width) + ", " + std::to_string(pixel / image.width) +
                        ") is " + value + ", expected -65504 to 65504, which half floats hold");
}

std::vector<uint8_t> encode_half_exr(const LinearImage &image, int dwa_level) {
  if (dwa_level < 0 || dwa_level > max_dwa_level)
    throw Error("the DWA level is " + std::to_string(dwa_level) + ", expected 0 (lossless) to " +
                std::to_string(max_dwa_level));
  check_halves(image, "a picture");
  if (image.channels != 3) throw Error("a grey picture came where an RGB picture was expected");
  std::vector<Imath::half> samples(image.pixels.begin(), image.pixels.end());
  return write_exr(rgb, samples.data(), image.width, image.height,
                   dwa_level ? exr::DWAA_COMPRESSION : exr::PIZ_COMPRESSION, dwa_level);
}

} // namespace fvv::media
