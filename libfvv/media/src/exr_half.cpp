/* Half floats in an OpenEXR file, as clause 10.11 of the format has samples. See fvv_media/exr.h. */
#include "codecs.h"
#include "exr_memory.h"
#include "fvv_media/exr.h"
#include "linear.h"

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <half.h>

#include <new>

namespace fvv::media {
namespace {

const std::vector<std::string> rgb = {"R", "G", "B"};

std::vector<Imath::half> rounded(const LinearImage &image) {
  check_image(image);
  if (image.channels != 3) throw Error("a grey picture came where an RGB picture was expected");
  check_finite(image, "a picture");
  std::vector<Imath::half> out(image.pixels.begin(), image.pixels.end());
  for (size_t i = 0; i < out.size(); i++)
    if (!out[i].isFinite())
      throw Error("channel " + rgb[i % 3] + " of pixel (" + std::to_string(i / 3 % image.width) + ", " +
                  std::to_string(i / 3 / image.width) + ") is " + std::to_string(image.pixels[i]) +
                  ", expected -65504 to 65504, which half floats hold");
  return out;
}

} // namespace

std::vector<uint8_t> encode_half_exr(const LinearImage &image, int dwa_level) {
  if (dwa_level < 0 || dwa_level > max_dwa_level)
    throw Error("the DWA level is " + std::to_string(dwa_level) + ", expected 0 (lossless) to " +
                std::to_string(max_dwa_level));
  std::vector<Imath::half> samples = rounded(image);
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
