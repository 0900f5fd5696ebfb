/* How libavcodec's encoders are asked for what video.h promises. Internal to fvv_media. */
#ifndef FVV_MEDIA_ENCODER_OPTIONS_H
#define FVV_MEDIA_ENCODER_OPTIONS_H

#include "bitstream.h"
#include "ffmpeg.h"

namespace fvv::media {

struct EncoderOption {
  const char *name, *value;
};

struct VideoEncoder {
  uint32_t codec;
  const char *library; /* its name in libavcodec */
  std::vector<EncoderOption> options;
  const Bitstream &bitstream;
};

/* NULL for JPEG, which libavcodec does not encode here, and for codecs that are not known; no other. */
const VideoEncoder *find_encoder(uint32_t codec);

/* An encoder for one group, opened. */
Context open_encoder(const VideoEncoder &encoder, const VideoSettings &settings);

} // namespace fvv::media

#endif
