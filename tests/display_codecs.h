// The codecs of display values, for tests that try all of them on pictures of 8 bits: those of linear light
// have tests of their own.
#ifndef FVV_TESTS_DISPLAY_CODECS_H
#define FVV_TESTS_DISPLAY_CODECS_H

#include "fvv_media/video.h"

inline std::vector<fvv::media::VideoCodec> display_codecs() {
  std::vector<fvv::media::VideoCodec> out;
  for (const fvv::media::VideoCodec &codec : fvv::media::video_codecs())
    if (codec.shallowest == 8) out.push_back(codec);
  return out;
}

#endif
