/* mesh/normals.h: normals: as indices on the octahedron, and computed from faces. */
#ifndef FVV_MESH_NORMALS_H
#define FVV_MESH_NORMALS_H

#include "fvv/mesh.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Unit vectors as two integers (clause 8.12). The sphere is mapped to an octahedron and
 * that unfolded to a square (Cigolle et al., "A survey of efficient representations for independent unit
 * vectors", JCGT 3(2), 2014); a square of an odd number of steps has the axes on its grid. */

/* The largest index at that many bits, 2 to FVV_NORMAL_BITS_MAX. */
static inline uint32_t fvv_octahedral_most(unsigned bits) {
  return (UINT32_C(1) << bits) - 2;
}

/* index: two indices, each up to fvv_octahedral_most -> vector, unit length. Three quotients, correctly
 * rounded: the same bits everywhere. */
void fvv_octahedral_vector(unsigned bits, const uint32_t index[2], double vector[3]);

/* The index whose vector is nearest by angle. vector: of any length, finite, not zero, components of
 * magnitudes from 2^-500 to 2^500 or 0. Directions that have several indices, on the rim of the square, get
 * one. */
void fvv_octahedral_index(unsigned bits, const double vector[3], uint32_t index[2]);

/* Normals from faces, and how sent ones follow the faces of a moving mesh (clause 8.12). */

/* For each vertex the unit normal of the faces that use it, zero where their areas cancel: vertex_count x 3.
 * first: for each vertex the one whose faces count as its own too, first of several on a point; NULL: none is
 * joined. The mesh has passed fvv_mesh_check. */
void fvv_normals_of_faces(const fvv_mesh *mesh, const uint32_t *first, double *normals);

/* A sent normal, as a unit vector, turned by the least rotation that takes before to after: unit normals of
 * the vertex's own faces in the key mesh and now, or zero. Returns 0 when that is not known and the normal
 * stays as it was sent. */
int fvv_normal_turn(const double before[3], const double after[3], double normal[3]);

#ifdef __cplusplus
}
#endif
#endif
