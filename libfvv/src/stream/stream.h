/* stream/stream.h: the state of fvv_stream, which stream.c, stream_background.c, stream_camera.c,
 * stream_mesh.c, stream_tiles.c and stream_visibility.c share. */
#ifndef FVV_STREAM_STREAM_H
#define FVV_STREAM_STREAM_H

#include "stream/configuration.h"

struct fvv_stream {
  fvv_allocator allocator;
  fvv_limits limits;
  fvv_file *file;
  fvv_configuration_builder configuration;
  uint64_t configuration_offset; /* of the block that is loaded; 0: none */
  size_t frame_count;
  fvv_bytes firsts;             /* uint64_t for each group: number of its first frame */
  fvv_bytes meshes;             /* followed_track: where delta frames were decoded last */
  fvv_bytes visibility;         /* followed_visibility: where each track was decoded last */
  fvv_calibration *calibration; /* of the block that is loaded; NULL: none yet */
  uint64_t calibration_chunk;   /* offset of the chunk that was decoded last; 0: none */
  fvv_bytes layouts; /* followed_tiles: the layout of a group that was decoded last, of each track */
  fvv_bytes background_payload; /* of the BACK chunk that was read last, and what it says */
  fvv_background background;
  uint64_t background_chunk; /* its offset; 0: none */
};

/* The chunks of a frame: a run within its group's list, which begins with first. */
typedef struct fvv_frame_chunks {
  const fvv_chunk_info *chunks;
  size_t count;
  size_t group;
  const fvv_chunk_info *first;
} fvv_frame_chunks;

FVV_MUST_USE fvv_status fvv_stream_find(fvv_stream *stream, size_t frame, fvv_frame_chunks *found,
                                        fvv_diagnostic *diagnostic);

/* The frame's chunk of a type on a track; NULL: it has none. */
const fvv_chunk_info *fvv_stream_chunk_of(const fvv_frame_chunks *found, uint32_t type, uint16_t track);

/* What is kept of a track between calls: the element of list, of elements of size bytes that begin with the
 * track's uint16_t, which is that track's. One that is not there is added, all else of it zero. Valid until
 * the next is added. FVV_ERROR_LIMIT: there are as many as a stream may have tracks. */
FVV_MUST_USE fvv_status fvv_stream_kept_of(const fvv_stream *stream, fvv_bytes *list, size_t size,
                                           uint16_t track, void **element);

/* Where the cameras of a frame that move are, decoded; belongs to the stream, valid until the next call on
 * it. FVV_END: there is no calibration at its time. */
FVV_MUST_USE fvv_status fvv_stream_calibration(fvv_stream *stream, const fvv_frame_chunks *found,
                                               const fvv_configuration *configuration,
                                               const fvv_calibration **calibration,
                                               fvv_diagnostic *diagnostic);

void fvv_stream_release_meshes(fvv_stream *stream);
void fvv_stream_release_cameras(fvv_stream *stream);
void fvv_stream_release_tiles(fvv_stream *stream);
void fvv_stream_release_visibility(fvv_stream *stream);
void fvv_stream_release_background(fvv_stream *stream);
/* The chunk that fvv_stream_background decodes. FVV_END: there is none. */
FVV_MUST_USE fvv_status fvv_stream_find_background(fvv_stream *stream, size_t group, uint16_t track,
                                                   const fvv_chunk_info **chunk, fvv_diagnostic *diagnostic);

#endif
