/* The cheapest quality that reaches a PSNR. See choose_quality in fvv_media/video.h. */
#include "fvv_media/video.h"

#include "codecs.h"
#include "encoder_options.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

namespace fvv::media {
namespace {

constexpr double decibels = 45;     // of a picture over a codec's scale
constexpr double at_a_third = 39.5; // dB, what a third of the scale reaches
// dB by which a draft is worse than the same quality without draft, about; measured with H.264. With the
// effort live there are no drafts: it is one.
double draft_loss(Effort effort) {
  return effort == Effort::full ? 0.35 : 0.2;
}
// dB by which the next cheaper quality has to miss the target, by the smallest fall of the drafts, to be
// skipped. With pictures of cameras the fall of drafts was that of final encodings within 0.01 dB a step.
constexpr double sure = 0.1;
// dB below the best quality, of pictures that no quality brings to the target. What is lost there is lost
// before encoding (chroma at half the resolution): the last steps multiply the bytes and gain nothing.
constexpr double below_best = 0.1;

// PSNR falls almost linearly with the step: interpolating needs half the encodings of bisection, and none at
// the best quality, which is the slowest to encode. Steps count from the best quality to the cheapest.
class Search {
public:
  // guess: of the fall, dB a step, until there are two tries.
  Search(int count, double wanted, int first, double guess)
      : steps(count), target(wanted), bad{count, 0}, fall(guess), next(std::clamp(first, 0, count - 1)) {}

  bool done() const { return bad.step - good.step <= 1; }
  int step() const { return next; } // to be tried now

  // The line through the last two tries ends beside the last one: its error there is a small part of a step.
  bool is_sure() const {
    return before.step >= 0 && std::isfinite(last.db) && std::isfinite(before.db) && before.db != last.db &&
           std::abs(ahead() - last.step) <= 1;
  }

  // The best step so far.
  int ahead() const {
    const double steps_ahead = std::clamp((last.db - target) / fall, -1000.0, 1000.0);
    return last.step + int(std::floor(steps_ahead));
  }

  // Adds the result of a try. Returns whether it is good.
  bool take(double db) {
    const Tried now = {next, db};
    (db >= target ? good : bad) = now;
    // Between a good and a bad step, once both are known, else as far as from the last try to this one.
    // Lossless is not on the line.
    const bool both = good.step >= 0 && bad.step < steps;
    const Tried from = both ? good : last, to = both ? bad : now;
    const double found = (from.db - to.db) / (to.step - from.step);
    if (from.step >= 0 && std::isfinite(found) && found > 0) fall = found;
    before = std::exchange(last, now);
    next = std::clamp(ahead(), good.step + 1, std::max(good.step + 1, bad.step - 1));
    return db >= target;
  }

