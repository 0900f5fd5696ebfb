/* Half floats in an OpenEXR file, as clause 10.11 of the format has samples. See fvv_media/exr.h. */
#include "codecs.h"
#include "exr_memory.h"
#include "fvv_media/exr.h"
#include "linear.h"

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <half.h>

#include <algorithm>
#include <cstdio>
#include <new>

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
  try {
    exr::Header header(int(image.width), int(image.height));
    header.compression() = dwa_level ? exr::DWAA_COMPRESSION : exr::PIZ_COMPRESSION;
    if (dwa_level) header.dwaCompressionLevel() = float(dwa_level);
    for (const std::string &name : rgb) header.channels().insert(name, exr::Channel(exr::HALF));
    Sink sink;
    {
      exr::OutputFile file(sink, header, 0);
      file.setFrameBuffer(slices<Imath::half>(rgb, samples.data(), image.width, 0, 0));
      file.writePixels(int(image.height));
    } // writes the table of blocks
    return std::move(sink.bytes);
  } catch (const std::bad_alloc &) {
    throw;
  } catch (const std::exception &error) {
    throw Error(std::string("a picture cannot be written as OpenEXR: ") + error.what());
  }
}

} // namespace fvv::media
