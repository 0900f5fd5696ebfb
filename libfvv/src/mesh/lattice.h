/* mesh/lattice.h: metres -> lattice index. The way back is public (fvv/mesh.h). */
#ifndef FVV_MESH_LATTICE_H
#define FVV_MESH_LATTICE_H

#include <stdint.h>

/* 1 and *index, the integer nearest to (x - origin) / step, ties to the even one (clause 8.2); 0 when that
 * lies outside +-FVV_LATTICE_MAX. x must be finite. Does not depend on the rounding mode. */
int fvv_lattice_quantise(double x, double origin, double step, int32_t *index);

#endif
