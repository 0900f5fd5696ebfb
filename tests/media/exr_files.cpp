#include "exr_files.h"

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTiledOutputFile.h>
#include <half.h>

using namespace OPENEXR_IMF_NAMESPACE;
using IMATH_NAMESPACE::Box2i;
using IMATH_NAMESPACE::V2i;

namespace {

size_t size_of(PixelType type) {
  return type == HALF ? 2 : 4;
}

// Samples of one channel, every step-th of a line.
std::vector<char> samples(const ExrKind &kind, const std::string &channel, int step) {
  std::vector<char> bytes;
  for (uint32_t y = 0; y < exr_height; y++)
    for (uint32_t x = 0; x < exr_width; x += uint32_t(step)) {
      const float value = exr_sample(channel, x, y);
      const half narrow(value);
      const uint32_t whole = uint32_t(value * 1000);
      const char *from = kind.type == HALF    ? reinterpret_cast<const char *>(&narrow)
                         : kind.type == FLOAT ? reinterpret_cast<const char *>(&value)
                                              : reinterpret_cast<const char *>(&whole);
      bytes.insert(bytes.end(), from, from + size_of(kind.type));
    }
  return bytes;
}

Header header_of(const ExrKind &kind) {
  const V2i first(kind.first_x, kind.first_y), last = first + V2i(int(exr_width) - 1, int(exr_height) - 1);
  const V2i margin(kind.overscan, kind.overscan);
  Header header(Box2i(first + margin, last - margin), Box2i(first, last), 1, {0, 0}, 1,
                kind.decreasing ? DECREASING_Y : INCREASING_Y, kind.compression);
  if (kind.red_x > 0) {
    Chromaticities chromaticities;
    chromaticities.red.x = kind.red_x;
    addChromaticities(header, chromaticities);
  }
  if (kind.comment) header.insert("comments", StringAttribute(std::string(kind.comment, 'x')));
  return header;
}

} // namespace

float exr_sample(const std::string &channel, uint32_t x, uint32_t y) {
  return float((x * 5 + y * 3 + 7 * uint32_t(channel[0])) % 257) / 256;
}

std::string write_exr(const std::string &name, const ExrKind &kind) {
  Header header = header_of(kind);
  FrameBuffer buffer;
  std::vector<std::vector<char>> planes;
  for (size_t i = 0; i < kind.channels.size(); i++) {
    const int step = i + 1 == kind.channels.size() ? kind.sampling : 1;
    header.channels().insert(kind.channels[i], Channel(kind.type, step, 1));
    planes.push_back(samples(kind, kind.channels[i], step));
    const size_t size = size_of(kind.type), stride = size * ((exr_width + size_t(step) - 1) / size_t(step));
    // OpenEXR counts from the origin of its pixel space.
    char *const origin = planes.back().data() - kind.first_x / step * int(size) - kind.first_y * int(stride);
    buffer.insert(kind.channels[i], Slice(kind.type, origin, size, stride, step, 1));
  }
  if (kind.tile) {
    header.setTileDescription({unsigned(kind.tile), unsigned(kind.tile), MIPMAP_LEVELS});
    TiledOutputFile file(name.c_str(), header);
    file.setFrameBuffer(buffer);
    // The coarser levels stay what the finest one has in its corner.
    for (int level = 0; level < file.numLevels(); level++)
      file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
  } else {
    OutputFile file(name.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(int(exr_height));
  }
  return name;
}

void write_two_parts(const std::string &name) {
  std::vector<Header> headers;
  for (const char *part : {"left", "right"}) {
    headers.push_back(header_of({}));
    headers.back().setName(part);
    headers.back().setType(SCANLINEIMAGE);
    headers.back().channels().insert("Y", Channel(HALF));
  }
  MultiPartOutputFile file(name.c_str(), headers.data(), 2);
  std::vector<char> plane = samples({}, "Y", 1);
  FrameBuffer buffer;
  buffer.insert("Y", Slice(HALF, plane.data(), 2, 2 * exr_width));
  for (int part = 0; part < 2; part++) {
    OutputPart output(file, part);
    output.setFrameBuffer(buffer);
    output.writePixels(int(exr_height));
  }
}

void write_deep(const std::string &name) {
  Header header = header_of({});
  header.setType(DEEPSCANLINE);
  header.compression() = ZIPS_COMPRESSION;
  header.channels().insert("Z", Channel(FLOAT));
  DeepScanLineOutputFile file(name.c_str(), header);
  std::vector<unsigned> counts(exr_width * exr_height, 1);
  std::vector<float> values(exr_width * exr_height, 2);
  std::vector<float *> pointers;
  for (float &value : values) pointers.push_back(&value);
  DeepFrameBuffer buffer;
  buffer.insertSampleCountSlice(
      Slice(UINT, reinterpret_cast<char *>(counts.data()), sizeof(unsigned), sizeof(unsigned) * exr_width));
  buffer.insert("Z", DeepSlice(FLOAT, reinterpret_cast<char *>(pointers.data()), sizeof(float *),
                               sizeof(float *) * exr_width, sizeof(float)));
  file.setFrameBuffer(buffer);
  file.writePixels(int(exr_height));
}

std::vector<float> read_channel(const std::string &name, const std::string &channel, int width, int height) {
  InputFile file(name.c_str());
  const Box2i window = file.header().dataWindow();
  REQUIRE(window == Box2i(V2i(0, 0), V2i(width - 1, height - 1)));
  REQUIRE(file.header().compression() == ZIP_COMPRESSION);
  std::vector<float> samples(size_t(width) * size_t(height));
  FrameBuffer buffer;
  buffer.insert(channel, Slice(FLOAT, reinterpret_cast<char *>(samples.data()), 4, 4 * size_t(width)));
  file.setFrameBuffer(buffer);
  file.readPixels(0, height - 1);
  return samples;
}
