/* mesh/lattice.h: metres -> lattice index. The way back is public (fvv/mesh.h). */
#ifndef FVV_MESH_LATTICE_H
#define FVV_MESH_LATTICE_H

#include <stddef.h>
#include <stdint.h>

#include "fvv/types.h"

/* 1 and *index, the integer nearest to (x - origin) / step, ties to the even one (clause 8.2); 0 when that
 * lies outside +-FVV_LATTICE_MAX. x must be finite. Does not depend on the rounding mode. */
int fvv_lattice_quantise(double x, double origin, double step, int32_t *index);

/* The lattice point of vertex number vertex of metres (x 3). FVV_ERROR_INPUT names the vertex, its coordinate
 * and what is wrong with it: not finite, or outside the lattice. */
fvv_status fvv_lattice_point(const double origin[3], double step, const double *metres, size_t vertex,
                             int32_t point[3], fvv_diagnostic *diagnostic);

/* What messages call a number that is not finite. */
const char *fvv_lattice_not_finite(double x);

#endif
