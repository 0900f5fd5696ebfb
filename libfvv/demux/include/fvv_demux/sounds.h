// The sound of a stream: the packets of its audio tracks with their times, and from where they are heard.
#pragma once

#include "fvv/stream.h"
#include "fvv_cxx/input_file.h"
#include "fvv_media/sound.h"
#include "fvv_scene/sound_source.h"

#include <map>
#include <string>
#include <vector>

namespace fvv::demux {

// Packets of a track that follow each other without a gap.
struct UnpackedSound {
  uint16_t track = 0;
  media::SoundPackets packets; // times from the scene's time 0; those that only begin a group come first
  std::string title, language;
  std::optional<scene::Place> position;     // of sound that is placed and does not move
  std::map<int64_t, scene::Place> places{}; // of sound that moves, by ticks of the scene

  // Of sound that is placed, at a tick.
  scene::Place position_at(int64_t tick) const;
};

struct UnpackedSounds {
  std::vector<UnpackedSound> sounds; // by track and time
  std::vector<std::string> losses;   // what is damaged or unknown, for people; the rest is there
};

// The sound of groups first to last of a file, all of which have the configuration of the first one. A chunk
// that is damaged is a loss, and the sound goes on after it. limits NULL: defaults.
UnpackedSounds unpack_sounds(const InputFile &file, size_t first, size_t last,
                             const fvv_limits *limits = nullptr);

// A decoder for a track's packets, in the terms of fvv_media. Error for an unknown codec.
media::SoundFormat sound_format(const fvv_audio_config &config);

} // namespace fvv::demux
