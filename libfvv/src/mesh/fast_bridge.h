/* mesh/fast_bridge.h: meshoptimizer from C. Everything that knows this library is behind these functions; no
 * exception leaves them. The encoder allocates by operator new and not by the caller's allocator, the
 * decoders allocate nothing. */
#ifndef FVV_MESH_FAST_BRIDGE_H
#define FVV_MESH_FAST_BRIDGE_H

#include "fvv/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

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
