#include "scene/src/video/video_match.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace fvv::scene {

namespace {

// Times are fractions of 32-bit numbers, frames at most 2^24, ticks 32-bit: all products below stay under
// 2^121.
__extension__ typedef __int128 wide;

struct Fraction {
  wide numerator, denominator; // > 0
};

wide floor_of(const Fraction &f) {
  const wide quotient = f.numerator / f.denominator;
  return quotient - (f.numerator % f.denominator < 0);
}
wide ceiling_of(const Fraction &f) {
  return -floor_of({-f.numerator, f.denominator});
}

// start + (index + halves / 2) * duration in ticks, times scale.
Fraction ticks_at(const Seconds &start, const fvv_rational &duration, const fvv_rational &tick, int64_t index,
                  int halves, int scale) {
  const wide half_durations = wide(2) * index + halves;
  const wide numerator = wide(2) * start.numerator * duration.denominator +
                         half_durations * duration.numerator * start.denominator;
  const wide denominator = wide(2) * start.denominator * duration.denominator;
  const int64_t divisor = std::gcd(int64_t(2), int64_t(scale));
  return {numerator * tick.denominator * (scale / divisor), denominator / divisor * tick.numerator};
}

// The product where its numbers fit into 32 bits in lowest terms, else the last convergent of its continued
// fraction that does. A duration at an end of its range is left as it is.
fvv_rational product(const fvv_rational &a, const fvv_rational &b) {
  uint64_t n = uint64_t(a.numerator) * b.numerator, d = uint64_t(a.denominator) * b.denominator;
  wide before[2] = {0, 1}, found[2] = {1, 0};
  while (d) {
    const uint64_t whole = n / d;
    const wide next[2] = {whole * found[0] + before[0], whole * found[1] + before[1]};
    if (next[0] > UINT32_MAX || next[1] > UINT32_MAX) break;
    for (size_t k = 0; k < 2; k++) before[k] = std::exchange(found[k], next[k]);
    n = std::exchange(d, n % d);
  }
  return found[0] && found[1] ? fvv_rational{uint32_t(found[0]), uint32_t(found[1])} : a;
}

} // namespace

FrameClock::FrameClock(const Capture &capture, const VideoSource &video)
    : start(video.start), duration(product(capture.frame_duration, video.clock)), first(video.first),
      step(capture.frames.step) {}

size_t FrameClock::nearest(const PictureTimes &pictures, int64_t frame) const {
  const std::vector<int64_t> &times = pictures.times;
  // Twice the time: halfway between two pictures is then a whole number of ticks.
  const wide doubled = ceiling_of(ticks_at(start, duration, pictures.tick, (frame - first) / step, 0, 2));
  const auto later = std::partition_point(times.begin(), times.end(),
                                          [&](int64_t time) { return wide(2) * time < doubled; });
  if (later == times.begin()) return 0;
  const size_t index = size_t(later - times.begin());
  if (later == times.end()) return index - 1;
  return wide(times[index - 1]) + times[index] >= doubled ? index - 1 : index;
}

bool FrameClock::meets(const PictureTimes &pictures, size_t picture, int64_t frame) const {
  const int64_t index = (frame - first) / step;
  const wide time = pictures.times[picture];
  return time >= ceiling_of(ticks_at(start, duration, pictures.tick, index, -1, 1)) &&
         time <= floor_of(ticks_at(start, duration, pictures.tick, index, 1, 1));
}

double FrameClock::offset(const PictureTimes &pictures, size_t picture, int64_t frame) const {
  // The whole ticks first: only their small remainder is rounded.
  const Fraction at = ticks_at(start, duration, pictures.tick, (frame - first) / step, 0, 1);
  const wide whole = floor_of(at);
  const double rest = double(at.numerator - whole * at.denominator) / double(at.denominator);
  return (double(pictures.times[picture] - whole) - rest) * pictures.tick.numerator /
         pictures.tick.denominator;
}

