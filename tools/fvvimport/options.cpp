// Strict parsing of the values of options.
#include "fvvimport/options.h"

#include "cli/cli.h"
#include "fvv_cxx/range.h"
#include "fvv_scene/text.h"
#include "fvv_scene/vocabulary.h"

#include <numeric>

namespace fvv::fvvimport {

namespace {

[[noreturn]] void refuse(const char *option, const std::string &expected, const std::string &found) {
  throw Error(std::string(option) + ": expected " + expected + ", found " + scene::quote(found),
              Error::usage);
}

// Digits only: no sign.
bool parse_count(std::string_view text, int64_t least, int64_t most, int64_t &value) {
  return text.find_first_not_of("0123456789") == text.npos && scene::parse_integer(text, value) &&
         value >= least && value <= most;
}

// The two numbers around a separator; the second is otherwise if there is none.
bool parse_pair(const std::string &text, char separator, int64_t least, int64_t most, int64_t &first,
                std::optional<int64_t> &second) {
  const size_t at = text.find(separator);
  int64_t number;
  if (!parse_count(std::string_view(text).substr(0, at), least, most, first)) return false;
  if (at == text.npos) return true;
  if (!parse_count(std::string_view(text).substr(at + 1), least, most, number)) return false;
  second = number;
  return true;
}

scene::Pattern checked(const char *option, const std::string &text, const scene::Frames &frames) {
  std::string what;
  const auto pattern = scene::Pattern::parse(text, &what);
  if (!pattern) throw Error(std::string(option) + ": " + what, Error::usage);
  if (!pattern->is_numbered() && frames.count > 1)
    refuse(option, "%d or %0Nd for the number of each of " + std::to_string(frames.count) + " frames", text);
  return *pattern;
}

// {name} and {id} replaced; percent: the replacement of a percent sign in a name.
std::string put_in(const char *option, const std::string &text, const scene::Camera &camera,
                   const std::string &percent) {
  std::string out;
  for (size_t i = 0; i < text.size(); i++) {
    if (text.compare(i, 6, "{name}") == 0) {
      for (const char c : *camera.name) out += c == '%' ? percent : std::string(1, c);
      i += 5;
    } else if (text.compare(i, 4, "{id}") == 0) {
      out += std::to_string(camera.calibration.id);
      i += 3;
    } else if (text[i] == '{' || text[i] == '}') {
      refuse(option, "{name} or {id} where there are braces", text);
    } else {
      out += text[i];
    }
  }
  return out;
}

} // namespace

fvv_rational parse_frame_rate(const std::string &text) {
  int64_t rate;
  std::optional<int64_t> per;
  if (!parse_pair(text, '/', 1, UINT32_MAX, rate, per))
    refuse("--frame-rate", "frames per second like 25 or 30000/1001", text);
  const int64_t divisor = std::gcd(rate, per.value_or(1));
  return {static_cast<uint32_t>(per.value_or(1) / divisor), static_cast<uint32_t>(rate / divisor)};
}

scene::Frames parse_frames(const std::string &text) {
  const fvv::Range range = fvv::parse_range("--frames", text);
  if (range.last - range.first >= 10'000'000) refuse("--frames", "at most 10000000 frames", text);
  scene::Frames frames;
  frames.first = range.first;
  frames.count = range.last - range.first + 1;
  return frames;
}

Size parse_size(const std::string &text) {
  int64_t width;
  std::optional<int64_t> height;
  if (!parse_pair(text, 'x', 1, INT32_MAX, width, height) || !height)
    refuse("--size", "WIDTHxHEIGHT like 640x480", text);
  return {static_cast<uint32_t>(width), static_cast<uint32_t>(*height)};
}

std::optional<double> parse_units(const std::string &text) {
  if (text == scene::unknown_units) return std::nullopt;
  for (const scene::NamedUnit &unit : scene::named_units)
    if (text == unit.name) return unit.metres;
  double metres;
  if (!scene::parse_double(text, metres) || !(metres > 0))
    refuse("--units", "metres, centimetres, millimetres, inches, feet, unknown or metres per unit > 0", text);
  return metres;
}

uint8_t parse_up(const std::string &text) {
  for (const scene::NamedAxis &axis : scene::named_axes)
    if (text == axis.name) return axis.up;
  refuse("--up", "+x, -x, +y, -y, +z, -z or unknown", text);
}

scene::Pattern parse_pattern(const char *option, const std::string &text, const scene::Camera &camera,
                             const scene::Frames &frames) {
  return checked(option, put_in(option, text, camera, "%%"), frames);
}

scene::VideoSource parse_video(const char *option, const std::string &text, const scene::Camera &camera,
                               const scene::Frames &frames) {
  return {put_in(option, text, camera, "%"), std::nullopt, {}, frames.first};
}

scene::Pattern parse_pattern(const char *option, const std::string &text, const scene::Frames &frames) {
  return checked(option, text, frames);
}

} // namespace fvv::fvvimport
