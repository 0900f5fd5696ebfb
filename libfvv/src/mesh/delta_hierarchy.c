/* The hierarchy of a mesh and the weights of its stencils (clause 8.8). */
#include <string.h>

#include "base/checked.h"
#include "base/memory.h"
#include "mesh/delta.h"
#include "mesh/hash.h"

enum {
  WEIGHT_BITS = 12,  /* of the uncorrected weights */
  MATRIX_BITS = 17,  /* of the trace: products of three entries and a mean stay below 2^63 */
  INVERSE_BITS = 16, /* fraction of the solution */
  RIDGE = 32,
  CORRECTION_MAX = 1 << 18 /* 4 */
};

/* Inverse squared distances that add up to 2^12; the nearest one takes what rounding leaves. */
static void weights_of(int32_t offsets[][3], uint32_t count, int64_t *shares) {
  uint64_t inverse[FVV_DELTA_NEIGHBOURS], sum = 0;
  for (uint32_t i = 0; i < count; i++) {
    uint64_t squared = 1;
    for (int a = 0; a < 3; a++) squared += (uint64_t)((int64_t)offsets[i][a] * offsets[i][a]);
    inverse[i] = (UINT64_C(1) << 30) / squared;
    sum += inverse[i];
  }
  int64_t rest = 1 << WEIGHT_BITS;
  for (uint32_t i = 0; i < count; i++) {
    shares[i] = (int64_t)((inverse[i] << WEIGHT_BITS) / sum);
    rest -= shares[i];
  }
  shares[0] += rest;
}

/* Solves (spread + ridge) * x = -mean by the adjugate: x = solution * 2^-16 * 2^-shift. 0 where all points
 * lie together and there is nothing to solve. */
static int solve(int32_t offsets[][3], uint32_t count, const int64_t *shares, const int64_t mean[3],
                 int64_t solution[3], int *shift) {
  int64_t s[3][3];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      int64_t sum = 0;
      for (uint32_t i = 0; i < count; i++) sum += shares[i] * offsets[i][a] * offsets[i][b];
      s[a][b] = sum * (1 << WEIGHT_BITS) - mean[a] * mean[b];
    }
  const int64_t trace = s[0][0] + s[1][1] + s[2][2];
  *shift = 0;
  while (trace >> *shift >= 1 << MATRIX_BITS) ++*shift;
  for (int a = 0; a < 3; a++) {
    s[a][a] += trace / RIDGE + 1;
    for (int b = 0; b < 3; b++) s[a][b] = fvv_shift_right(s[a][b], *shift);
  }
  int64_t adjugate[3][3];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      const int a1 = (a + 1) % 3, a2 = (a + 2) % 3, b1 = (b + 1) % 3, b2 = (b + 2) % 3;
      adjugate[a][b] = s[a1][b1] * s[a2][b2] - s[a1][b2] * s[a2][b1];
    }
  const int64_t determinant = s[0][0] * adjugate[0][0] + s[0][1] * adjugate[0][1] + s[0][2] * adjugate[0][2];
  const int64_t divisor = fvv_shift_right(determinant, INVERSE_BITS);
  if (divisor <= 0) return 0;
  for (int a = 0; a < 3; a++)
    solution[a] = -(adjugate[a][0] * mean[0] + adjugate[a][1] * mean[1] + adjugate[a][2] * mean[2]) / divisor;
  return 1;
}

void fvv_delta_weights(int32_t offsets[][3], uint32_t count, int32_t *weights) {
  int64_t shares[FVV_DELTA_NEIGHBOURS] = {0}, mean[3] = {0, 0, 0}, solution[3];
  weights_of(offsets, count, shares);
  for (uint32_t i = 0; i < count; i++)
    for (int a = 0; a < 3; a++) mean[a] += shares[i] * offsets[i][a];
  int shift;
  const int solved = solve(offsets, count, shares, mean, solution, &shift);
  int64_t rest = 1 << FVV_DELTA_WEIGHT_BITS;
  for (uint32_t i = 0; i < count; i++) {
    int64_t correction = 0;
    for (int a = 0; solved && a < 3; a++)
      correction += ((int64_t)offsets[i][a] * (1 << WEIGHT_BITS) - mean[a]) * solution[a];
    if (solved) correction = fvv_shift_right(correction, shift);
    if (correction > CORRECTION_MAX) correction = CORRECTION_MAX;
    if (correction < -CORRECTION_MAX) correction = -CORRECTION_MAX;
    weights[i] =
        (int32_t)fvv_shift_right(shares[i] * ((1 << FVV_DELTA_WEIGHT_BITS) + correction), WEIGHT_BITS);
    rest -= weights[i];
  }
  weights[0] += (int32_t)rest;
}