  // -1: nothing is good.
  int best() const { return good.step; }
  double worst_db() const { return bad.db; }
  double best_db() const { return good.db; }
  double fall_of_step() const { return fall; } // dB

private:
  // good reaches the target, bad does not; -1 and steps: not tried.
  struct Tried {
    int step;
    double db;
  };
  const int steps;
  const double target;
  Tried good = {-1, 0}, bad, last = {-1, 0}, before = {-1, 0};
  double fall;
  int next;
};

bool has_drafts(uint32_t codec) {
  const VideoEncoder *encoder = find_encoder(codec);
  return encoder && !encoder->draft.empty();
}

size_t bytes_of(const MeasuredGroup &measured) {
  size_t sum = 0;
  for (const Sample &sample : measured.group.samples) sum += sample.bytes.size();
  return sum;
}

// Spends what a whole step of the quality leaves above the target. tried: that step; fall: dB a step, about.
// Two tries find the part, or the one before it; less effort has one.
template <class SampleType>
void use_parts(VideoSettings tried, const GroupSource<SampleType> &frames, double target_db, double fall,
               MeasuredGroup &chosen) {
  const int parts = parts_of_quality(tried.codec);
  int left = tried.effort == Effort::full ? 2 : 1, good = 0, bad = parts;
  double from = chosen.psnr;
  while (left-- && std::isfinite(from) && bad - good > 1) {
    const int ahead = good + int(std::floor((from - target_db) / fall * parts));
    const int part = std::clamp(ahead, good, bad - 1);
    if (part == good) return;
    tried.parts = double(part) / parts;
    MeasuredGroup group = encode_measured(tried, frames);
    fall = (from - group.psnr) / (part - good) * parts;
    if (group.psnr < target_db || bytes_of(group) >= bytes_of(chosen)) {
      bad = part;
      continue;
    }
    good = part;
    from = group.psnr;
    chosen = std::move(group);
    if (!(fall > 0)) return;
  }
}

} // namespace

template <class SampleType>
MeasuredGroup encode_measured(const VideoSettings &settings, const GroupSource<SampleType> &frames) {
  MeasuredGroup out;
  LumaError sum;
  size_t first = 0;
  for (const size_t count : frames.groups.empty() ? std::vector<size_t>{frames.count} : frames.groups) {
    const GroupSource<SampleType> part(
        count, [&](size_t i) { return frames.load(first + i); }, frames.reserve);
    EncodedGroup group = encode_group(settings, part);
    Decoder decoder(config_of(settings, group));
    for (size_t i = 0; i < count; i++) {
      const std::vector<uint8_t> &bytes = group.samples[i].bytes;
      const GroupFrame<SampleType> frame = part.load(i);
      const LumaError one =
          luma_error(*frame.image, decoder.decode<SampleType>(bytes.data(), bytes.size()), frame.mask.get());
      sum.squares += one.squares;
      sum.pixels += one.pixels;
    }
    if (first)
      std::move(group.samples.begin(), group.samples.end(), std::back_inserter(out.group.samples));
    else
      out.group = std::move(group);
    first += count;
  }
  out.psnr = sum.psnr();
  return out;
}

template <class SampleType>
MeasuredGroup choose_quality(const VideoSettings &settings, const GroupSource<SampleType> &frames,
                             double target_db, bool in_parts) {
  const VideoCodec *codec = find_video_codec(settings.codec);
  if (!codec) refuse_codec(settings.codec);
  const int direction = codec->coarsest < codec->finest ? -1 : 1;
  const int steps = direction * (codec->coarsest - codec->finest) + 1;
  const auto quality_of = [&](int step) { return codec->finest + direction * step; };
  VideoSettings tried = settings;
  tried.parts = 0;
  int first = int(std::lround(steps / 3.0 + (at_a_third - target_db) * steps / decibels));
  double fall = decibels / steps; // dB a step
  int drafted = -1;               // the best step of drafts
  if (has_drafts(settings.codec) && settings.effort >= Effort::fast) {
    tried.draft = true;
    Search search(steps, target_db - draft_loss(settings.effort), first, fall);
    std::map<int, double> db; // of the steps that were tried
    while (!search.done() && !search.is_sure()) {
      const int step = search.step();
      tried.quality = quality_of(step);
      search.take(db[step] = encode_measured(tried, frames).psnr);
    }
    first = drafted = search.done() ? search.best() : search.ahead();
    // The least between neighbours: with noise in a small picture falls are uneven.
    fall = INFINITY;
    for (auto to = std::next(db.begin()); to != db.end(); ++to) {
      const auto from = std::prev(to);
      fall = std::min(fall, (from->second - to->second) / (to->first - from->first));
    }
    tried.draft = false;
  }
  Search search(steps, target_db, first, decibels / steps);
  MeasuredGroup chosen; // at the best step
  const auto settled = [&] {
    return drafted >= 0 && search.best() == drafted && search.best_db() - fall < target_db - sure;
  };
  while (!search.done() && !settled()) {
    tried.quality = quality_of(search.step());
    MeasuredGroup group = encode_measured(tried, frames);
    if (search.take(group.psnr)) chosen = std::move(group);
  }
  // The best one was tried, and its PSNR is a target that is reached.
  if (search.best() < 0) return choose_quality(settings, frames, search.worst_db() - below_best, in_parts);
  if (in_parts && parts_of_quality(settings.codec) > 1) {
    tried.quality = quality_of(search.best());
    use_parts(tried, frames, target_db, search.fall_of_step(), chosen);
  }
  return chosen;
}

#define FVV_INSTANTIATE(Sample)                                                                              \
  template MeasuredGroup encode_measured(const VideoSettings &, const GroupSource<Sample> &);                \
  template MeasuredGroup choose_quality(const VideoSettings &, const GroupSource<Sample> &, double, bool);
FVV_INSTANTIATE(uint8_t)
FVV_INSTANTIATE(uint16_t)
FVV_INSTANTIATE(float)
#undef FVV_INSTANTIATE

} // namespace fvv::media
