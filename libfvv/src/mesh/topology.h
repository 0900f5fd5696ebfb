/* mesh/topology.h: what faces share. Works on bare index triples. */
#ifndef FVV_MESH_TOPOLOGY_H
#define FVV_MESH_TOPOLOGY_H

#include "fvv/types.h"

/* Edges of a list of faces. Half-edge 3 * f + c runs from corner c of face f to the next corner.
 * twin: the one other half-edge of a manifold edge, FVV_NO_TWIN when the edge has one face or more than two.
 * group: union-find forest over faces, joined where they share an edge of any kind. */
typedef struct fvv_topology {
  uint32_t *twin;  /* 3 * face_count */
  uint32_t *group; /* face_count */
  uint32_t face_count;
  uint32_t boundary_edges;
  uint32_t nonmanifold_edges;
  fvv_allocator allocator;
} fvv_topology;

#define FVV_NO_TWIN UINT32_MAX

/* FVV_OK or FVV_ERROR_MEMORY; free in either case. face_count < 2^30. */
FVV_MUST_USE fvv_status fvv_topology_build(const uint32_t *faces, uint32_t face_count,
                                           const fvv_allocator *allocator, fvv_topology *topology);
void fvv_topology_free(fvv_topology *topology);

/* The face that represents the group of this one: the lowest of the group. */
uint32_t fvv_topology_group(const fvv_topology *topology, uint32_t face);

/* Turns faces in place so that twins run in opposite directions wherever that is possible, and counts them.
 * Within each set of faces joined over manifold edges the smaller part is turned, on a tie the part without
 * the lowest face. Two parts that disagree with each other along a small part of their borders only, as
 * bodies that touch do, both stay. A set that is not orientable (Moebius) keeps a seam. */
FVV_MUST_USE fvv_status fvv_topology_orient(const fvv_topology *topology, uint32_t *faces, uint32_t *flipped);

#endif
