/* mesh/delta.h: delta frames: the hierarchy of a mesh, the state of a group of frames, and the levels of a
 * payload (clauses 8.7 to 8.9). */
#ifndef FVV_MESH_DELTA_H
#define FVV_MESH_DELTA_H

#include "base/checked.h"
#include "base/range_coder.h"
#include "fvv/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The vertices of a key mesh or of a patched one, coarse to fine, and from which earlier ones the motion
 * of each is interpolated (clause 8.8). Nearness is that along edges: two legs that touch stay two. Integers
 * only: every machine finds the same.
 *
 * Sources: a hierarchy by taking independent sets of vertices out (Kirkpatrick, 1983), each contracted into
 * its nearest neighbour (Hoppe, "Progressive meshes", 1996). */

/* The hierarchy's tables have twice as many slots, counted in 32 bits. */
#define FVV_DELTA_VERTICES_MAX (UINT32_C(1) << 30)

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
 * stencil are before it in coding order; only the first stencil of all is 0. */
typedef struct fvv_delta_hierarchy {
  uint32_t *order; /* place -> vertex */
  fvv_delta_stencil *stencils;
  uint32_t vertex_count, level_count;
  uint32_t points; /* places from it on are twins, the last level */
  uint32_t level_end[FVV_MESH_LEVELS_MAX];
  fvv_allocator allocator;
} fvv_delta_hierarchy;

/* mesh: positions within the lattice, at least one vertex, faces that index them. FVV_OK or FVV_ERROR_MEMORY;
 * free in either case. At most FVV_DELTA_PASSES_MAX walks over the edges, which on a surface shrink by a
 * third with each; 90 bytes a vertex and 48 a face while it works. */
FVV_MUST_USE fvv_status fvv_delta_hierarchy_build(const fvv_mesh *mesh, const fvv_allocator *allocator,
                                                  fvv_delta_hierarchy *hierarchy);
void fvv_delta_hierarchy_free(fvv_delta_hierarchy *hierarchy);

/* Weights of count (1 to FVV_DELTA_NEIGHBOURS) points at offsets from the vertex, each within +-2^9, in
 * 2^-16. Inverse squared distances, corrected so that motion that is linear in space is kept nearly as it
 * is: moving least squares (Lancaster and Salkauskas, 1981) with a ridge of 1/32 of the spread. */
void fvv_delta_weights(int32_t offsets[][3], uint32_t count, int32_t *weights);

/* The state that coder and decoder of delta frames share, and the model of clause 8.9 by
 * which both predict. Everything a frame changes is here. */

enum {
  FVV_DELTA_ERROR_MAX = 32767,
  FVV_DELTA_STEP_MAX = (1 << 18) - 1,
  FVV_DELTA_FRACTION_BITS = 2, /* states are positions in quarters of the lattice's step */
  FVV_DELTA_STATE_MAX = FVV_LATTICE_MAX * 4,
  FVV_DELTA_MAGNITUDE_BITS = 30, /* a residual's magnitude is below 2^30 */
  FVV_DELTA_REMEMBERED = 15,     /* magnitudes are remembered up to this */
  FVV_DELTA_AROUND = 4,          /* nodes of a stencil whose residuals choose the context */
  FVV_DELTA_AROUND_CLASSES = 6,
  FVV_DELTA_CLASSES = 3,
  FVV_DELTA_SIGNS = 3 /* none or balanced, positive, negative */
};

/* Adaptive probabilities of one level; kept from frame to frame. */
typedef struct fvv_delta_model {
  /* Residual is not 0: by axis, residuals around, that of the frame before, those of the axes before. */
  fvv_probability some[3][FVV_DELTA_AROUND_CLASSES][FVV_DELTA_CLASSES][FVV_DELTA_CLASSES];
  /* Magnitude, Exp-Golomb: one more digit follows, and the first digit after the leading one. */
  fvv_probability more[FVV_DELTA_AROUND_CLASSES][FVV_DELTA_MAGNITUDE_BITS];
  fvv_probability first[FVV_DELTA_MAGNITUDE_BITS];
  /* Residual is negative: by axis, the last residual of the vertex that was not 0, those around. */
  fvv_probability negative[3][FVV_DELTA_SIGNS][FVV_DELTA_SIGNS];
} fvv_delta_model;

/* The residuals of x, y, z of a vertex: bytes of one number, so that those of several add up at once. Bytes 0
 * to 2: magnitudes, each up to FVV_DELTA_REMEMBERED. Bytes 4 to 6: 1, and 1 more or less with the sign. */
typedef uint64_t fvv_delta_residuals;
#define FVV_DELTA_NO_RESIDUALS UINT64_C(0x01010100000000)

