// The sound of a capture: files, when they begin, and where in the scene they are heard.
#pragma once

#include "fvv_media/sound.h"
#include "fvv_scene/picture_source.h"

#include <array>
#include <map>
#include <memory>

namespace fvv::scene {

using Place = std::array<double, 3>;

// One recording; a stream has a track for each.
struct SoundSource {
  std::string file;
  std::optional<uint32_t> stream; // index among all streams of the file; nothing: the first sound
  Seconds offset;                 // on the file's time line, of frame number first
  int64_t first = 0;
  std::string title;
  std::string language; // BCP 47, "en" or "pt-BR"; may be empty
  // Where it is heard from, in metres; nothing: everywhere, as it was mixed. Of a source that moves by frame
  // number, at least of all frames of the capture.
  std::optional<Place> position;
  std::map<int64_t, Place> per_frame;
  // In place of the file, which is a name for messages then; times from the capture's first frame.
  std::shared_ptr<const media::SoundPackets> memory = nullptr;

  bool is_placed() const { return position || !per_frame.empty(); }
  // At a frame number of the capture, of a source that is placed.
  Place position_at(int64_t frame) const { return per_frame.empty() ? *position : per_frame.at(frame); }
};

constexpr size_t max_sounds = 64;

// The form of a language tag by RFC 5646, whether or not it is registered.
bool is_language(const std::string &text);

// An array; positions are in units of metres_per_unit. Error.
std::vector<SoundSource> read_sounds(const JsonValue &value, const Frames &frames, double metres_per_unit);
// As JSON; quoted: a text in JSON, list: numbers.
std::string format_sound(const SoundSource &source, std::string (*quoted)(const std::string &),
                         std::string (*list)(const double *values, size_t count));

struct Capture;
struct Findings;
// Adds to findings what is wrong with the files.
void check_sounds(const Capture &capture, Findings &findings);

} // namespace fvv::scene
