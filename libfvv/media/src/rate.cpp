/* Searches the quality that keeps a bit rate. See rate.h.
 *
 * The logarithm of a group's bytes falls almost linearly with the quality, so a secant finds the place in a
 * few encodings. The encoders' own two passes are not used: libx265 keeps its statistics in files, libaom's
 * first pass asks for keys inside a group, and none guarantees to stay below its target. */
#include "rate.h"

#include "encoder_options.h"

#include <algorithm>
#include <cmath>

namespace fvv::media {
namespace {

/* A group that takes this part of its budget is good enough; the search aims at the middle. */
constexpr double enough = 0.97, aim = 0.985;
/* After this number of encodings the interval is halved: the curve is not nearly linear. */
constexpr int patience = 6;

uint64_t size_of(const EncodedGroup &group) {
  uint64_t bytes = 0;
  for (const Sample &sample : group.samples) bytes += sample.bytes.size();
  return bytes;
}

/* Qualities counted from the finest, 0, to the coarsest, last. */
struct Steps {
  explicit Steps(const VideoCodec &codec)
      : finest(codec.finest), direction(codec.coarsest < codec.finest ? -1 : 1) {
    if (const VideoEncoder *encoder = find_encoder(codec.code)) per_unit = encoder->steps_per_unit;
    last = direction * (codec.coarsest - codec.finest) * per_unit;
  }
  double quality(int step) const { return finest + direction * double(step) / per_unit; }
  int step(int quality) const { return std::clamp(direction * (quality - finest) * per_unit, 0, last); }

  int finest, direction, per_unit = 1, last;
};

/* Samples of JPEG are independent: takes as many of the finer group's as the budget allows, evenly over the
 * group. */
void refine(EncodedGroup &coarse, EncodedGroup &fine, uint64_t budget) {
  const double room = double(budget - size_of(coarse)) / double(coarse.samples.size());
  double spent = 0;
  for (size_t i = 0; i < coarse.samples.size(); i++) {
    const double more = double(fine.samples[i].bytes.size()) - double(coarse.samples[i].bytes.size());
    if (spent + more > room * double(i + 1)) continue;
    spent += more;
    coarse.samples[i] = std::move(fine.samples[i]);
  }
}

} // namespace

uint64_t rate_budget(const VideoSettings &settings, size_t frames) {
  const fvv_rational &duration = settings.frame_rate;
  return uint64_t(double(settings.bit_rate) / 8 * double(frames) * duration.numerator / duration.denominator);
}

EncodedGroup encode_to_rate(const VideoSettings &settings, size_t frames,
                            const std::function<EncodedGroup(double quality)> &encode_at) {
  const Steps steps(*find_video_codec(settings.codec));
  const uint64_t budget = rate_budget(settings, frames);
  struct Tried {
    int step;
    double log_bytes;
    EncodedGroup group;
  } over = {-1, 0, {}}, kept = {steps.last + 1, 0, {}}; // nothing is tried yet
  // Until two points are known: bytes fall to a hundredth over the scale.
  const double fall = std::log(100.0) / std::max(steps.last, 1);
  int step = steps.step(settings.quality);
  for (int tries = 1; kept.step - over.step > 1; tries++) {
    EncodedGroup group = encode_at(steps.quality(step));
    const uint64_t bytes = size_of(group);
    const double log_bytes = std::log(double(std::max<uint64_t>(bytes, 1)));
    (bytes <= budget ? kept : over) = {step, log_bytes, std::move(group)};
    if (bytes <= budget && double(bytes) >= enough * double(budget)) break;
    const bool both = over.step >= 0 && kept.step <= steps.last && over.log_bytes > kept.log_bytes;
    const double slope = both ? (over.log_bytes - kept.log_bytes) / (kept.step - over.step) : fall;
    const double wanted = std::log(std::max(aim * double(budget), 1.0));
    int next = step + int(std::lround(std::clamp((log_bytes - wanted) / slope, -1000.0, 1000.0)));
    if (both && tries >= patience) next = (over.step + kept.step) / 2;
    step = std::max(over.step + 1, std::min(kept.step - 1, next));
  }
  if (kept.step > steps.last) {
    over.group.over_rate = true;
    return std::move(over.group);
  }
  if (settings.codec == FVV_CODEC_JPEG && over.step >= 0 && over.step + 1 == kept.step)
    refine(kept.group, over.group, budget);
  return std::move(kept.group);
}

} // namespace fvv::media
