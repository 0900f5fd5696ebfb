// Sound of a stream that arrives: chunks in order become samples, without repetitions and pre-roll.
#pragma once

#include "fvv/frames.h"
#include "fvv_media/sound.h"
#include "source.h"

#include <array>
#include <map>
#include <optional>
#include <vector>

namespace fvv::python {

// What one chunk adds.
struct LiveSound {
  uint16_t track = 0;
  uint32_t rate = 0, channels = 0;
  int64_t start = 0;          // samples from time 0
  std::vector<float> samples; // interleaved, full scale 1
  std::optional<std::array<double, 3>> position;
};

class LiveSounds {
public:
  LiveSounds(const fvv_configuration &the_configuration, const std::string &file_name)
      : configuration(the_configuration), file(file_name) {}
  void begin_group(int64_t start, int64_t end);
  // Of an AUDI chunk; nothing while its packets only prepare the decoder. Throws Failure.
  std::optional<LiveSound> decode(const fvv_frame_chunk &chunk);

private:
  struct Track {
    std::optional<media::SoundDecoder> decoder; // none: nothing was decoded yet
    fvv_audio_place place = {};                 // in the group
    bool in_group = false;                      // a chunk of this group came
    int64_t end = 0;                            // of what was decoded
    int64_t heard = 0;                          // before it the decoder is not right yet
  };
  const fvv_configuration &configuration;
  const std::string &file;
  int64_t group_start = 0, group_end = 0; // ticks
  std::map<uint16_t, Track> tracks;
};

} // namespace fvv::python
