/* mesh/octahedral.h: unit vectors as two integers (clause 8.12). The sphere is mapped to an octahedron and
 * that unfolded to a square (Cigolle et al., "A survey of efficient representations for independent unit
 * vectors", JCGT 3(2), 2014); a square of an odd number of steps has the axes on its grid. Knows no meshes.
 */
#ifndef FVV_MESH_OCTAHEDRAL_H
#define FVV_MESH_OCTAHEDRAL_H

#include <stdint.h>

/* The largest index at so many bits, 2 to FVV_NORMAL_BITS_MAX. */
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

#endif
