/* mesh/draco_check.h: a Draco bitstream from outside is walked before Draco sees it (clause 8.4). */
#ifndef FVV_MESH_DRACO_CHECK_H
#define FVV_MESH_DRACO_CHECK_H

#include "fvv/types.h"

/* Vertices and faces that one byte of bitstream may carry. Hulls have 1 to 4 faces a byte, the smoothest
 * regular height field on a coarse lattice had 8. Valence edgebreaker codes a flat grid in next to nothing,
 * up to 2,500 faces a byte; standard edgebreaker never has more than 4.6, so that every mesh can be coded
 * within this. */
#define FVV_DRACO_DENSITY 16

/* Of vertices and of faces: Draco counts corners and coordinates in int. */
#define FVV_DRACO_COUNT_MAX (INT32_MAX / 3)

typedef struct fvv_draco_counts {
  uint32_t vertices;
  uint32_t faces;
} fvv_draco_counts;

static inline int fvv_draco_dense_enough(size_t size, fvv_draco_counts counts) {
  return counts.vertices <= FVV_DRACO_DENSITY * (uint64_t)size &&
         counts.faces <= FVV_DRACO_DENSITY * (uint64_t)size;
}

/* Offsets in diagnostics count from the MESH payload's beginning, which lies FVV_MESH_SIZE before data. */

/* Reads file header and counts alone. */
FVV_MUST_USE fvv_status fvv_draco_read_counts(const uint8_t *data, size_t size, fvv_draco_counts *counts,
                                              fvv_diagnostic *diagnostic);

/* The symbols of valence edgebreaker in the order in which a decoder uses them, in Draco's numbering. */
typedef struct fvv_draco_symbols {
  uint8_t *values; /* count + 1 bytes of the allocator; NULL if the bitstream has none */
  uint32_t count;
  size_t end; /* where the bytes of the symbols end */
} fvv_draco_symbols;

/* Walks the whole bitstream: FVV_OK says that it has the declared counts, one attribute of three int32, with
 * texture and normals (0 or not) one more of two int32 each, only parts that the counts bound, symbols that
 * Draco decodes in linear time, and no byte after. Values are not decoded: Draco may still find it wrong.
 * symbols: NULL, or receives the symbols, so that they need not be decoded again; on failure nothing. */
FVV_MUST_USE fvv_status fvv_draco_check(const uint8_t *data, size_t size, fvv_draco_counts declared,
                                        int texture, int normals, const fvv_allocator *allocator,
                                        fvv_draco_symbols *symbols, fvv_diagnostic *diagnostic);

#endif
