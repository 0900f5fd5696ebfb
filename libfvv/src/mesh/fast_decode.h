/* mesh/fast_decode.h: the data of a fast mesh becomes arrays (clause 8.11). */
#ifndef FVV_MESH_FAST_DECODE_H
#define FVV_MESH_FAST_DECODE_H

#include "fvv/mesh.h"

/* Decodes data, header->data_size bytes, into the arrays of mesh, which have room for the counts of header.
 * Texture coordinates take a block of 20 bytes a vertex from the mesh's allocator for the while. Indices,
 * positions and texture indices may be out of range. */
FVV_MUST_USE fvv_status fvv_fast_decode(const uint8_t *data, const fvv_mesh_header *header, fvv_mesh *mesh,
                                        fvv_diagnostic *diagnostic);

#endif
