/* From what is coded to values of vertices, which players interpolate (clause 17.4). */
#include <string.h>

#include "fvv/visibility.h"

/* Nothing around it has a bit: a little less than half, so that other corners decide. */
enum { UNKNOWN_SHARE = 127 };

static uint8_t share_of(uint32_t seen, uint32_t hidden) {
  const uint64_t all = (uint64_t)seen + hidden;
  return all ? (uint8_t)((255 * (uint64_t)seen + all / 2) / all) : UNKNOWN_SHARE;
}

void fvv_visibility_shares(const fvv_mesh *mesh, uint8_t domain, const uint8_t *states, uint32_t *counts,
                           uint8_t *shares) {
  if (domain != FVV_VISIBILITY_FACES) {
    /* By state: averse, then hidden and seen in turns, ever nearer to a half. */
    static const uint8_t of_state[] = {UNKNOWN_SHARE, 0, 255, 85, 170, 113, 142};
    for (uint32_t v = 0; v < mesh->vertex_count; v++)
      shares[v] = states[v] || domain == FVV_VISIBILITY_SHARES ? of_state[states[v]] : 0;
    return;
  }
  if (mesh->vertex_count) memset(counts, 0, 2 * (size_t)mesh->vertex_count * sizeof *counts);
  for (uint32_t f = 0; f < mesh->face_count; f++) {
    if (states[f] == FVV_ELEMENT_AVERSE) continue;
    const size_t hidden = states[f] == FVV_ELEMENT_HIDDEN;
    for (size_t k = 0; k < 3; k++) counts[2 * (size_t)mesh->faces[3 * (size_t)f + k] + hidden]++;
  }
  for (uint32_t v = 0; v < mesh->vertex_count; v++)
    shares[v] = share_of(counts[2 * (size_t)v], counts[2 * (size_t)v + 1]);
}
