/* The options of libavcodec's encoders that fulfil video.h. Internal to fvv_media. */
#ifndef FVV_MEDIA_ENCODER_OPTIONS_H
#define FVV_MEDIA_ENCODER_OPTIONS_H

#include "codecs.h"
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
  int steps_per_unit; /* of its CRF: 1 when it knows whole numbers only */
  bool two_passes;
  /* The options of a draft, and of less effort, in place of these; draft empty: there are no
   * drafts; least empty: that of live. */
  std::vector<EncoderOption> draft, fast, live, least;
  /* Bytes of memory for a pixel of 8 bits: for the group as a whole, for each frame that waits, and for each
   * one that is kept to predict from. */
  double memory, waiting_memory, kept_memory;
  int waiting, kept; /* frames, at most; waiting 0: look_ahead() decides */
};

/* NULL only for stills and unknown codecs. */
const VideoEncoder *find_encoder(uint32_t codec);

/* The bytes that encoding a group takes, its pictures included, about. */
uint64_t encoding_memory(const VideoSettings &settings, size_t frames);

/* An encoder for one group, opened: of crf, in place of settings.quality. pass: 0, or AV_CODEC_FLAG_PASS1 or
 * PASS2 with the statistics that the first left in stats_out, which must stay as long as the encoder. */
Context open_encoder(const VideoEncoder &encoder, const VideoSettings &settings, double crf, int pass,
                     const std::string &statistics);

} // namespace fvv::media

#endif
