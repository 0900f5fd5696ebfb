/* mesh/delta_hierarchy.h: the vertices of a key mesh, coarse to fine, and from which earlier ones the motion
 * of each is interpolated (clause 8.8). Nearness is that along edges: two legs that touch stay two. Integers
 * only: every machine finds the same. Knows no bytes.
 *
 * Sources: a hierarchy by taking independent sets of vertices out (Kirkpatrick, 1983), each contracted into
 * its nearest neighbour (Hoppe, "Progressive meshes", 1996). */
#ifndef FVV_MESH_DELTA_HIERARCHY_H
#define FVV_MESH_DELTA_HIERARCHY_H

#include "fvv/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  FVV_DELTA_NEIGHBOURS = 6,
  FVV_DELTA_DEGREE_MAX = 8, /* neighbours of a vertex that a pass may take out */
  FVV_DELTA_SURVIVORS = 24, /* vertices with neighbours that are left in peace */
  FVV_DELTA_SHARE = 6,      /* a pass takes at least a sixth of the vertices that have neighbours */
  FVV_DELTA_PASSES_MAX = 48,
  FVV_DELTA_PASSES_A_LEVEL = 3, /* which hold two thirds of the vertices that were left */
  FVV_DELTA_WEIGHT_BITS = 16    /* weights add up to 2^16 */
};

/* motion = sum of weight * motion of node, in 2^-16. Nodes are places in coding order, nearest first; unused
 * ones have weight 0 and place 0. A weight is within +-2^21. */
typedef struct fvv_delta_stencil {
  uint32_t node[FVV_DELTA_NEIGHBOURS];
  int32_t weight[FVV_DELTA_NEIGHBOURS];
} fvv_delta_stencil;

/* Level k is places level_end[k - 1] (0 for the first) to level_end[k] - 1 of the coding order. Nodes of a
 * stencil stand before it in coding order; only the first stencil of all is 0. */
typedef struct fvv_delta_hierarchy {
  uint32_t *order; /* place -> vertex */
  fvv_delta_stencil *stencils;
  uint32_t vertex_count, level_count;
  uint32_t level_end[FVV_MESH_LEVELS_MAX];
  fvv_allocator allocator;
} fvv_delta_hierarchy;

/* key: positions within the lattice, at least one vertex, faces that index them. FVV_OK or FVV_ERROR_MEMORY;
 * free in either case. At most FVV_DELTA_PASSES_MAX walks over the edges, which on a surface shrink by a
 * third with each; 90 bytes a vertex and 48 a face while it works. */
FVV_MUST_USE fvv_status fvv_delta_hierarchy_build(const fvv_mesh *key, const fvv_allocator *allocator,
                                                  fvv_delta_hierarchy *hierarchy);
void fvv_delta_hierarchy_free(fvv_delta_hierarchy *hierarchy);

/* Weights of count (1 to FVV_DELTA_NEIGHBOURS) points at offsets from the vertex, each within +-2^9, in
 * 2^-16. Inverse squared distances, corrected so that motion that is linear in space comes out nearly as it
 * is: moving least squares (Lancaster and Salkauskas, 1981) with a ridge of 1/32 of the spread. */
void fvv_delta_weights(int32_t offsets[][3], uint32_t count, int32_t *weights);

#ifdef __cplusplus
}
#endif
#endif
