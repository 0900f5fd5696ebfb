// capture/gltf/animation.cpp: keyframes and what lies between them.
#include "capture/gltf/animation.h"
#include "capture/gltf/transform.h"

#include <algorithm>

namespace fvv::capture::gltf {

namespace {

// Spherical linear interpolation along the shorter arc, by halving it: the middle of two unit quaternions is
// their sum made as long as 1. Sines would do the same, but are not the same on every machine. After 27
// halvings arc and chord differ by less than a double can tell.
void slerp(const double *from, const double *to, double share, double *out) {
  double low[4], high[4], dot = 0;
  std::copy_n(from, 4, low);
  for (size_t k = 0; k < 4; k++) dot += from[k] * to[k];
  for (size_t k = 0; k < 4; k++) high[k] = dot < 0 ? -to[k] : to[k];
  for (int halving = 0; halving < 27; halving++) {
    double middle[4];
    for (size_t k = 0; k < 4; k++) middle[k] = low[k] + high[k];
    normalise(middle); // at most a right angle apart: never zero
    share *= 2;
    if (share < 1) {
      std::copy_n(middle, 4, high);
    } else {
      std::copy_n(middle, 4, low);
      share -= 1;
    }
  }
  for (size_t k = 0; k < 4; k++) out[k] = low[k] + share * (high[k] - low[k]);
}

Interpolation read_interpolation(const JsonValue &sampler) {
  const auto value = sampler.find("interpolation");
  if (!value) return Interpolation::linear;
  const std::string text = value->text();
  if (text == "STEP") return Interpolation::step;
  if (text == "LINEAR") return Interpolation::linear;
  if (text != "CUBICSPLINE") value->fail("expected STEP, LINEAR or CUBICSPLINE, found " + value->found());
  return Interpolation::cubic_spline;
}

Purpose purpose_of(Path path) {
  return path == Path::rotation  ? Purpose::rotations
         : path == Path::weights ? Purpose::amounts
                                 : Purpose::vectors;
}

} // namespace

Channel read_channel(Container &container, const JsonValue &channel, const JsonValue &samplers, Path path,
                     size_t width) {
  const JsonValue reference = channel.at("sampler");
  const int64_t index = reference.integer(0, INT32_MAX);
  if (static_cast<uint64_t>(index) >= samplers.size())
    reference.fail("expected one of " + std::to_string(samplers.size()) + " samplers, found " +
                   reference.found());
  const JsonValue sampler = samplers.item(static_cast<size_t>(index)), input = sampler.at("input"),
                  output = sampler.at("output");
  Channel out = {0, path, read_interpolation(sampler), width, {}, {}, channel.place()};
  out.times = accessor_numbers(container, input, Purpose::times);
  for (size_t i = 0; i < out.times.size(); i++)
    if (out.times[i] < 0 || (i && out.times[i] <= out.times[i - 1]))
      container.item("accessors", input)
          .fail("expected times that begin at 0 or later and increase, element " + std::to_string(i) +
                " does not");
  out.values = accessor_numbers(container, output, purpose_of(path));
  const size_t expected =
      out.times.size() * width * (out.interpolation == Interpolation::cubic_spline ? 3 : 1);
  if (out.values.size() != expected)
    container.item("accessors", output)
        .fail("expected " + std::to_string(expected) + " numbers for " + std::to_string(out.times.size()) +
              " times, found " + std::to_string(out.values.size()));
  if (path == Path::rotation && out.interpolation != Interpolation::cubic_spline)
    for (size_t i = 0; i < out.values.size(); i += 4)
      if (!normalise(&out.values[i]))
        container.item("accessors", output)
            .fail("element " + std::to_string(i / 4) +
                  ": expected a rotation, found a quaternion of length 0");
  return out;
}

std::vector<double> Channel::at(double time) const {
  // Keyframes are float32: without rounding, a step that falls onto a frame would come one frame late half
  // the time.
  const double now = interpolation == Interpolation::step ? double(float(time)) : time;
  const bool cubic = interpolation == Interpolation::cubic_spline;
  const size_t pitch = cubic ? 3 * width : width, inner = cubic ? width : 0;
  const auto next = std::upper_bound(times.begin(), times.end(), now);
  const size_t high = static_cast<size_t>(next - times.begin()), low = high ? high - 1 : 0;
  std::vector<double> out(width);
  const double *from = &values[low * pitch + inner], *to = from + pitch;
  if (high == 0 || high == times.size() || interpolation == Interpolation::step) {
    std::copy_n(from, width, out.begin());
  } else {
    const double span = times[high] - times[low], s = (now - times[low]) / span;
    if (cubic) {
      const double s2 = s * s, s3 = s2 * s;
      const double *leaving = from + width, *arriving = to - width;
      for (size_t k = 0; k < width; k++)
        out[k] = (2 * s3 - 3 * s2 + 1) * from[k] + span * (s3 - 2 * s2 + s) * leaving[k] +
                 (3 * s2 - 2 * s3) * to[k] + span * (s3 - s2) * arriving[k];
    } else if (path == Path::rotation) {
      slerp(from, to, s, out.data());
    } else {
      for (size_t k = 0; k < width; k++) out[k] = from[k] + s * (to[k] - from[k]);
    }
  }
  if (path == Path::rotation && !normalise(out.data()))
    throw FileError(place + ": the rotation at " + std::to_string(time) + " s has no direction");
  return out;
}

} // namespace fvv::capture::gltf
