/* fvv/colours.h: the colour of a mesh's surface at low resolution, coded: what is shown where no camera sees
 * the surface, or where there are no pictures. Spec: spec/fvv.md clause 19.
 *
 * Space is divided in cubic cells, aligned with the lattice. Each cell that contains a vertex of the decoded
 * mesh has one colour; which cells these are follows from the mesh and is not sent. The colour of a vertex is
 * interpolated from the cells around it, in integers: the same bytes on every machine. */
#ifndef FVV_COLOURS_H
#define FVV_COLOURS_H

#include "fvv/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
  FVV_COLOURS_MAX_STEP = 64,       /* of luma_step and chroma_step */
  FVV_COLOURS_MAX_CELL = 1 << 24,  /* lattice steps */
  FVV_COLOURS_MAX_CELLS = 1 << 16, /* of one mesh */
  FVV_COLOURS_MAX_EXTENT = 1022    /* cells on each axis, between the first and the last occupied one */
};

typedef struct fvv_colours_header {
  uint16_t mesh_track;            /* of the key mesh or patch at the same time */
  uint8_t luma_step, chroma_step; /* of Y, and of Co and Cg, in steps of 8 bits; 1 to FVV_COLOURS_MAX_STEP */
  uint32_t vertex_count;          /* of that mesh */
  uint32_t cell_size;             /* side of a cell in lattice steps, 1 to FVV_COLOURS_MAX_CELL */
  uint32_t cell_count;            /* cells that contain a vertex */
} fvv_colours_header;

/* Reads and checks the header of a COLR payload. limits NULL: defaults; the vertex count is checked against
 * them. On error *header is zero. */
FVV_API FVV_MUST_USE fvv_status fvv_colours_peek(const uint8_t *payload, size_t size,
                                                 const fvv_limits *limits, fvv_colours_header *header,
                                                 fvv_diagnostic *diagnostic);

/* Decodes a COLR payload for its key mesh, or for the patch of a patched frame. colours: receives R, G, B of
 * each vertex, display values, 3 * mesh->vertex_count bytes in decoded order, written only on FVV_OK. They
 * hold for the delta frames of that key mesh too, vertex by vertex. limits, allocator NULL: defaults. Safe
 * for hostile bytes: 4 bytes of memory a vertex and 128 a cell, of at most FVV_COLOURS_MAX_CELLS; released
 * before it returns. 0.5 ms for 17,500 vertices. FVV_ERROR_INVALID: the payload breaks a rule of clause 19.
 */
FVV_API FVV_MUST_USE fvv_status fvv_colours_decode(const uint8_t *payload, size_t size, const fvv_mesh *mesh,
                                                   const fvv_limits *limits, const fvv_allocator *allocator,
                                                   uint8_t *colours, fvv_diagnostic *diagnostic);

/* COLR payload; replaces what payload holds. header: mesh_track, steps and cell_size are read. mesh: the key
 * mesh or patch as decoders have it. colours: R, G, B of each vertex, display values. weights: for each
 * vertex how much its colour counts in its cell, or NULL: all count alike; where all of a cell are 0, all
 * count alike there. Cells are chosen so that the colours of vertices, interpolated, err least.
 * Deterministic. FVV_ERROR_INPUT: the mesh has more than FVV_COLOURS_MAX_CELLS cells of that size or extends
 * over more than FVV_COLOURS_MAX_EXTENT; larger ones may do. FVV_ERROR_ARGUMENT: a step or the size is out of
 * range. */
FVV_API FVV_MUST_USE fvv_status fvv_colours_encode(const fvv_mesh *mesh, const fvv_colours_header *header,
                                                   const uint8_t *colours, const uint8_t *weights,
                                                   const fvv_allocator *allocator, fvv_bytes *payload,
                                                   fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
