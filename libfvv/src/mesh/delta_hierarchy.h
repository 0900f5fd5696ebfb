/* mesh/delta_hierarchy.h: the vertices of a key mesh, coarse to fine, and from which earlier ones the motion
 * of each is interpolated (clause 8.8). Integers only: every machine finds the same. Knows no bytes. */
#ifndef FVV_MESH_DELTA_HIERARCHY_H
#define FVV_MESH_DELTA_HIERARCHY_H

#include "fvv/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  FVV_DELTA_NEIGHBOURS = 6,
  FVV_DELTA_COARSEST =
      64, /* vertices that the first level has at least, where the mesh has three times as many */
  FVV_DELTA_WEIGHT_BITS = 16 /* weights add up to 2^16 */
};

/* motion = sum of weight * motion of node, in 2^-16. Nodes are places in coding order, nearest first; unused
 * ones have weight 0 and place 0. A weight is within +-2^21. */
typedef struct fvv_delta_stencil {
  uint32_t node[FVV_DELTA_NEIGHBOURS];
  int32_t weight[FVV_DELTA_NEIGHBOURS];
} fvv_delta_stencil;

/* Level k is places level_end[k - 1] (0 for the first) to level_end[k] - 1 of the coding order. Nodes of a
 * stencil belong to earlier levels; stencils of the first level are all 0. */
typedef struct fvv_delta_hierarchy {
  uint32_t *order; /* place -> vertex */
  fvv_delta_stencil *stencils;
  uint32_t vertex_count, level_count;
  /* The last level holds vertices on the points of earlier ones. */
  int has_twins;
  uint32_t level_end[FVV_MESH_LEVELS_MAX];
  fvv_allocator allocator;
} fvv_delta_hierarchy;

/* positions: vertex_count x 3, within the lattice. FVV_OK or FVV_ERROR_MEMORY; free in either case. Work is
 * bounded by some 100 steps a vertex and memory by 90 bytes a vertex, whatever the positions are. */
FVV_MUST_USE fvv_status fvv_delta_hierarchy_build(const int32_t *positions, uint32_t vertex_count,
                                                  const fvv_allocator *allocator,
                                                  fvv_delta_hierarchy *hierarchy);
void fvv_delta_hierarchy_free(fvv_delta_hierarchy *hierarchy);

/* Weights of count (1 to FVV_DELTA_NEIGHBOURS) points at offsets from the vertex, each within +-2^9, in
 * 2^-16. Inverse squared distances, corrected so that motion that is linear in space comes out nearly as it
 * is: moving least squares (Lancaster and Salkauskas, 1981) with a ridge of 1/8 of the spread. */
void fvv_delta_weights(int32_t offsets[][3], uint32_t count, int32_t *weights);

#ifdef __cplusplus
}
#endif
#endif