struct fvv_mesh_sequence {
  fvv_allocator allocator;
  fvv_delta_hierarchy hierarchy;
  fvv_mesh mesh;                     /* of the current frame */
  int32_t *place;                    /* the current frame's states in coding order, x 3 */
  int32_t *motion;                   /* from the frame before, in coding order, x 3 */
  fvv_delta_residuals *now, *before; /* of this frame and the one before, in coding order */
  uint8_t *last;                     /* signs of the last residuals that were not 0, x 3: 1 is negative, 2 */
  fvv_delta_model *models;           /* by fvv_delta_model_of */
  uint32_t model_count;
  /* NULL unless the meshes have normals: those of the base mesh (clause 8.7), by index and as its vertices'
   * own faces have them, x 2 and x 3, and room for those of the current frame's faces. */
  uint32_t *sent_normals;
  double *base_normals, *face_normals;
  /* Of a patched frame: its patch, empty when it has none; the vertices of the mesh before that it keeps,
   * rising, NULL when the frame is not patched. */
  fvv_mesh patch;
  uint32_t *kept, kept_count;
  uint32_t frame; /* 0: the key */
  int broken;     /* a frame failed: nothing that follows can be decoded */
};

/* What states of a level are rounded to, as a power of two: what divides its step, quarters at least. */
static inline int fvv_delta_rounding(uint32_t step) {
  return step & 1 ? 0 : step & 2 ? 1 : FVV_DELTA_FRACTION_BITS;
}

/* Where interpolation leads a vertex, kept inside the lattice. */
static inline void fvv_delta_predict(const struct fvv_mesh_sequence *s, uint32_t place, int rounding,
                                     int32_t to[3]) {
  const fvv_delta_stencil *stencil = &s->hierarchy.stencils[place];
  int64_t sum[3] = {0, 0, 0};
  for (int i = 0; i < FVV_DELTA_NEIGHBOURS; i++) {
    const int32_t *m = s->motion + 3 * (size_t)stencil->node[i];
    for (int a = 0; a < 3; a++) sum[a] += (int64_t)stencil->weight[i] * m[a];
  }
  for (int a = 0; a < 3; a++) {
    const int64_t half = INT64_C(1) << (FVV_DELTA_WEIGHT_BITS - 1);
    int64_t x =
        s->place[3 * (size_t)place + (size_t)a] + fvv_shift_right(sum[a] + half, FVV_DELTA_WEIGHT_BITS);
    x = fvv_shift_right(x + (1 << rounding >> 1), rounding) * (1 << rounding);
    if (x > FVV_DELTA_STATE_MAX) x = FVV_DELTA_STATE_MAX;
    if (x < -FVV_DELTA_STATE_MAX) x = -FVV_DELTA_STATE_MAX;
    to[a] = (int32_t)x;
  }
}

/* Moves a vertex on one axis. From one end of the lattice to the other is one too many for a motion: others
 * follow less far. */
static inline void fvv_delta_move(struct fvv_mesh_sequence *s, size_t place, int axis, int32_t to) {
  int32_t *const from = s->place + 3 * place + axis;
  const int64_t motion = (int64_t)to - *from;
  s->motion[3 * place + (size_t)axis] = (int32_t)(motion > INT32_MAX ? INT32_MAX : motion);
  *from = to;
}

/* What is known of the residuals of a vertex before they are decoded. */
typedef struct fvv_delta_context {
  fvv_delta_residuals around; /* sums: magnitudes at most 4 * 15 */
  uint32_t nodes;             /* in the sums */
  fvv_delta_residuals before;
  uint8_t *last;
  uint32_t axes_before; /* sum of magnitudes on the axes that were decoded */
} fvv_delta_context;

static inline fvv_delta_context fvv_delta_look_around(const struct fvv_mesh_sequence *s, uint32_t place) {
  const fvv_delta_stencil *stencil = &s->hierarchy.stencils[place];
  fvv_delta_context c = {0, 0, s->before[place], s->last + 3 * (size_t)place, 0};
  for (int i = 0; i < FVV_DELTA_AROUND; i++)
    if (stencil->weight[i]) {
      c.around += s->now[stencil->node[i]];
      c.nodes++;
    }
  return c;
}
static inline uint32_t fvv_delta_around_class(const fvv_delta_context *c, int axis) {
  const uint32_t sum = (uint32_t)(c->around >> (8 * axis) & 255);
  return sum < 3 ? sum : sum < 5 ? 3 : sum < 9 ? 4 : 5;
}
static inline uint32_t fvv_delta_class(uint32_t magnitude) {
  return magnitude < FVV_DELTA_CLASSES ? magnitude : FVV_DELTA_CLASSES - 1;
}
static inline fvv_probability *fvv_delta_some(fvv_delta_model *model, const fvv_delta_context *c, int axis,
                                              uint32_t around) {
  const uint32_t before = (uint32_t)(c->before >> (8 * axis) & 255);
  return &model->some[axis][around][fvv_delta_class(before)][fvv_delta_class(c->axes_before)];
}
static inline fvv_probability *fvv_delta_negative(fvv_delta_model *model, const fvv_delta_context *c,
                                                  int axis) {
  const uint32_t signs = (uint32_t)(c->around >> (32 + 8 * axis) & 255);
  return &model->negative[axis][c->last[axis]][signs > c->nodes ? 2 : signs < c->nodes];
}
/* Notes a residual that is not 0, in now as well. */
static inline void fvv_delta_note(fvv_delta_context *c, int axis, uint32_t magnitude, int negative,
                                  fvv_delta_residuals *now) {
  const uint32_t most = FVV_DELTA_REMEMBERED, kept = magnitude < most ? magnitude : most;
  *now += (fvv_delta_residuals)kept << (8 * axis);
  if (negative)
    *now -= UINT64_C(1) << (32 + 8 * axis);
  else
    *now += UINT64_C(1) << (32 + 8 * axis);
  c->last[axis] = negative ? 1 : 2;
  c->axes_before += kept;
}

