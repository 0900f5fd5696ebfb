// Strict parsing of the values of options.
#include "fvvimport/options.h"

#include "cli/cli.h"
#include "fvv_cxx/range.h"
#include "fvv_scene/file_io.h"
#include "fvv_scene/inputs.h"

namespace fvv::fvvimport {

namespace {

[[noreturn]] void refuse(const char *option, const std::string &expected, const std::string &found) {
  refuse_option(option, "expected " + expected + ", found " + scene::quote(found));
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
  if (!pattern) refuse_option(option, what);
  if (!pattern->is_numbered() && frames.count > 1)
    refuse(option, "%d or %0Nd for the number of each of " + std::to_string(frames.count) + " frames", text);
  return *pattern;
}

} // namespace

scene::Frames parse_frames(const std::string &text) {
  const fvv::Range range = fvv::parse_range("frames", text);
  if (range.last - range.first >= 10'000'000) refuse("frames", "at most 10000000 frames", text);
  scene::Frames frames;
  frames.first = range.first;
  frames.count = range.last - range.first + 1;
  return frames;
}

Size parse_size(const std::string &text) {
  int64_t width;
  std::optional<int64_t> height;
  if (!parse_pair(text, 'x', 1, INT32_MAX, width, height) || !height)
    refuse("size", "WIDTHxHEIGHT like 640x480", text);
  return {static_cast<uint32_t>(width), static_cast<uint32_t>(*height)};
}

scene::Pattern parse_pattern(const char *option, const std::string &text, const scene::Camera &camera,
                             const scene::Frames &frames) {
  return checked(option, scene::fill_in(option, text, camera, "%%"), frames);
}

scene::VideoSource parse_video(const char *option, const std::string &text, const scene::Camera &camera,
                               const scene::Frames &frames) {
  return {scene::fill_in(option, text, camera, "%"), std::nullopt, {}, frames.first};
}

scene::Pattern parse_pattern(const char *option, const std::string &text, const scene::Frames &frames) {
  return checked(option, text, frames);
}

} // namespace fvv::fvvimport
