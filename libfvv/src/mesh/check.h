/* mesh/check.h: the rules that every mesh on the lattice keeps, whatever it was coded with (clause 8.1, 8.3).
 */
#ifndef FVV_MESH_CHECK_H
#define FVV_MESH_CHECK_H

#include "fvv/mesh.h"

/* Whose mesh is looked at: decides status and where the diagnostic points. */
typedef enum fvv_mesh_origin {
  FVV_MESH_FROM_CALLER,
  FVV_MESH_FROM_RAW,
  FVV_MESH_FROM_BITSTREAM
} fvv_mesh_origin;

/* Positions within the lattice, texture indices within 0 to 2^texture_bits, normal
 * indices within 0 to 2^normal_bits - 2, face indices in range, three
 * different ones a face, no vertex unused. */
FVV_MUST_USE fvv_status fvv_mesh_check(const fvv_mesh *mesh, fvv_mesh_origin origin,
                                       const fvv_allocator *allocator, fvv_diagnostic *diagnostic);

#endif