#define NONE UINT32_MAX

enum { OFFSET_BITS = 9 /* of offsets handed to fvv_delta_weights */ };

/* Edges of the vertices that are left: neighbours of v are neighbour[begin[v]] to neighbour[end[v] - 1]. */
typedef struct graph {
  uint32_t *neighbour, *begin, *end;
} graph;

typedef struct build {
  const fvv_mesh *mesh;
  fvv_delta_hierarchy *out;
  graph now, next;
  uint32_t *left;                /* vertices that no pass has taken out, rising */
  uint32_t *into;                /* where a vertex was contracted into, NONE: it is left */
  uint32_t *stamp;               /* the vertex whose neighbours hold this one, while they are collected */
  uint32_t *lowest;              /* vertex on the same lattice point */
  uint32_t left_count, free_end; /* places from free_end on are taken */
  uint32_t pass_count, pass_begin[FVV_DELTA_PASSES_MAX];
} build;

static uint64_t squared_distance(const build *b, uint32_t v, uint32_t w) {
  uint64_t sum = 0;
  for (size_t a = 0; a < 3; a++) {
    const int64_t u = (int64_t)b->mesh->lattice[3 * (size_t)v + a] - b->mesh->lattice[3 * (size_t)w + a];
    sum += (uint64_t)(u * u);
  }
  return sum;
}

/* Finds the lowest vertex of each lattice point. table: slots entries. */
static void find_points(build *b, uint32_t *table, uint64_t slots) {
  const uint32_t n = b->mesh->vertex_count;
  const int32_t *p = b->mesh->lattice;
  /* From all positions: they cannot be laid out to share slots by a fixed rule. */
  uint64_t seed = 0;
  for (size_t i = 0; i < 3 * (size_t)n; i++) seed = fvv_mix(seed ^ (uint32_t)p[i]);
  memset(table, 0xff, (size_t)slots * sizeof *table);
  for (uint32_t v = 0; v < n; v++, p += 3) {
    uint64_t slot =
        fvv_hash3((uint32_t)p[0] ^ (uint32_t)seed, (uint32_t)p[1] ^ (uint32_t)(seed >> 32), (uint32_t)p[2]) &
        (slots - 1);
    while (table[slot] != NONE && memcmp(b->mesh->lattice + 3 * (size_t)table[slot], p, 3 * sizeof *p))
      slot = (slot + 1) & (slots - 1);
    if (table[slot] == NONE) table[slot] = v;
    b->lowest[v] = table[slot];
    if (b->lowest[v] == v) b->left[b->left_count++] = v;
  }
}

/* Edges of all faces, in both directions; those that two faces share come twice. */
static void connect(build *b) {
  graph *g = &b->next;
  const uint32_t n = b->mesh->vertex_count;
  const size_t corners = 3 * (size_t)b->mesh->face_count;
  memset(g->end, 0, n * sizeof *g->end);
  for (size_t i = 0; i < corners; i++) g->end[b->lowest[b->mesh->faces[i]]] += 2;
  uint32_t at = 0;
  for (uint32_t v = 0; v < n; v++) {
    g->begin[v] = at;
    at += g->end[v];
    g->end[v] = g->begin[v];
  }
  for (size_t i = 0; i < corners; i++) {
    const uint32_t v = b->lowest[b->mesh->faces[i]],
                   w = b->lowest[b->mesh->faces[i % 3 == 2 ? i - 2 : i + 1]];
    g->neighbour[g->end[v]++] = w;
    g->neighbour[g->end[w]++] = v;
  }
}

/* One more neighbour at at, unless it is stamped. Without a branch, which could not be predicted:
 * the entry after the last one may be written too. */
static inline uint32_t add_neighbour(const build *b, uint32_t v, uint32_t neighbour, uint32_t at) {
  b->now.neighbour[at] = neighbour;
  at += b->stamp[neighbour] != v;
  b->stamp[neighbour] = v;
  return at;
}

/* The graph of what is left, from that in which vertices were contracted: b->next becomes b->now. No two of
 * those were neighbours, so each leads to one that is left. */
static void contract(build *b) {
  for (uint32_t i = 0; i < b->left_count; i++) b->stamp[b->left[i]] = NONE;
  uint32_t at = 0;
  for (uint32_t i = 0; i < b->left_count; i++) {
    const uint32_t v = b->left[i];
    b->now.begin[v] = at;
    b->stamp[v] = v;
    for (uint32_t j = b->next.begin[v]; j < b->next.end[v]; j++) {
      const uint32_t w = b->next.neighbour[j], to = b->into[w];
      if (to == v)
        for (uint32_t k = b->next.begin[w]; k < b->next.end[w]; k++)
          at = add_neighbour(b, v, b->next.neighbour[k], at);
      else
        at = add_neighbour(b, v, to == NONE ? w : to, at);
    }
    b->now.end[v] = at;
  }
}

