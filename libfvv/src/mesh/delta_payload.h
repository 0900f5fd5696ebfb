/* mesh/delta_payload.h: what a delta payload says of its levels (clause 8.7). */
#ifndef FVV_MESH_DELTA_PAYLOAD_H
#define FVV_MESH_DELTA_PAYLOAD_H

#include "mesh/sequence.h"

typedef struct fvv_delta_level {
  uint32_t step; /* of residuals, in quarters of the lattice's step */
  int64_t width; /* of states for which no residual is sent; the encoder's */
  size_t size;   /* bytes; 0: no vertex of it has a residual */
  size_t offset; /* of the first byte in the payload */
} fvv_delta_level;

typedef struct fvv_delta_frame {
  fvv_delta_level level[FVV_MESH_LEVELS_MAX];
} fvv_delta_frame;

/* FVV_OK, or the diagnostic tells what does not fit. */
FVV_MUST_USE fvv_status fvv_delta_read_header(const fvv_mesh_sequence *s, const uint8_t *payload, size_t size,
                                              fvv_delta_frame *frame, fvv_diagnostic *diagnostic);

#endif
