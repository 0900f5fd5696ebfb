/* mesh/draco_connectivity.h: what edgebreaker symbols will cost Draco's decoder, known before it starts. */
#ifndef FVV_MESH_DRACO_CONNECTIVITY_H
#define FVV_MESH_DRACO_CONNECTIVITY_H

#include "fvv/types.h"

/* Contexts of valence edgebreaker: valences up to 2, 3, 4, 5, 6, from 7 on. */
#define FVV_DRACO_CONTEXTS 6

/* A handle or a hole: the symbol source leaves an edge to which the S of symbol split is glued. Both count
 * from the last symbol backwards, as the encoder did. */
typedef struct fvv_draco_event {
  uint32_t source;
  uint32_t split;
  int right; /* of the two edges of the source's face that are not active: the right one */
} fvv_draco_event;

typedef struct fvv_draco_connectivity {
  uint32_t vertex_count;
  uint32_t symbol_count;
  uint32_t split_count; /* S among the symbols */
  uint32_t event_count;
  const fvv_draco_event *events;
  /* Standard: symbol_count of them in order. Valence: one less, for the first is an E; the run of context i
   * stands between begin[i] and end[i] and is used from its end. */
  const uint8_t *symbols;
  uint32_t begin[FVV_DRACO_CONTEXTS];
  uint32_t end[FVV_DRACO_CONTEXTS];
  int valence;
} fvv_draco_connectivity;

typedef enum fvv_draco_verdict {
  FVV_DRACO_SOUND,
  FVV_DRACO_BROKEN, /* the symbols do not fit each other or the counts */
  FVV_DRACO_NO_MEMORY
} fvv_draco_verdict;

/* Follows the symbols along the boundary. *steps: how many corners Draco will walk over besides its linear
 * work: around both sides of every S and around every vertex that it renumbers. */
fvv_draco_verdict fvv_draco_follow(const fvv_draco_connectivity *connectivity, const fvv_allocator *allocator,
                                   uint64_t *steps);

#endif
