/* The cheapest quality that reaches a PSNR. See choose_quality in fvv_media/video.h. */
#include "fvv_media/video.h"

#include "codecs.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace fvv::media {
namespace {

constexpr double decibels = 45;     // of a picture over a codec's scale
constexpr double at_a_third = 39.5; // dB, what a third of the scale reaches

} // namespace

template <class SampleType>
MeasuredGroup encode_measured(const VideoSettings &settings,
                              const std::vector<BasicImage<SampleType>> &frames,
                              const std::vector<Image> &masks) {
  if (!masks.empty() && masks.size() != frames.size())
    throw Error(std::to_string(masks.size()) + " masks came with " + std::to_string(frames.size()) +
                " frames");
  MeasuredGroup out = {encode_group(settings, frames), 0};
  Decoder decoder(config_of(settings, out.group));
  LumaError sum;
  for (size_t i = 0; i < frames.size(); i++) {
    const std::vector<uint8_t> &bytes = out.group.samples[i].bytes;
    const LumaError one = luma_error(frames[i], decoder.decode<SampleType>(bytes.data(), bytes.size()),
                                     masks.empty() ? nullptr : &masks[i]);
    sum.squares += one.squares;
    sum.pixels += one.pixels;
  }
  out.psnr = sum.psnr();
  return out;
}

template <class SampleType>
MeasuredGroup choose_quality(const VideoSettings &settings, const std::vector<BasicImage<SampleType>> &frames,
                             double target_db, const std::vector<Image> &masks) {
  // Steps count from the best quality to the cheapest.
  const VideoCodec *codec = find_video_codec(settings.codec);
  if (!codec) refuse_codec(settings.codec);
  const int direction = codec->coarsest < codec->finest ? -1 : 1;
  const int steps = direction * (codec->coarsest - codec->finest) + 1;
  const auto quality_of = [&](int step) { return codec->finest + direction * step; };
  VideoSettings tried = settings;
  // PSNR falls almost linearly with the step: interpolating needs half the encodings of bisection, and none
  // at the best quality, which is the slowest to encode. good reaches the target, bad does not; -1 and steps:
  // not tried.
  struct Tried {
    int step;
    double db;
  } good = {-1, 0}, bad = {steps, 0}, last = {-1, 0};
  MeasuredGroup chosen;            // at good
  double slope = decibels / steps; // dB a step, until two points are known
  int step = std::clamp(int(std::lround(steps / 3.0 + (at_a_third - target_db) / slope)), 0, steps - 1);
  while (bad.step - good.step > 1) {
    tried.quality = quality_of(step);
    MeasuredGroup group = encode_measured(tried, frames, masks);
    const Tried now = {step, group.psnr};
    // Between what is good and what is bad, once both are known, else as from the last try to this one.
    // Lossless is no point of a line.
    (now.db >= target_db ? good : bad) = now;
    const bool both = good.step >= 0 && bad.step < steps;
    const Tried from = both ? good : last, to = both ? bad : now;
    const double fall = (from.db - to.db) / (to.step - from.step);
    if (from.step >= 0 && std::isfinite(fall) && fall > 0) slope = fall;
    const double ahead = std::clamp((now.db - target_db) / slope, -1000.0, 1000.0);
    step = std::clamp(step + int(std::floor(ahead)), good.step + 1, std::max(good.step + 1, bad.step - 1));
    if (now.db >= target_db) chosen = std::move(group);
    last = now;
  }
  if (good.step < 0) {
    char text[160];
    snprintf(text, sizeof text, "no quality reaches %.2f dB: the best, %d, reaches %.2f dB", target_db,
             quality_of(0), bad.db);
    throw Error(text);
  }
  return chosen;
}

#define FVV_INSTANTIATE(Sample)                                                                              \
  template MeasuredGroup encode_measured(const VideoSettings &, const std::vector<BasicImage<Sample>> &,     \
                                         const std::vector<Image> &);                                        \
  template MeasuredGroup choose_quality(const VideoSettings &, const std::vector<BasicImage<Sample>> &,      \
                                        double, const std::vector<Image> &);
FVV_INSTANTIATE(uint8_t)
FVV_INSTANTIATE(uint16_t)
FVV_INSTANTIATE(float)
#undef FVV_INSTANTIATE

} // namespace fvv::media
