/* stream/visibility_frames.h: visibility chunks of one track in order, each with its mesh. */
#ifndef FVV_STREAM_VISIBILITY_FRAMES_H
#define FVV_STREAM_VISIBILITY_FRAMES_H

#include "fvv/stream.h"

/* Zero-initialise; release with fvv_visibility_frames_reset. */
typedef struct fvv_visibility_frames {
  fvv_visibility current; /* header.camera_count 0: none */
  fvv_allocator allocator;
  fvv_visibility_order *order; /* of faces; kept as long as they stay */
  uint32_t *faces;
  uint32_t vertex_count, face_count;
} fvv_visibility_frames;

void fvv_visibility_frames_reset(fvv_visibility_frames *frames);

/* Checks what can be checked without the mesh: header, table, key flag and number, cameras. */
FVV_MUST_USE fvv_status fvv_visibility_frames_check(const fvv_visibility_frames *frames,
                                                    const uint8_t *payload, size_t size, int key,
                                                    const fvv_configuration *configuration,
                                                    const fvv_limits *limits, fvv_visibility_header *header,
                                                    fvv_diagnostic *diagnostic);

/* Decodes the next chunk, key or not, for all of its cameras. mesh: that of its time; NULL: there is none.
 * calibration: of the cameras that move, at its time; NULL: there is none. Offsets of diagnostics are
 * relative to the payload. On error the frames are reset: up to the next key chunk nothing can be decoded. */
FVV_MUST_USE fvv_status fvv_visibility_frames_add(fvv_visibility_frames *frames, const uint8_t *payload,
                                                  size_t size, int key, const fvv_mesh *mesh,
                                                  const fvv_calibration *calibration,
                                                  const fvv_configuration *configuration,
                                                  const fvv_limits *limits, const fvv_allocator *allocator,
                                                  fvv_diagnostic *diagnostic);

#endif
