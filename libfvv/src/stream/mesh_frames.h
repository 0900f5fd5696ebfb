/* stream/mesh_frames.h: mesh chunks of one track in order, key frames and the delta frames behind them. */
#ifndef FVV_STREAM_MESH_FRAMES_H
#define FVV_STREAM_MESH_FRAMES_H

#include "fvv/container.h"
#include "fvv/mesh.h"

/* Zero-initialise; release with fvv_mesh_frames_reset. */
typedef struct fvv_mesh_frames {
  fvv_mesh key;                /* without positions: none */
  fvv_mesh_sequence *sequence; /* NULL until a delta frame comes: all-key streams need none */
} fvv_mesh_frames;

void fvv_mesh_frames_reset(fvv_mesh_frames *frames);

/* The profile of a chunk and its key flag say the same (FVV-3017). */
FVV_MUST_USE fvv_status fvv_mesh_frames_check_flag(const fvv_mesh_header *header, int key,
                                                   fvv_diagnostic *diagnostic);

/* Decodes the next chunk, key or not. Offsets of diagnostics are relative to the payload. On error the frames
 * are reset: up to the next key frame nothing can be decoded. */
FVV_MUST_USE fvv_status fvv_mesh_frames_add(fvv_mesh_frames *frames, const uint8_t *payload, size_t size,
                                            int key, const fvv_limits *limits, const fvv_allocator *allocator,
                                            fvv_diagnostic *diagnostic);

/* The frame that was added last; NULL before the first. Belongs to frames, until the next add or reset. */
const fvv_mesh *fvv_mesh_frames_current(const fvv_mesh_frames *frames);

#endif
