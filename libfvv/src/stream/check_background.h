/* stream/check_background.h: what the checker knows of a background track, and how it judges the next chunk.
 */
#ifndef FVV_STREAM_CHECK_BACKGROUND_H
#define FVV_STREAM_CHECK_BACKGROUND_H

#include "fvv/stream.h"

/* Zero-initialise. */
typedef struct fvv_checked_background {
  uint64_t size; /* of the last intact chunk; 0: none */
  uint32_t crc, digest;
} fvv_checked_background;

/* Judges an intact BACK chunk; with decode, its meshes too. digest: of the configuration, from GRUP. *counts
 * gets what it holds. Offsets of diagnostics are relative to the payload. */
FVV_MUST_USE fvv_status fvv_check_background(fvv_checked_background *background, const fvv_event *event,
                                             uint32_t digest, int decode, const fvv_limits *limits,
                                             const fvv_allocator *allocator, fvv_track_summary *counts,
                                             fvv_diagnostic *diagnostic);

#endif
