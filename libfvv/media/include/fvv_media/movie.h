// A film with sound, as a camera records it: MP4.
#pragma once

#include "fvv_media/sound.h"
#include "fvv_media/video.h"

#include <string>
#include <vector>

namespace fvv::media {

// The bytes of an MP4 file: a group of H.264 or HEVC that encode_group made with these settings, and sound,
// NULL for none, whose time 0 is that of the first picture. Error for another codec.
std::string movie_file(const VideoSettings &settings, const EncodedGroup &group, const SoundPackets *sound);

// A sample of a video track, and when it is shown.
struct TimedSample {
  std::vector<uint8_t> bytes;
  bool key;
  int64_t time, duration; // ticks; the time of the film's first sample becomes 0
};

// The same of samples as a stream has them, nothing decoded. config: of H.264 or HEVC, else Error. samples:
// at least one, in rising order of time. tick: in seconds.
std::string movie_file(const fvv_video_config &config, const fvv_rational &tick,
                       const std::vector<TimedSample> &samples);

} // namespace fvv::media
