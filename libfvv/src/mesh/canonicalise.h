/* mesh/canonicalise.h: what the steps of the canonicaliser share. */
#ifndef FVV_MESH_CANONICALISE_H
#define FVV_MESH_CANONICALISE_H

#include "fvv/mesh.h"

#define FVV_EMPTY_SLOT UINT32_MAX

/* All that the steps share. points and faces shrink from step to step; the capacities stay what was
 * allocated. */
typedef struct fvv_canonicalising {
  const fvv_mesh_source *source;
  fvv_mesh_options options;
  fvv_allocator allocator;
  fvv_mesh_report report;
  fvv_diagnostic *diagnostic;
  const int32_t *const *later; /* of the run: lattice indices of the source vertices in frames 1 and up */
  size_t later_count;
  uint32_t *map;     /* the caller's: source vertex -> vertex of the mesh; NULL: not wanted */
  int32_t *points;   /* 3 * point_count of 3 * source->vertex_count */
  uint32_t *origins; /* point -> the first source vertex that lies there; NULL without later frames */
  uint32_t *renamed; /* source vertex -> vertex; without attributes a vertex is a point */
  uint32_t *faces;   /* points: 3 * face_count of 3 * source->face_count */
  uint32_t *texture; /* of vertices: 2 * vertex_count of 2 * source->vertex_count; NULL: none is wanted */
  uint32_t *normals; /* indices, like texture */
  uint32_t *placed;  /* vertex -> point; NULL: no attributes, texture or normals, are wanted */
  uint32_t *corners; /* the faces' vertices, as long as faces; like placed */
  uint32_t *table;   /* slots of whichever step is running */
  uint64_t slots;
  uint32_t point_count;
  uint32_t vertex_count;
  uint32_t face_count;
} fvv_canonicalising;

fvv_status fvv_canonicalise_no_memory(fvv_canonicalising *w);

/* A cleared table for so many entries, in place of the former one. */
FVV_MUST_USE fvv_status fvv_canonicalise_table(fvv_canonicalising *w, uint64_t entries);

/* Quantises every source vertex and fills points, renamed and, with attributes, texture, normals and placed:
 * the first vertex of several that are alike stands for all. Vertices are numbered as they come first. */
FVV_MUST_USE fvv_status fvv_canonicalise_weld(fvv_canonicalising *w);

#endif
