/* mesh/fast_streams.h: the data of a fast mesh from outside is measured and walked before meshoptimizer sees
 * it (clause 8.11). */
#ifndef FVV_MESH_FAST_STREAMS_H
#define FVV_MESH_FAST_STREAMS_H

#include "fvv/mesh.h"

/* Bytes of the number in front of the vertex stream: its size. */
#define FVV_FAST_HEADER_SIZE 4
/* First bytes: vertex codec version 0, index codec version 1. */
#define FVV_FAST_VERTEX_CODEC 0xa0
#define FVV_FAST_INDEX_CODEC 0xe1
/* Bytes of a vertex: x y z, then u v with texture coordinates, then the normal index with normals. */
#define FVV_FAST_POSITION 12
#define FVV_FAST_PAIR 8
static inline size_t fvv_fast_stride(int texture, int normals) {
  return FVV_FAST_POSITION + (texture ? FVV_FAST_PAIR : 0) + (normals ? FVV_FAST_PAIR : 0);
}

/* Both borrow from the payload. */
typedef struct fvv_fast_streams {
  const uint8_t *vertices, *faces;
  size_t vertices_size, faces_size;
} fvv_fast_streams;

/* Offsets in diagnostics count from the MESH payload's beginning, which lies FVV_MESH_SIZE before data. */

/* Finds the streams in data, header->data_size bytes, and holds their sizes against the counts: what passes
 * has at most 5.4 vertices and 1 face a byte. */
FVV_MUST_USE fvv_status fvv_fast_split(const uint8_t *data, const fvv_mesh_header *header,
                                       fvv_fast_streams *streams, fvv_diagnostic *diagnostic);

/* Of streams that were split: versions, what surrounds the deltas of the vertices, and the index stream from
 * end to end. Which vertices the faces have, and what is at them, is not looked at. */
FVV_MUST_USE fvv_status fvv_fast_check(const fvv_fast_streams *streams, const fvv_mesh_header *header,
                                       fvv_diagnostic *diagnostic);

#endif
