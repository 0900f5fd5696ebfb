/* stream/group_tiles.h: the layout that a GTIL chunk gives to the frames of its group (clause 10.11). */
#ifndef FVV_STREAM_GROUP_TILES_H
#define FVV_STREAM_GROUP_TILES_H

#include "base/memory.h"
#include "fvv/stream.h"

/* Decodes the payload of a GTIL of a track into fvv_tile, and checks it against the configuration. *tiles
 * belongs to the caller, whatever is answered. Offsets of diagnostics are relative to the payload. */
FVV_MUST_USE fvv_status fvv_group_tiles_decode(const fvv_configuration *configuration, uint16_t track,
                                               const uint8_t *payload, size_t size, const fvv_limits *limits,
                                               fvv_bytes *tiles, fvv_diagnostic *diagnostic);

/* What the checker knows of the layouts of a track. Zero-initialise. */
typedef struct fvv_checked_tiles {
  uint64_t lost_in; /* the group, counted from 1, whose layout is wrong: nobody can use its samples */
} fvv_checked_tiles;

/* Judges an intact GTIL chunk, and counts it in summary. */
FVV_MUST_USE fvv_status fvv_check_group_tiles(fvv_checked_tiles *checked, const fvv_event *event,
                                              uint64_t group, const fvv_configuration *configuration,
                                              const fvv_limits *limits, const fvv_allocator *allocator,
                                              fvv_track_summary *summary, fvv_diagnostic *diagnostic);

#endif
