/* mesh/mesh.h: what all of this folder uses of a mesh: its lattice, its arrays, its rules. */
#ifndef FVV_MESH_MESH_H
#define FVV_MESH_MESH_H

#include "fvv/mesh.h"
#include "fvv/types.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Metres -> lattice index. The way back is public (fvv/mesh.h). */

/* 1 and *index, the integer nearest to (x - origin) / step, ties to the even one (clause 8.2); 0 when that
 * lies outside +-FVV_LATTICE_MAX. x must be finite. Does not depend on the rounding mode. */
int fvv_lattice_quantise(double x, double origin, double step, int32_t *index);

/* The lattice point of vertex number vertex of metres (x 3). FVV_ERROR_INPUT names the vertex, its coordinate
 * and what is wrong with it: not finite, or outside the lattice. */
fvv_status fvv_lattice_point(const double origin[3], double step, const double *metres, size_t vertex,
                             int32_t point[3], fvv_diagnostic *diagnostic);

/* What messages call a number that is not finite. */
const char *fvv_lattice_not_finite(double x);

/* The arrays of a mesh, by its counts. */

/* Allocates positions, faces and, with texture_bits, texture, with normal_bits, normals for the counts of
 * mesh from its allocator. The arrays are not filled. 1, or 0 when memory is lacking; fvv_mesh_free in either
 * case. */
int fvv_mesh_allocate(fvv_mesh *mesh);

/* A mesh of the profile follows others of its track: it does not decode alone. */
static inline int fvv_mesh_follows(uint8_t profile) {
  return profile == FVV_MESH_DELTA || profile == FVV_MESH_PATCHED;
}

/* The attribute bits of a MESH header (clause 8.3). */
static inline uint8_t fvv_mesh_attributes(const fvv_mesh *mesh) {
  return (uint8_t)((mesh->texture ? FVV_MESH_HAS_TEXTURE : 0) | (mesh->normals ? FVV_MESH_HAS_NORMALS : 0));
}

/* FVV_OK or FVV_ERROR_MEMORY, then *copy is empty. allocator NULL: malloc. */
FVV_MUST_USE fvv_status fvv_mesh_copy(const fvv_mesh *mesh, const fvv_allocator *allocator, fvv_mesh *copy);

/* The rules that every mesh on the lattice keeps, whatever it was coded with (clause 8.1, 8.3). */

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

#ifdef __cplusplus
}
#endif
#endif
