/* stream/check_mesh.h: what the checker knows of a mesh track, and how it judges the next chunk of it. */
#ifndef FVV_STREAM_CHECK_MESH_H
#define FVV_STREAM_CHECK_MESH_H

#include "stream/mesh_frames.h"

/* Zero-initialise; reset frames in the end. */
typedef struct fvv_checked_mesh {
  uint64_t group; /* that is being read, counted from 1 */
  int has_first;  /* the first mesh of the group was seen: texture_bits and normal_bits are its own */
  uint8_t texture_bits, normal_bits;
  int64_t time; /* of the mesh that frames holds */
  int lost;     /* a frame of the group was wrong: delta frames behind it cannot be judged */
  fvv_mesh_frames frames;
} fvv_checked_mesh;

/* Judges an intact MESH chunk; with decode, its content too. header is filled as far as it is good. *whole
 * becomes 0 when a frame before this one is missing, which is no problem of its own. Offsets of diagnostics
 * are relative to the payload. */
FVV_MUST_USE fvv_status fvv_check_mesh(fvv_checked_mesh *mesh, const fvv_event *event, uint64_t group,
                                       int decode, const fvv_limits *limits, const fvv_allocator *allocator,
                                       fvv_mesh_header *header, int *whole, fvv_diagnostic *diagnostic);

#endif
