#include "fvvmux/frame_limit.h"

#include <algorithm>

namespace fvv::mux {

namespace {

constexpr uint32_t texture_side = 8192; // WebGL 2 in the browsers of today
constexpr uint32_t macroblock = 256;    // pixels

// Of level 5.2. pixels of a frame, and of all frames of a second.
struct Level {
  uint32_t codec;
  const char *name;
  uint32_t width, height;
  uint64_t pixels, per_second;
};
constexpr Level levels[] = {
    // ITU-T H.264 table A-1: MaxFS, MaxMBPS.
    {FVV_CODEC_AVC1, "H.264 level 5.2", texture_side, texture_side, 36864 * macroblock, 2073600 * macroblock},
    // ITU-T H.265 table A.8, A.9: MaxLumaPs, MaxLumaSr.
    {FVV_CODEC_HVC1, "HEVC level 5.2", texture_side, texture_side, 8912896, 1069547520},
    // VP9 bitstream specification, annex A.
    {FVV_CODEC_VP09, "VP9 level 5.2", texture_side, texture_side, 8912896, 1176502272},
    // AV1 bitstream specification, A.3: MaxPicSize, MaxHSize, MaxVSize, MaxDisplayRate.
    {FVV_CODEC_AV01, "AV1 level 5.2", texture_side, 4352, 8912896, 1069547520}};

} // namespace

FrameLimit decoder_limit(const Options &options, const fvv_rational &frame_duration) {
  if (options.frame_limit) return *options.frame_limit;
  for (const Level &level : levels) {
    if (level.codec != options.codec) continue;
    const double rate = double(level.per_second) * frame_duration.numerator / frame_duration.denominator;
    return {level.width, level.height, uint64_t(std::min(double(level.pixels), rate)), level.name};
  }
  return {texture_side, texture_side, uint64_t(texture_side) * texture_side, "textures of browsers"};
}

FrameLimit frame_limit(const Options &options, const fvv_rational &frame_duration) {
  FrameLimit limit = decoder_limit(options, frame_duration);
  if (options.video_pixels) limit.pixels = std::min(limit.pixels, options.video_pixels);
  if (options.video_size) {
    limit.width = std::min<uint32_t>(limit.width, options.video_size->width);
    limit.height = std::min<uint32_t>(limit.height, options.video_size->height);
  }
  return limit;
}

bool fits(uint32_t width, uint32_t height, const FrameLimit &limit) {
  return width <= limit.width && height <= limit.height && uint64_t(width) * height <= limit.pixels;
}

std::string limit_text(const FrameLimit &limit) {
  return std::to_string(limit.width) + "x" + std::to_string(limit.height) + " and " +
         std::to_string(limit.pixels) + " pixels (" + limit.name + ")";
}

} // namespace fvv::mux
