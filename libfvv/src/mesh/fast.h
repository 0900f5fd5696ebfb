/* mesh/fast.h: fast meshes, which meshoptimizer codes (clause 8.11). */
#ifndef FVV_MESH_FAST_H
#define FVV_MESH_FAST_H

#include "fvv/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The data of a fast mesh from outside is measured and walked before meshoptimizer sees
 * it (clause 8.11). */

/* Bytes of the number before the vertex stream: its size. */
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

/* The data of a fast mesh becomes arrays (clause 8.11). */

/* Decodes data, header->data_size bytes, into the arrays of mesh, which have room for the counts of header.
 * Texture coordinates take a block of 20 bytes a vertex from the mesh's allocator for the while. Indices,
 * positions and texture indices may be out of range. */
FVV_MUST_USE fvv_status fvv_fast_decode(const uint8_t *data, const fvv_mesh_header *header, fvv_mesh *mesh,
                                        fvv_diagnostic *diagnostic);

/* Meshoptimizer from C. Everything that knows this library is behind these functions; no
 * exception leaves them. The encoder allocates by operator new and not by the caller's allocator, the
 * decoders allocate nothing. */

/* Appends the data of a fast mesh to bytes (clause 8.11): faces in an order that comes back to vertices
 * soon, vertices in the order of their first use. The mesh obeys the rules of clause 8.3. */
FVV_MUST_USE fvv_status fvv_fast_encode(const fvv_mesh *mesh, fvv_bytes *bytes, fvv_diagnostic *diagnostic);

/* 1, or 0 when the stream does not decode or not to its last byte. vertices: count x stride bytes, in the
 * order of bytes of the stream. faces: count x 3, indices of any value. */
int fvv_fast_decode_vertices(const uint8_t *data, size_t size, size_t stride, uint32_t count, void *vertices);
int fvv_fast_decode_faces(const uint8_t *data, size_t size, uint32_t count, uint32_t *faces);

#ifdef __cplusplus
}
#endif
#endif
