// The audio tracks of a plan and their chunks.
#pragma once

#include "fvv/audio.h"
#include "fvv_mux/encoder.h"
#include "mux/src/plan.h"

namespace fvv::mux {

// Of SoundTrack number i of a plan; above all other tracks.
constexpr uint16_t first_sound_track = 10001;
inline uint16_t sound_track_id(size_t i) {
  return uint16_t(first_sound_track + i);
}

// For a capture in memory. Throws Error (usage).
std::vector<scene::SoundSource> sounds_of(const std::vector<SoundInput> &inputs);

// Reads and encodes the sound of the capture for the frames and groups of the plan. Returns whether it
// warned. Error for a file that cannot be used and for a bit rate that does not fit.
bool load_sounds(Plan &plan);

// Of sound in memory, once all frames are known. Returns whether it warned.
bool warn_of_lost_sound(const Plan &plan);

// What ACFG says; borrows from the track.
fvv_audio_config config_of(const SoundTrack &track);
fvv_rational time_base_of(const SoundTrack &track);
uint32_t bit_rate_of(const SoundTrack &track); // of all packets, on average
const char *sound_codec_text(const SoundTrack &track);

// The part of the stream in which a track has sound, in seconds.
struct SoundSpan {
  double start, end;
};
SoundSpan span_of(const Plan &plan, const SoundTrack &track);

// An AUDI chunk.
struct SoundChunk {
  size_t track; // of Plan::sounds
  int64_t time; // ticks of the scene
  bool key;
  uint32_t packets; // those that repeat others left out
  std::vector<uint8_t> payload;
};
// Of all tracks for ticks start ... end - 1, by rising time: of a group whose first frame is number first and
// which has count frames.
std::vector<SoundChunk> sound_chunks(const Plan &plan, const GroupSpan &group);

} // namespace fvv::mux
