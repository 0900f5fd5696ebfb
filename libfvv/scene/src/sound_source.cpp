#include "fvv_scene/sound_source.h"
#include "fvv_cxx/input_file.h"
#include "scene/src/capture_fields.h"

#include <algorithm>

namespace fvv::scene {

namespace {

Place read_position(const JsonValue &value, double metres_per_unit) {
  Place out;
  for (size_t k = 0; k < out.size(); k++) out[k] = finite(value.items(3, k)) * metres_per_unit;
  return out;
}

std::map<int64_t, Place> read_positions(const JsonValue &value, const Frames &frames,
                                        double metres_per_unit) {
  std::map<int64_t, Place> out;
  for (size_t i = 0; i < value.size(); i++) {
    const JsonValue entry = value.item(i);
    entry.allow_keys({"frame", "position"});
    const JsonValue number = entry.at("frame");
    if (!out.emplace(number.integer(0, INT32_MAX), read_position(entry.at("position"), metres_per_unit))
             .second)
      number.fail("expected one entry for each frame, found a second one for " + number.found());
  }
  for (const int64_t frame : frames.numbers())
    if (!out.count(frame))
      value.fail("expected an entry for each of the capture's " + std::to_string(frames.count) +
                 " frames, found none for frame " + std::to_string(frame));
  return out;
}

SoundSource read_sound(const JsonValue &value, const Frames &frames, double metres_per_unit) {
  value.allow_keys({"file", "stream", "offset", "title", "language", "position", "per_frame"});
  SoundSource out;
  out.file = read_file_name(value.at("file"));
  out.stream = read_stream(value);
  if (const auto offset = value.find("offset")) out.offset = read_seconds(*offset);
  out.first = frames.first;
  if (const auto title = value.find("title")) out.title = title->text();
  if (const auto language = value.find("language")) {
    out.language = language->text();
    if (!out.language.empty() && !is_language(out.language))
      language->fail("expected a language tag of BCP 47 such as \"en\" or \"pt-BR\", found " +
                     language->found());
  }
  const auto position = value.find("position"), per_frame = value.find("per_frame");
  if (position && per_frame) per_frame->fail("expected position or per_frame, found both");
  if (position) out.position = read_position(*position, metres_per_unit);
  if (per_frame) out.per_frame = read_positions(*per_frame, frames, metres_per_unit);
  return out;
}

} // namespace

bool is_language(const std::string &text) {
  size_t length = 0, parts = 0;
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  for (size_t i = 0; i <= text.size(); i++) {
    const bool ends = i == text.size() || text[i] == '-';
    if (ends && (!length || length > 8)) return false;
    if (!ends && !is_letter(text[i]) && !(parts && text[i] >= '0' && text[i] <= '9')) return false;
    parts += ends;
    length = ends ? 0 : length + 1;
  }
  return true;
}

std::vector<SoundSource> read_sounds(const JsonValue &value, const Frames &frames, double metres_per_unit) {
  const size_t count = value.size();
  if (count > max_sounds)
    value.fail("expected at most " + std::to_string(max_sounds) + " sounds, found " + std::to_string(count));
  std::vector<SoundSource> out;
  for (size_t i = 0; i < count; i++) out.push_back(read_sound(value.item(i), frames, metres_per_unit));
  return out;
}

std::string format_sound(const SoundSource &source, std::string (*quoted)(const std::string &),
                         std::string (*list)(const double *values, size_t count)) {
  std::string out = "{\"file\": " + quoted(source.file);
  if (source.stream) out += ", \"stream\": " + std::to_string(*source.stream);
  out += ", \"offset\": \"" + std::to_string(source.offset.numerator) + "/" +
         std::to_string(source.offset.denominator) + "\"";
  if (!source.title.empty()) out += ", \"title\": " + quoted(source.title);
  if (!source.language.empty()) out += ", \"language\": " + quoted(source.language);
  if (source.position) out += ", \"position\": " + list(source.position->data(), 3);
  std::string entries;
  for (const auto &[frame, position] : source.per_frame)
    entries += (entries.empty() ? "" : ",\n      ") + ("{\"frame\": " + std::to_string(frame)) +
               ", \"position\": " + list(position.data(), 3) + "}";
  if (!entries.empty()) out += ", \"per_frame\": [" + entries + "]";
  return out + "}";
}

void check_sounds(const Capture &capture, Findings &findings) {
  for (const SoundSource &source : capture.sounds) {
    const std::string path = capture.resolve(source.file);
    std::string why = why_unreadable(path);
    if (!why.empty()) {
      findings.problems.push_back("audio: " + source.file + ": " + why);
      continue;
    }
    try {
      media::sound_info(path, source.stream);
    } catch (const Error &error) {
      findings.problems.push_back("audio: " + error.line());
    }
  }
}

} // namespace fvv::scene
