/* stream/check_calibration.h: what the checker knows of a calibration track, and how it judges the next chunk
 * of it. */
#ifndef FVV_STREAM_CHECK_CALIBRATION_H
#define FVV_STREAM_CHECK_CALIBRATION_H

#include "fvv/stream.h"

/* Zero-initialise; reset in the end. */
typedef struct fvv_checked_calibration {
  uint64_t block, group;    /* that are being read, both counted from 1 */
  int64_t time;             /* of the last chunk */
  int lost;                 /* a chunk of the group was wrong: those up to the next key cannot be judged */
  fvv_calibration *cameras; /* of the block */
} fvv_checked_calibration;

void fvv_checked_calibration_reset(fvv_checked_calibration *calibration);

/* Where cameras are at a time, by the chunk of the group that came last; NULL: it was of another time, or is
 * not known. */
const fvv_calibration *fvv_checked_calibration_at(const fvv_checked_calibration *calibration, uint64_t group,
                                                  int64_t time);

/* Adds what an intact CALB chunk declares. */
void fvv_count_calibrations(fvv_track_summary *summary, const fvv_event *event,
                            const fvv_configuration *configuration);

/* Judges an intact CALB chunk. *whole becomes 0 when one before it is missing, which is no problem of its
 * own. Offsets of diagnostics are relative to the payload. */
FVV_MUST_USE fvv_status fvv_check_calibration(fvv_checked_calibration *calibration, const fvv_event *event,
                                              uint64_t block, uint64_t group,
                                              const fvv_configuration *configuration,
                                              const fvv_allocator *allocator, int *whole,
                                              fvv_diagnostic *diagnostic);

#endif
