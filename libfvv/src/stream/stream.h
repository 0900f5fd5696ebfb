/* stream/stream.h: the fields of fvv_stream, for code that needs more than its public functions. */
#ifndef FVV_STREAM_STREAM_H
#define FVV_STREAM_STREAM_H

#include "container/file.h"
#include "stream/configuration.h"

/* The chunk of a track that does not decode: what depends on it fails in the same way, without being decoded
 * again from the key on. Else a stream of n frames would cost n * n steps. */
typedef struct fvv_known_failure {
  uint64_t chunk; /* its offset; 0: none */
  fvv_status status;
  fvv_diagnostic diagnostic;
} fvv_known_failure;

struct fvv_stream {
  fvv_allocator allocator;
  fvv_limits limits;
  fvv_file *file;
  fvv_configuration_builder configuration;
  uint64_t configuration_offset; /* of the block that is loaded, ~group where the group names none; 0: none */
  size_t frame_count;
  fvv_bytes firsts;     /* uint64_t for each group: number of its first frame; empty until it is needed */
  fvv_bytes meshes;     /* followed_track: where delta frames were decoded last */
  fvv_bytes colours;    /* followed_colours: of each mesh track */
  fvv_bytes visibility; /* followed_visibility: where each track was decoded last */
  fvv_calibration *calibration; /* of the block that is loaded; NULL: none yet */
  uint64_t calibration_chunk;   /* offset of the chunk that was decoded last; 0: none */
  fvv_known_failure calibration_failure;
  fvv_bytes layouts; /* followed_tiles: the layout of a group that was decoded last, of each track */
  fvv_bytes environment_payload; /* of the BACK chunk that was read last, and its content */
  fvv_environment environment;
  uint64_t environment_chunk; /* its offset; 0: none */
};

/* The chunk that fvv_stream_environment decodes. FVV_END: there is none. */
FVV_MUST_USE fvv_status fvv_stream_find_environment(fvv_stream *stream, size_t group, uint16_t track,
                                                    const fvv_chunk_info **chunk, fvv_diagnostic *diagnostic);
void fvv_stream_release_environment(fvv_stream *stream);

#endif