std::optional<Seconds> FrameClock::start_for(const PictureTimes &pictures, size_t picture,
                                             int64_t frame) const {
  const int64_t index = (frame - first) / step;
  wide numerator = wide(pictures.times[picture]) * pictures.tick.numerator * duration.denominator -
                   wide(index) * duration.numerator * pictures.tick.denominator;
  wide denominator = wide(pictures.tick.denominator) * duration.denominator;
  for (const bool exact : {true, false}) {
    if (!exact) {
      constexpr int64_t micro = 1'000'000;
      const wide whole = floor_of({numerator, denominator});
      numerator = whole * micro + (numerator - whole * denominator) * micro / denominator;
      denominator = micro;
    }
    wide divisor = numerator < 0 ? -numerator : numerator, rest = denominator;
    while (rest) divisor = std::exchange(rest, divisor % rest);
    const wide n = numerator / divisor, d = denominator / divisor;
    if (n <= UINT32_MAX && -n <= UINT32_MAX && d <= UINT32_MAX) return Seconds{int64_t(n), uint32_t(d)};
  }
  return {};
}

namespace {

void describe_rate(const PictureTimes &pictures, VideoReport &report) {
  const std::vector<int64_t> &times = pictures.times;
  if (times.size() < 2) return;
  report.rate =
      double(times.size() - 1) * pictures.tick.denominator / (double(times.back()) * pictures.tick.numerator);
  int64_t shortest = INT64_MAX, longest = 0;
  for (size_t i = 1; i < times.size(); i++) {
    shortest = std::min(shortest, times[i] - times[i - 1]);
    longest = std::max(longest, times[i] - times[i - 1]);
  }
  report.constant_rate = longest - shortest <= 1; // rounded to ticks
}

} // namespace

VideoReport match_video(const Capture &capture, const VideoSource &video, const PictureTimes &pictures,
                        const Camera *camera) {
  VideoReport report;
  report.file = video.file;
  report.pictures = pictures.times.size();
  report.frames = capture.frames.count;
  describe_rate(pictures, report);
  const FrameClock clock(capture, video);
  Gaps unmet(capture.frames.step);
  double sum = 0, least = INFINITY, most = -INFINITY;
  size_t first = 0, last = 0, used = 0, first_met = 0;
  int64_t first_met_frame = 0;
  for (int64_t i = 0; i < capture.frames.count; i++) {
    const int64_t frame = capture.frames.number(i);
    const size_t picture = clock.nearest(pictures, frame);
    if (i && picture == last)
      report.used_again++;
    else
      used++;
    if (!i) first = picture;
    last = picture;
    if (!clock.meets(pictures, picture, frame)) {
      if (camera && !camera->is_calibrated(frame))
        report.frames--;
      else
        unmet.add(frame);
      continue;
    }
    if (!report.met++) {
      first_met = picture;
      first_met_frame = frame;
    }
    const double offset = clock.offset(pictures, picture, frame);
    sum += offset;
    least = std::min(least, offset);
    most = std::max(most, offset);
  }
  report.unmet = unmet.ranges();
  report.unmet_text = unmet.text();
  report.before = first;
  report.behind = report.pictures - 1 - last;
  report.between = last - first + 1 - used;
  if (!report.met) return report;
  report.mean_offset = sum / double(report.met);
  report.largest_offset = std::fabs(least) > std::fabs(most) ? least : most;
  const double frame = capture.frame_seconds();
  // Of jitter a tenth of a frame is still "alike": rounded time stamps have it.
  // Who gives a clock has measured the start as well.
  const bool is_measured = video.clock.numerator != video.clock.denominator;
  if (!is_measured && std::fabs(report.mean_offset) > 0.1 * frame && most - least < 0.1 * frame)
    report.better_start = clock.start_for(pictures, first_met, first_met_frame);
  return report;
}

} // namespace fvv::scene
