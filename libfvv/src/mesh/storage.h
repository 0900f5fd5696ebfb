/* mesh/storage.h: the arrays of a mesh, by its counts. */
#ifndef FVV_MESH_STORAGE_H
#define FVV_MESH_STORAGE_H

#include "fvv/mesh.h"

/* Allocates positions, faces and, with texture_bits, texture for the counts of mesh from its allocator. The
 * arrays are not filled. 1, or 0 when memory is lacking; fvv_mesh_free in either case. */
int fvv_mesh_allocate(fvv_mesh *mesh);

#endif
