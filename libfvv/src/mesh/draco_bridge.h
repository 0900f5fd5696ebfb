/* mesh/draco_bridge.h: Draco from C. Everything that knows Draco's C++ is behind these two functions; no
 * exception leaves them. Draco allocates by operator new and not by the caller's allocator. */
#ifndef FVV_MESH_DRACO_BRIDGE_H
#define FVV_MESH_DRACO_BRIDGE_H

#include "fvv/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fvv_draco_coding {
  FVV_DRACO_BY_LEVEL,  /* the edgebreaker that Draco takes for this level and size */
  FVV_DRACO_STANDARD,  /* standard edgebreaker: at least a bit for every symbol */
  FVV_DRACO_SEQUENTIAL /* faces as they are, 3 bytes at least */
} fvv_draco_coding;

/* Appends the bitstream of a mesh to bytes: positions and, when it has them, texture and
 * normal indices. The mesh has at
 * least one face, its indices are in range. */
FVV_MUST_USE fvv_status fvv_draco_encode(const fvv_mesh *mesh, int level, fvv_draco_coding coding,
                                         fvv_bytes *bytes, fvv_diagnostic *diagnostic);

/* Decodes what fvv_draco_check let through into mesh->lattice, mesh->faces and, unless NULL, mesh->texture
 * and mesh->normals, which have room for the mesh's counts. Checks that Draco yields these counts, just these
 * attributes and no byte less than all. Says nothing about the values. */
FVV_MUST_USE fvv_status fvv_draco_decode(const uint8_t *data, size_t size, fvv_mesh *mesh,
                                         fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
