/* The cheapest quality that reaches a PSNR. See choose_quality in fvv_media/video.h. */
#include "fvv_media/video.h"

#include <cstdio>

namespace fvv::media {
namespace {

double reached(const VideoSettings &settings, const std::vector<Image> &frames,
               const std::vector<Image> &masks) {
  const EncodedGroup group = encode_group(settings, frames);
  Decoder decoder(config_of(settings, group));
  LumaError sum;
  for (size_t i = 0; i < frames.size(); i++) {
    const std::vector<uint8_t> &bytes = group.samples[i].bytes;
    const LumaError one = luma_error(frames[i], decoder.decode(bytes.data(), bytes.size()),
                                     masks.empty() ? nullptr : &masks[i]);
    sum.squares += one.squares;
    sum.pixels += one.pixels;
  }
  return sum.psnr();
}

} // namespace

int choose_quality(const VideoSettings &settings, const std::vector<Image> &frames, double target_db,
                   const std::vector<Image> &masks) {
  if (!masks.empty() && masks.size() != frames.size())
    throw Error(std::to_string(masks.size()) + " masks came with " + std::to_string(frames.size()) +
                " frames");
  // Steps count from the best quality to the cheapest.
  const bool jpeg = settings.codec == FVV_CODEC_JPEG;
  const int steps = jpeg ? 100 : 51;
  const auto quality_of = [&](int step) { return jpeg ? 100 - step : 1 + step; };
  VideoSettings tried = settings;
  const auto psnr_at = [&](int step) {
    tried.quality = quality_of(step);
    return reached(tried, frames, masks);
  };
  const double best = psnr_at(0);
  if (!(best >= target_db)) {
    char text[160];
    snprintf(text, sizeof text, "no quality reaches %.2f dB: the best, %d, reaches %.2f dB", target_db,
             quality_of(0), best);
    throw Error(text);
  }
  // good reaches the target, bad does not (or is beyond the scale).
  int good = 0, bad = steps;
  while (bad - good > 1) {
    const int middle = (good + bad) / 2;
    (psnr_at(middle) >= target_db ? good : bad) = middle;
  }
  return quality_of(good);
}

} // namespace fvv::media