/* The nearest of the neighbours, nearest first, of equally near ones the lower vertex. Returns how many. */
static uint32_t find_nearest(const build *b, uint32_t v, uint32_t nearest[FVV_DELTA_DEGREE_MAX]) {
  uint64_t distance[FVV_DELTA_DEGREE_MAX];
  uint32_t count = 0;
  for (uint32_t i = b->now.begin[v]; i < b->now.end[v]; i++) {
    const uint32_t node = b->now.neighbour[i];
    const uint64_t d = squared_distance(b, v, node);
    uint32_t at = count++;
    for (; at && (d < distance[at - 1] || (d == distance[at - 1] && node < nearest[at - 1])); at--) {
      distance[at] = distance[at - 1];
      nearest[at] = nearest[at - 1];
    }
    distance[at] = d;
    nearest[at] = node;
  }
  return count < FVV_DELTA_NEIGHBOURS ? count : FVV_DELTA_NEIGHBOURS;
}

/* Nodes are vertices as yet: their places are found when all passes are done. */
static void set_stencil(const build *b, uint32_t v, const uint32_t *nodes, uint32_t count,
                        fvv_delta_stencil *stencil) {
  int64_t offsets[FVV_DELTA_NEIGHBOURS][3], most = 0;
  for (uint32_t i = 0; i < count; i++)
    for (size_t a = 0; a < 3; a++) {
      const int64_t u =
          (int64_t)b->mesh->lattice[3 * (size_t)nodes[i] + a] - b->mesh->lattice[3 * (size_t)v + a];
      offsets[i][a] = u;
      most |= u < 0 ? -u : u;
    }
  int reduced = 0;
  while (most >> reduced >= 1 << OFFSET_BITS) reduced++;
  int32_t short_offsets[FVV_DELTA_NEIGHBOURS][3];
  for (uint32_t i = 0; i < count; i++) {
    stencil->node[i] = nodes[i];
    for (size_t a = 0; a < 3; a++) short_offsets[i][a] = (int32_t)fvv_shift_right(offsets[i][a], reduced);
  }
  fvv_delta_weights(short_offsets, count, stencil->weight);
}

/* Marks, in rising order, each vertex with few neighbours of which none is marked. Returns how many; with:
 * how many have neighbours at all. */
static uint32_t mark(build *b, uint32_t *with) {
  uint32_t marked = 0;
  *with = 0;
  for (uint32_t i = 0; i < b->left_count; i++) {
    const uint32_t v = b->left[i], begin = b->now.begin[v], end = b->now.end[v];
    *with += end > begin;
    if (end == begin || end - begin > FVV_DELTA_DEGREE_MAX) continue;
    uint32_t j = begin;
    while (j < end && b->into[b->now.neighbour[j]] == NONE) j++;
    if (j < end) continue;
    b->into[v] = v;
    marked++;
  }
  return marked;
}

/* Takes vertices out: they become the level after all that are left. 0 when enough is done. */
static int pass(build *b) {
  if (b->pass_count == FVV_DELTA_PASSES_MAX) return 0;
  uint32_t with, kept = 0;
  const uint32_t marked = mark(b, &with);
  if (with <= FVV_DELTA_SURVIVORS || marked < with / FVV_DELTA_SHARE) {
    for (uint32_t i = 0; i < b->left_count; i++) b->into[b->left[i]] = NONE;
    return 0;
  }
  uint32_t place = b->free_end -= marked;
  b->pass_begin[b->pass_count++] = place;
  for (uint32_t i = 0; i < b->left_count; i++) {
    const uint32_t v = b->left[i];
    if (b->into[v] == NONE) {
      b->left[kept++] = v;
      continue;
    }
    uint32_t nearest[FVV_DELTA_DEGREE_MAX];
    const uint32_t count = find_nearest(b, v, nearest);
    b->into[v] = nearest[0];
    set_stencil(b, v, nearest, count, &b->out->stencils[place]);
    b->out->order[place++] = v;
  }
  b->left_count = kept;
  const graph former = b->now;
  b->now = b->next;
  b->next = former;
  contract(b);
  return 1;
}

static void set_single(fvv_delta_stencil *stencil, uint32_t node) {
  stencil->node[0] = node;
  stencil->weight[0] = 1 << FVV_DELTA_WEIGHT_BITS;
}

/* Vertices on the points of others move with them and come last. What no pass took out comes first, each
 * predicted from the one before it: many small pieces that move together have nothing else in common. */
