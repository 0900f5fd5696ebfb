// Patterns of file names, and the sources of pictures in capture.json.
#include "fvv_scene/picture_source.h"
#include "fvv_scene/file_io.h"
#include "scene/src/capture_fields.h"

namespace fvv::scene {

std::optional<Pattern> Pattern::parse(const std::string &text, std::string *what) {
  const auto refuse = [&](const char *reason) {
    *what = reason + (", found " + quote(text));
    return std::nullopt;
  };
  Pattern pattern;
  pattern.source = text;
  if (text.empty()) return refuse("expected a file name");
  for (size_t i = 0; i < text.size(); i++) {
    std::string &out = pattern.numbered ? pattern.suffix : pattern.prefix;
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    i++;
    if (i < text.size() && text[i] == '%') {
      out += '%';
      continue;
    }
    // %d, or %0Nd with N from 1 to 9.
    unsigned width = 0;
    if (i + 1 < text.size() && text[i] == '0' && text[i + 1] >= '1' && text[i + 1] <= '9') {
      width = static_cast<unsigned>(text[i + 1] - '0');
      i += 2;
    }
    if (i >= text.size() || text[i] != 'd') return refuse("expected %d, %0Nd (N from 1 to 9) or %% after %");
    if (pattern.numbered) return refuse("expected one %d, not more");
    pattern.numbered = true;
    pattern.width = width;
  }
  return pattern;
}

std::string Pattern::file(int64_t frame) const {
  if (!numbered) return prefix;
  const std::string digits = std::to_string(frame + offset);
  return prefix + std::string(digits.size() < width ? width - digits.size() : 0, '0') + digits + suffix;
}

std::optional<int64_t> Pattern::frame(std::string_view name) const {
  int64_t number;
  if (!numbered || name.size() <= prefix.size() + suffix.size() ||
      !parse_integer(name.substr(prefix.size(), name.size() - prefix.size() - suffix.size()), number) ||
      number < 0 || number < offset || file(number - offset) != name)
    return std::nullopt;
  return number - offset;
}

std::string read_file_name(const JsonValue &value) {
  const std::string name = value.text();
  if (name.empty()) value.fail("expected a file name, found " + value.found());
  return name;
}

std::optional<uint32_t> read_stream(const JsonValue &object) {
  const auto stream = object.find("stream");
  return stream ? std::optional<uint32_t>(uint32_t(stream->integer(0, UINT16_MAX))) : std::nullopt;
}

Seconds read_seconds(const JsonValue &value) {
  if (value.is_integer()) return {value.integer(-int64_t(UINT32_MAX), UINT32_MAX), 1};
  const std::string text = value.is_text() ? value.text() : "";
  const bool negative = !text.empty() && text[0] == '-';
  const std::optional<fvv_rational> size = parse_rational(std::string_view(text).substr(negative ? 1 : 0));
  if (!size)
    value.fail("expected seconds as an integer or as text such as \"3/2\" or \"-3/2\", found " +
               value.found());
  return {negative ? -int64_t(size->numerator) : int64_t(size->numerator), size->denominator};
}

namespace {

int read_rotation(const JsonValue &value) {
  const int64_t degrees = value.integer(0, 270);
  if (degrees % 90) value.fail("expected 0, 90, 180 or 270, found " + value.found());
  return int(degrees);
}

// A quartz is right to 0.0001; what is beyond a hundredth is another frame rate, not a clock.
fvv_rational read_clock(const JsonValue &value) {
  const std::optional<fvv_rational> clock = value.is_integer()
                                                ? fvv_rational{uint32_t(value.integer(0, UINT32_MAX)), 1}
                                                : parse_rational(value.is_text() ? value.text() : "");
  const auto hundred = [](uint32_t number) { return uint64_t(100) * number; };
  if (!clock || !clock->numerator || hundred(clock->numerator) < uint64_t(99) * clock->denominator ||
      hundred(clock->numerator) > uint64_t(101) * clock->denominator)
    value.fail(
        "expected 1 or a fraction from 99/100 to 101/100 as text, such as \"1000145/1000000\", found " +
        value.found());
  return *clock;
}

VideoSource read_video(const JsonValue &value, const Frames &frames) {
  value.allow_keys({"video", "stream", "start", "clock", "rotate", "place"});
  VideoSource video;
  video.file = read_file_name(value.at("video"));
  video.stream = read_stream(value);
  if (const auto start = value.find("start")) video.start = read_seconds(*start);
  if (const auto clock = value.find("clock")) video.clock = read_clock(*clock);
  video.first = frames.first;
  return video;
}

} // namespace

bool PictureSource::has_same_pictures(const PictureSource &other) const {
  if (bool(video) != bool(other.video) || text() != other.text()) return false;
  return video ? video->stream == other.video->stream : pattern->offset == other.pattern->offset;
}

PictureSource read_picture_source(const JsonValue &value, const Frames &frames, bool constant) {
  const auto stills = [&](const JsonValue &text) {
    return constant ? read_pattern(text) : read_pattern(text, frames);
  };
  if (value.is_text()) return stills(value);
  if (!value.is_object())
    value.fail("expected a pattern as text, or an object with a pattern or a video, found " + value.found());
  const bool is_video = value.find("video").has_value();
  if (!is_video) value.allow_keys({"pattern", "video", "offset", "rotate", "place"});
  PictureSource source =
      is_video ? PictureSource(read_video(value, frames)) : PictureSource(stills(value.at("pattern")));
  if (const auto offset = is_video ? std::nullopt : value.find("offset")) {
    source.pattern->offset = offset->integer(-int64_t(UINT32_MAX), UINT32_MAX);
    if (source.is_constant()) offset->fail("expected a pattern with a number, because there is an offset");
    if (frames.first + source.pattern->offset < 0)
      offset->fail("expected at least " + std::to_string(-frames.first) + ", because frame " +
                   std::to_string(frames.first) + " has no file otherwise, found " + offset->found());
  }
  if (const auto rotate = value.find("rotate")) source.rotate = read_rotation(*rotate);
  if (const auto place = value.find("place")) {
    constexpr int64_t most = UINT16_MAX;
    source.place.emplace();
    source.place->x = int32_t(place->items(2, 0).integer(-most, most));
    source.place->y = int32_t(place->items(2, 1).integer(-most, most));
  }
  return source;
}

std::string format_picture_source(const PictureSource &source, std::string (*quoted)(const std::string &)) {
  const int64_t offset = source.pattern ? source.pattern->offset : 0;
  if (source.pattern && !source.rotate && !offset && !source.place) return quoted(source.text());
  std::string out = std::string(source.video ? "{\"video\": " : "{\"pattern\": ") + quoted(source.text());
  if (source.video) {
    const VideoSource &video = *source.video;
    if (video.stream) out += ", \"stream\": " + std::to_string(*video.stream);
    out += ", \"start\": \"" + std::to_string(video.start.numerator) + "/" +
           std::to_string(video.start.denominator) + "\"";
    if (video.clock.numerator != video.clock.denominator)
      out += ", \"clock\": \"" + std::to_string(video.clock.numerator) + "/" +
             std::to_string(video.clock.denominator) + "\"";
  }
  if (offset) out += ", \"offset\": " + std::to_string(offset);
  if (source.rotate) out += ", \"rotate\": " + std::to_string(*source.rotate);
  if (source.place)
    out += ", \"place\": [" + std::to_string(source.place->x) + ", " + std::to_string(source.place->y) + "]";
  return out + "}";
}

} // namespace fvv::scene
