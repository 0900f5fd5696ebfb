/* What libavcodec's encoders give, made into samples and configuration records as fvv carries them, codec by
 * codec. Knows where headers stand and the few of their fields that records repeat; whether the result keeps
 * the format's rules, libfvv checks. Internal to fvv_media. */
#ifndef FVV_MEDIA_BITSTREAM_H
#define FVV_MEDIA_BITSTREAM_H

#include "fvv_media/video.h"
#include "nal.h"

namespace fvv::media {

struct Bitstream {
  /* A packet of the encoder as a sample. */
  Bytes (*sample)(const uint8_t *packet, size_t size);
  /* Of a group with these settings. header: the encoder's global header; first: the first sample. Error when
   * either is not what the encoder was asked for. */
  Bytes (*record)(const VideoSettings &settings, const Bytes &header, const Bytes &first);
};

/* ISO/IEC 14496-15, clauses 5 and 8: slices behind 4-byte lengths; parameter sets stand in the record alone.
 */
extern const Bitstream avc_bitstream, hevc_bitstream;
/* VP Codec ISO Media File Format Binding: packets as they are. */
extern const Bitstream vp9_bitstream;
/* AV1 Codec ISO Media File Format Binding: temporal units without their delimiter. */
extern const Bitstream av1_bitstream;

} // namespace fvv::media

#endif
