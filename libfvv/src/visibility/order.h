/* visibility/order.h: in which order elements are coded, and what lies around each (clause 17.3). Knows
 * faces, no positions and no bits.
 *
 * Elements touch places: a face its three vertices, a vertex the faces that use it. Two counters at each
 * place tell an element what was coded around it. */
#ifndef FVV_VISIBILITY_ORDER_H
#define FVV_VISIBILITY_ORDER_H

#include "fvv/visibility.h"

/* How many elements that touch a place have been coded as hidden and as seen. */
typedef struct fvv_visibility_place {
  uint32_t count[2];
} fvv_visibility_place;

struct fvv_visibility_order {
  fvv_allocator allocator;
  uint8_t domain;
  uint32_t vertex_count, face_count;
  uint32_t element_count, place_count;
  uint32_t *elements; /* in order of coding */
  /* Elements that are vertices: v touches faces touched[first[v]] to touched[first[v + 1] - 1], rising. */
  uint32_t *first, *touched;
  fvv_visibility_place *places; /* scratch */
};

#endif
