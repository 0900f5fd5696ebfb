/* stream/check_visibility.h: what the checker knows of a visibility track, and how it judges the next chunk.
 */
#ifndef FVV_STREAM_CHECK_VISIBILITY_H
#define FVV_STREAM_CHECK_VISIBILITY_H

#include "stream/check_calibration.h"
#include "stream/check_mesh.h"
#include "stream/visibility_frames.h"

/* Zero-initialise; reset frames in the end. */
typedef struct fvv_checked_visibility {
  uint64_t group; /* that is being read, counted from 1 */
  int lost;       /* a chunk of the group was wrong or could not be judged: those behind it cannot be */
  fvv_visibility_frames frames;
} fvv_checked_visibility;

/* Judges an intact VISI chunk; with decode, its content too. mesh: what is known of the track that it means
 * in this group, NULL: nothing. calibration: of the track of cameras that move, NULL: there was none. *whole
 * becomes 0 when something before this chunk is missing, which is no problem of its own. Offsets of
 * diagnostics are relative to the payload. */
FVV_MUST_USE fvv_status fvv_check_visibility(fvv_checked_visibility *visibility, const fvv_event *event,
                                             uint64_t group, int decode, const fvv_checked_mesh *mesh,
                                             const fvv_checked_calibration *calibration,
                                             const fvv_configuration *configuration, const fvv_limits *limits,
                                             const fvv_allocator *allocator, int *whole,
                                             fvv_diagnostic *diagnostic);

#endif
