/* mesh/storage.h: the arrays of a mesh, by its counts. */
#ifndef FVV_MESH_STORAGE_H
#define FVV_MESH_STORAGE_H

#include "fvv/mesh.h"

/* Allocates positions, faces and, with texture_bits, texture, with normal_bits, normals for the counts of
 * mesh from its allocator. The arrays are not filled. 1, or 0 when memory is lacking; fvv_mesh_free in either
 * case. */
int fvv_mesh_allocate(fvv_mesh *mesh);

/* The attribute bits of a MESH header (clause 8.3). */
static inline uint8_t fvv_mesh_attributes(const fvv_mesh *mesh) {
  return (uint8_t)((mesh->texture ? FVV_MESH_HAS_TEXTURE : 0) | (mesh->normals ? FVV_MESH_HAS_NORMALS : 0));
}

/* FVV_OK or FVV_ERROR_MEMORY, then *copy is empty. allocator NULL: malloc. */
FVV_MUST_USE fvv_status fvv_mesh_copy(const fvv_mesh *mesh, const fvv_allocator *allocator, fvv_mesh *copy);

#endif