/* The contexts of a level: by its place from the finest one on, as there may be more or fewer after a patched
 * frame; twins have their own. */
static inline uint32_t fvv_delta_model_of(const fvv_delta_hierarchy *h, uint32_t level) {
  const uint32_t twins = h->points < h->vertex_count;
  return twins && level == h->level_count - 1 ? 0 : h->level_count - twins - level;
}

/* First vertex of a level in coding order. */
static inline uint32_t fvv_delta_level_begin(const struct fvv_mesh_sequence *s, uint32_t level) {
  return level ? s->hierarchy.level_end[level - 1] : 0;
}

/* A level without residuals: all vertices of it take their prediction. */
void fvv_delta_follow(struct fvv_mesh_sequence *sequence, uint32_t level, uint32_t step);

/* What a delta payload says of its levels (clause 8.7). */

typedef struct fvv_delta_level {
  uint32_t step; /* of residuals, in quarters of the lattice's step */
  int64_t width; /* of states for which no residual is sent; the encoder's */
  size_t size;   /* bytes; 0: no vertex of it has a residual */
  size_t offset; /* of the first byte in the payload */
} fvv_delta_level;

typedef struct fvv_delta_frame {
  fvv_delta_level level[FVV_MESH_LEVELS_MAX];
} fvv_delta_frame;

/* The MESH header of the next frame, of either profile: FVV_OK, or the diagnostic says what does not fit the
 * mesh before. */
FVV_MUST_USE fvv_status fvv_delta_read_header(const fvv_mesh_sequence *s, const uint8_t *payload, size_t size,
                                              const fvv_limits *limits, fvv_mesh_header *header,
                                              fvv_diagnostic *diagnostic);
/* The number of the delta_mesh() at an offset is that of the next frame, or cut: what else does not fit the
 * state may be due to a missing frame. */
FVV_MUST_USE fvv_status fvv_delta_check_number(const fvv_mesh_sequence *s, const uint8_t *payload,
                                               size_t size, size_t at, fvv_diagnostic *diagnostic);
/* The same for number and levels of the delta_mesh() at an offset. */
FVV_MUST_USE fvv_status fvv_delta_read_levels(const fvv_mesh_sequence *s, const uint8_t *payload, size_t size,
                                              size_t at, fvv_delta_frame *frame, fvv_diagnostic *diagnostic);

/* Makes mesh that of the current frame, from which the next one is predicted, and takes it over. Its first
 * kept_count vertices are those of the mesh before that s->kept names. FVV_OK or FVV_ERROR_MEMORY; the state
 * is broken then. */
FVV_MUST_USE fvv_status fvv_delta_replace_mesh(fvv_mesh_sequence *s, fvv_mesh *mesh);

/* What writers of both profiles share. */

/* The sequence can go on, with these arguments. */
FVV_MUST_USE fvv_status fvv_delta_check_input(const fvv_mesh_sequence *s, const int32_t *lattice,
                                              const fvv_mesh_delta_options *options,
                                              fvv_diagnostic *diagnostic);
/* Appends a MESH header with the attributes of the mesh. */
FVV_MUST_USE fvv_status fvv_delta_put_header(const fvv_mesh_sequence *s, uint8_t profile, uint32_t vertices,
                                             uint32_t faces, fvv_bytes *payload);
/* Appends the delta_mesh() that moves the vertices to lattice, and ends the frame. used: for each vertex
 * whether it matters where it goes, the others cost nothing; NULL: all. Of the statuses that are not FVV_OK
 * only FVV_ERROR_MEMORY occurs; the state is broken then. */
FVV_MUST_USE fvv_status fvv_delta_put_levels(fvv_mesh_sequence *s, const int32_t *lattice,
                                             const uint8_t *used, const fvv_mesh_delta_options *options,
                                             fvv_bytes *payload, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