static void take_rest(build *b) {
  const uint32_t n = b->mesh->vertex_count;
  uint32_t place = 0;
  for (; place < b->left_count; place++) {
    if (place) set_single(&b->out->stencils[place], b->left[place - 1]);
    b->out->order[place] = b->left[place];
  }
  place = n;
  for (uint32_t v = n; v-- > 0;)
    if (b->lowest[v] != v) {
      set_single(&b->out->stencils[--place], b->lowest[v]);
      b->out->order[place] = v;
    }
}

static void end_levels(build *b, uint32_t points) {
  fvv_delta_hierarchy *h = b->out;
  for (uint32_t p = b->pass_count / FVV_DELTA_PASSES_A_LEVEL; p-- > 0;)
    h->level_end[h->level_count++] =
        b->pass_begin[FVV_DELTA_PASSES_A_LEVEL * p + FVV_DELTA_PASSES_A_LEVEL - 1];
  h->points = points;
  h->level_end[h->level_count++] = points;
  if (points < h->vertex_count) h->level_end[h->level_count++] = h->vertex_count;
}

/* Nodes: vertices -> places. */
static void find_places(build *b) {
  const uint32_t n = b->mesh->vertex_count;
  uint32_t *const place = b->stamp;
  for (uint32_t i = 0; i < n; i++) place[b->out->order[i]] = i;
  for (uint32_t i = 1; i < n; i++) {
    fvv_delta_stencil *s = &b->out->stencils[i];
    for (int k = 0; k < FVV_DELTA_NEIGHBOURS; k++) s->node[k] = s->weight[k] ? place[s->node[k]] : 0;
  }
}

static void take_levels(build *b) {
  memset(b->into, 0xff, b->mesh->vertex_count * sizeof *b->into);
  connect(b);
  contract(b);
  const uint32_t points = b->left_count;
  b->free_end = points;
  while (pass(b)) {}
  take_rest(b);
  end_levels(b, points);
  find_places(b);
}

fvv_status fvv_delta_hierarchy_build(const fvv_mesh *mesh, const fvv_allocator *allocator,
                                     fvv_delta_hierarchy *hierarchy) {
  const uint32_t n = mesh->vertex_count;
  memset(hierarchy, 0, sizeof *hierarchy);
  hierarchy->vertex_count = n;
  hierarchy->allocator = *allocator;
  build b;
  memset(&b, 0, sizeof b);
  b.mesh = mesh;
  b.out = hierarchy;
  /* Slots of points; the table's memory serves the graphs afterwards. */
  const uint64_t slots = fvv_hash_slots(n), edges = 6 * (uint64_t)mesh->face_count;
  if (slots > SIZE_MAX / sizeof(uint32_t) || edges >= UINT32_MAX) return FVV_ERROR_MEMORY;
  const size_t half = (size_t)(edges >= slots ? edges + 1 : slots);
  const size_t per_vertex = n * sizeof(uint32_t);
  uint32_t **const blocks[] = {&b.left,      &b.into,    &b.stamp,      &b.lowest,
                               &b.now.begin, &b.now.end, &b.next.begin, &b.next.end};
  hierarchy->order = fvv_allocate(allocator, per_vertex);
  hierarchy->stencils = fvv_allocate_array(allocator, n, sizeof *hierarchy->stencils);
  uint32_t *const first = fvv_allocate_array(allocator, half, sizeof(uint32_t));
  uint32_t *const second = fvv_allocate_array(allocator, half, sizeof(uint32_t));
  int enough = hierarchy->order && hierarchy->stencils && first && second;
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) {
    *blocks[i] = fvv_allocate(allocator, per_vertex);
    enough = enough && *blocks[i];
  }
  if (enough) {
    memset(hierarchy->stencils, 0, n * sizeof *hierarchy->stencils);
    b.now.neighbour = first;
    b.next.neighbour = second;
    find_points(&b, first, slots);
    take_levels(&b);
  }
  for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) fvv_release(allocator, *blocks[i], per_vertex);
  fvv_release(allocator, first, half * sizeof(uint32_t));
  fvv_release(allocator, second, half * sizeof(uint32_t));
  return enough ? FVV_OK : FVV_ERROR_MEMORY;
}

void fvv_delta_hierarchy_free(fvv_delta_hierarchy *hierarchy) {
  if (!hierarchy->allocator.resize) return;
  fvv_release(&hierarchy->allocator, hierarchy->order, hierarchy->vertex_count * sizeof *hierarchy->order);
  fvv_release(&hierarchy->allocator, hierarchy->stencils,
              hierarchy->vertex_count * sizeof *hierarchy->stencils);
  memset(hierarchy, 0, sizeof *hierarchy);
}
