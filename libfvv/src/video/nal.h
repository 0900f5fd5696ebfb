/* video/nal.h: NAL units behind 4-byte lengths, the sample format that H.264 and HEVC share in MP4
 * (ISO/IEC 14496-15 clause 4.3). Knows lengths and the forbidden bit, no unit's type. */
#ifndef FVV_VIDEO_NAL_H
#define FVV_VIDEO_NAL_H

#include "fvv/video.h"

typedef struct fvv_nal_walk {
  const uint8_t *sample;
  size_t size, position;
  size_t least; /* bytes of a unit */
  uint32_t issue;
  const char *codec;
  fvv_diagnostic *diagnostic;
} fvv_nal_walk;

/* The next unit: FVV_OK, FVV_END behind the last, FVV_ERROR_INVALID with the walk's issue. A sample has at
 * least one unit. */
fvv_status fvv_nal_next(fvv_nal_walk *walk, const uint8_t **unit, size_t *size);

#endif
