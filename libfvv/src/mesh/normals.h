/* mesh/normals.h: normals from faces, and how sent ones follow the faces of a moving mesh (clause 8.12). */
#ifndef FVV_MESH_NORMALS_H
#define FVV_MESH_NORMALS_H

#include "fvv/mesh.h"

/* For each vertex the unit normal of the faces that use it, zero where their areas cancel: vertex_count x 3.
 * first: for each vertex the one whose faces count as its own too, first of several on a point; NULL: none is
 * joined. The mesh has passed fvv_mesh_check. */
void fvv_normals_of_faces(const fvv_mesh *mesh, const uint32_t *first, double *normals);

/* A sent normal, as a unit vector, turned by the least rotation that takes before to after: unit normals of
 * the vertex's own faces in the key mesh and now, or zero. Answers 0 when there is no telling and the normal
 * stays as it was sent. */
int fvv_normal_turn(const double before[3], const double after[3], double normal[3]);

#endif
