/* VP9. See bitstream.h. */
#include "bitstream.h"

#include "fvv_cxx/error.h"

#include <algorithm>

namespace fvv::media {
namespace {

/* Levels of VP9 by their limits of luma samples a second, luma samples a picture, and the longer side
 * (VP9 bitstream specification, annex A). Their limits of bit rate are left out: a group at constant quality
 * does not know its rate before it is coded, and every group has the same record. */
struct Level {
  uint8_t number;
  uint64_t rate, size;
  uint32_t side;
};
constexpr Level levels[] = {
    {10, 829440, 36864, 512},          {11, 2764800, 73728, 768},        {20, 4608000, 122880, 960},
    {21, 9216000, 245760, 1344},       {30, 20736000, 552960, 2048},     {31, 36864000, 983040, 2752},
    {40, 83558400, 2228224, 4160},     {41, 160432128, 2228224, 4160},   {50, 311951360, 8912896, 8384},
    {51, 588251136, 8912896, 8384},    {52, 1176502272, 8912896, 8384},  {60, 1176502272, 35651584, 16832},
    {61, 2353004544, 35651584, 16832}, {62, 4706009088, 35651584, 16832}};

uint8_t level_of(const VideoSettings &settings) {
  const uint64_t size = uint64_t(settings.width) * settings.height;
  // frame_rate is in seconds a frame.
  const double rate = double(size) * settings.frame_rate.denominator / settings.frame_rate.numerator;
  for (const Level &level : levels)
    if (size <= level.size && std::max(settings.width, settings.height) <= level.side &&
        rate <= double(level.rate))
      return level.number;
  throw Error("no level of VP9 has frames of " + std::to_string(settings.width) + " x " +
              std::to_string(settings.height) + " at this rate");
}

Bytes sample(const uint8_t *packet, size_t size) {
  return Bytes(packet, packet + size);
}

/* Version and flags of the box; profile; bits, 4:2:0, range; colour; no initialisation data. The chroma
 * position in the middle of four pixels has no code: 0, between left neighbours, is the nearest. */
Bytes record(const VideoSettings &settings, const Bytes &, const Bytes &) {
  const Colour colour = colour_of_codec(settings.codec);
  return {1,
          0,
          0,
          0,
          uint8_t(settings.bit_depth > 8 ? 2 : 0),
          level_of(settings),
          uint8_t(settings.bit_depth << 4 | (colour.full_range ? 1 : 0)),
          colour.primaries,
          colour.transfer,
          colour.matrix,
          0,
          0};
}

} // namespace

const Bitstream vp9_bitstream = {sample, record};

} // namespace fvv::media
