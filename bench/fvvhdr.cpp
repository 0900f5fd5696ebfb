// What the compressions of OpenEXR cost on half-float pictures: bytes, time to encode and to decode.
// docs/encoding/hdr.md has its table. Writes files in memory with OpenEXR itself, since the library writes
// only the one that was chosen by this; decodes with the library's decoder of video.
#include "fvv_media/exr.h"
#include "fvv_media/video.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfStdIO.h>
#include <half.h>

#include <chrono>
#include <cstdio>
#include <exception>

namespace {

namespace exr = OPENEXR_IMF_NAMESPACE;
using namespace fvv;

struct Way {
  const char *name;
  exr::Compression compression;
};
constexpr Way ways[] = {{"none", exr::NO_COMPRESSION},
                        {"ZIPS", exr::ZIPS_COMPRESSION},
                        {"ZIP", exr::ZIP_COMPRESSION},
                        {"PIZ", exr::PIZ_COMPRESSION}};

std::vector<uint8_t> encode(const media::LinearImage &image, const Way &way) {
  std::vector<Imath::half> samples(image.pixels.begin(), image.pixels.end());
  exr::Header header(int(image.width), int(image.height));
  header.compression() = way.compression;
  exr::FrameBuffer buffer;
  const size_t pixel = 3 * sizeof(Imath::half);
  for (int c = 0; c < 3; c++) {
    const std::string name(1, "RGB"[c]);
    header.channels().insert(name, exr::Channel(exr::HALF));
    buffer.insert(name, exr::Slice(exr::HALF, reinterpret_cast<char *>(&samples[size_t(c)]), pixel,
                                   pixel * image.width));
  }
  exr::StdOSStream stream;
  {
    exr::OutputFile file(stream, header, 0);
    file.setFrameBuffer(buffer);
    file.writePixels(int(image.height));
  }
  const std::string text = stream.str();
  return {text.begin(), text.end()};
}

double seconds_of(const std::chrono::steady_clock::time_point &start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void measure(const std::vector<media::LinearImage> &images, const Way &way) {
  double encoding = 0, decoding = 0, pixels = 0, bytes = 0;
  for (const media::LinearImage &image : images) {
    auto start = std::chrono::steady_clock::now();
    const std::vector<uint8_t> file = encode(image, way);
    encoding += seconds_of(start);
    media::VideoSettings settings = {FVV_CODEC_OEXR, image.width, image.height, 0, {1, 25}, 16};
    media::Decoder decoder(media::config_of(settings, {}));
    start = std::chrono::steady_clock::now();
    decoder.decode<float>(file.data(), file.size());
    decoding += seconds_of(start);
    pixels += double(image.width) * image.height;
    bytes += double(file.size());
  }
  std::printf("| %s | %.1f | %.2f | %.0f | %.0f |\n", way.name, bytes / double(images.size()) / 1000,
              8 * bytes / pixels, pixels / encoding / 1e6, pixels / decoding / 1e6);
}

} // namespace

int main(int argc, char **argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: fvvhdr PICTURE.exr...\n");
    return 2;
  }
  try {
    std::vector<media::LinearImage> images;
    for (int i = 1; i < argc; i++) images.push_back(media::read_image<float>(argv[i], 3));
    std::printf("| compression | kB a picture | bits a pixel | encode Mpixel/s | decode Mpixel/s |\n"
                "|---|---|---|---|---|\n");
    for (const Way &way : ways) measure(images, way);
  } catch (const std::exception &failure) {
    std::fprintf(stderr, "fvvhdr: %s\n", failure.what());
    return 1;
  }
}
