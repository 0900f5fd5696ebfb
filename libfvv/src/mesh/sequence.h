/* mesh/sequence.h: the state that coder and decoder of delta frames share, and the model of clause 8.9 by
 * which both predict. Everything a frame changes is here; payloads are not known. */
#ifndef FVV_MESH_SEQUENCE_H
#define FVV_MESH_SEQUENCE_H

#include "base/range_coder.h"
#include "base/shift.h"
#include "mesh/delta_hierarchy.h"

enum {
  FVV_DELTA_STEP_MAX = 65535,
  FVV_DELTA_MAGNITUDE_BITS = 30, /* a residual's magnitude is below 2^30 */
  FVV_DELTA_REMEMBERED = 15,     /* magnitudes are remembered up to this */
  FVV_DELTA_AROUND = 4,          /* nodes of a stencil whose residuals choose the context */
  FVV_DELTA_AROUND_CLASSES = 6,
  FVV_DELTA_CLASSES = 3
};

/* Adaptive probabilities of one level; kept from frame to frame. */
typedef struct fvv_delta_model {
  /* Residual is not 0: by axis, residuals around, that of the frame before, those of the axes before. */
  fvv_probability some[3][FVV_DELTA_AROUND_CLASSES][FVV_DELTA_CLASSES][FVV_DELTA_CLASSES];
  /* Magnitude, Exp-Golomb: one more digit follows, and the first digit behind the leading one. */
  fvv_probability more[FVV_DELTA_AROUND_CLASSES][FVV_DELTA_MAGNITUDE_BITS];
  fvv_probability first[FVV_DELTA_MAGNITUDE_BITS];
} fvv_delta_model;

/* Magnitudes of the residuals of x, y, z, each up to FVV_DELTA_REMEMBERED: bytes of one number, so that those
 * of several vertices add up at once. */
typedef uint32_t fvv_delta_magnitudes;

struct fvv_mesh_sequence {
  fvv_allocator allocator;
  fvv_delta_hierarchy hierarchy;
  fvv_mesh mesh;                      /* the current frame; faces and texture of the key */
  int32_t *place;                     /* the current frame's positions in coding order, x 3 */
  int32_t *motion;                    /* from the frame before, in coding order, x 3 */
  fvv_delta_magnitudes *now, *before; /* of this frame and the one before, in coding order */
  fvv_delta_model *models;            /* one a level */
  uint32_t frame;                     /* 0: the key */
  uint32_t exact_levels;              /* that agree with the encoder's */
  int broken;                         /* a frame failed: nothing that follows can be told */
};

/* What interpolation gives for a vertex, kept inside the lattice: motion from the frame before. */
static inline void fvv_delta_predict(const struct fvv_mesh_sequence *s, uint32_t place, int32_t motion[3]) {
  const fvv_delta_stencil *stencil = &s->hierarchy.stencils[place];
  int64_t sum[3] = {0, 0, 0};
  for (int i = 0; i < FVV_DELTA_NEIGHBOURS; i++) {
    const int32_t *m = s->motion + 3 * (size_t)stencil->node[i];
    for (int a = 0; a < 3; a++) sum[a] += (int64_t)stencil->weight[i] * m[a];
  }
  for (int a = 0; a < 3; a++) {
    const int64_t half = INT64_C(1) << (FVV_DELTA_WEIGHT_BITS - 1);
    const int64_t from = s->place[3 * (size_t)place + (size_t)a];
    int64_t to = from + fvv_shift_right(sum[a] + half, FVV_DELTA_WEIGHT_BITS);
    if (to > FVV_LATTICE_MAX) to = FVV_LATTICE_MAX;
    if (to < -FVV_LATTICE_MAX) to = -FVV_LATTICE_MAX;
    motion[a] = (int32_t)(to - from);
  }
}

/* The sums of magnitudes around a vertex, as bytes: at most 4 * 15 each. */
static inline fvv_delta_magnitudes fvv_delta_around(const struct fvv_mesh_sequence *s, uint32_t place) {
  const fvv_delta_stencil *stencil = &s->hierarchy.stencils[place];
  fvv_delta_magnitudes sum = 0;
  for (int i = 0; i < FVV_DELTA_AROUND; i++)
    if (stencil->weight[i]) sum += s->now[stencil->node[i]];
  return sum;
}

static inline uint32_t fvv_delta_around_class(fvv_delta_magnitudes around, int axis) {
  const uint32_t sum = around >> (8 * axis) & 255;
  return sum < 3 ? sum : sum < 5 ? 3 : sum < 9 ? 4 : 5;
}
static inline uint32_t fvv_delta_class(uint32_t magnitude) {
  return magnitude < FVV_DELTA_CLASSES ? magnitude : FVV_DELTA_CLASSES - 1;
}
static inline fvv_delta_magnitudes fvv_delta_remember(uint32_t magnitude, int axis) {
  return (magnitude < FVV_DELTA_REMEMBERED ? magnitude : FVV_DELTA_REMEMBERED) << (8 * axis);
}

/* First vertex of a level in coding order. */
static inline uint32_t fvv_delta_level_begin(const struct fvv_mesh_sequence *s, uint32_t level) {
  return level ? s->hierarchy.level_end[level - 1] : 0;
}

/* A level without residuals: all vertices of it take their prediction. */
void fvv_delta_follow(struct fvv_mesh_sequence *sequence, uint32_t level);

/* The frame is done: positions in canonical order, residuals become those of the frame before. */
void fvv_delta_end_frame(struct fvv_mesh_sequence *sequence);

#endif
