#include "mesh/delta_hierarchy.h"

#include <string.h>

#include "base/memory.h"
#include "base/shift.h"
#include "mesh/hash.h"

#define EMPTY UINT32_MAX

enum {
  OFFSET_BITS = 9,    /* of offsets handed to fvv_delta_weights */
  FIRST_HALVINGS = 3, /* of the cube around the mesh, before the first level */
  CELLS_AROUND = 27,  /* with the one in the middle */
  KEPT_CELLS = 256    /* neighbourhoods kept, as vertices close to each other in order mostly share theirs */
};

/* Cubic cells of side 2^shift from the mesh's least corner on. Each cell that holds a vertex has one entry:
 * the vertex that is its node, or may become it. */
typedef struct grid {
  uint32_t *table; /* slots: vertices, EMPTY where there is none */
  uint32_t *slot;  /* of each vertex */
  int shift;
  uint32_t count; /* entries */
} grid;

/* The nodes in and around one cell, which is known by its own. */
typedef struct surroundings {
  uint32_t node, count;
  uint32_t around[CELLS_AROUND];
} surroundings;

typedef struct build {
  fvv_delta_hierarchy *out;
  const int32_t *positions;
  int32_t least[3];
  uint64_t slots;
  uint64_t seed;   /* from all positions: nobody can lay them out to share slots by a fixed rule */
  uint32_t *place; /* of each vertex in coding order, EMPTY: not yet in */
  uint32_t placed;
  grid coarse, fine; /* of the last level, and of the one that is tried */
  surroundings *kept;
} build;

static void cell_of(const build *b, int shift, uint32_t vertex, int32_t cell[3]) {
  for (int a = 0; a < 3; a++) cell[a] = (b->positions[3 * (size_t)vertex + (size_t)a] - b->least[a]) >> shift;
}

/* The slot of a cell's entry, or the empty one where it would stand. */
static uint64_t find_cell(const build *b, const grid *g, const int32_t cell[3]) {
  uint64_t slot = fvv_hash3((uint32_t)cell[0] ^ (uint32_t)b->seed,
                            (uint32_t)cell[1] ^ (uint32_t)(b->seed >> 32), (uint32_t)cell[2]) &
                  (b->slots - 1);
  for (; g->table[slot] != EMPTY; slot = (slot + 1) & (b->slots - 1)) {
    int32_t other[3];
    cell_of(b, g->shift, g->table[slot], other);
    if (other[0] == cell[0] && other[1] == cell[1] && other[2] == cell[2]) break;
  }
  return slot;
}

/* Squared distance from the centre of the cell, in half steps. */
static uint64_t from_centre(const build *b, int shift, uint32_t vertex) {
  const int64_t side = INT64_C(1) << shift;
  uint64_t sum = 0;
  for (int a = 0; a < 3; a++) {
    const int64_t x = (int64_t)b->positions[3 * (size_t)vertex + (size_t)a] - b->least[a];
    const int64_t d = shift ? 2 * (x & (side - 1)) - side : 0;
    sum += (uint64_t)(d * d);
  }
  return sum;
}

/* Enters every vertex in b->fine: nodes of earlier levels first; in other cells the vertex nearest to the
 * centre, of several the lowest. */
static void fill(build *b, int shift) {
  grid *g = &b->fine;
  memset(g->table, 0xff, (size_t)b->slots * sizeof *g->table);
  g->shift = shift;
  g->count = b->placed;
  int32_t cell[3];
  for (uint32_t i = 0; i < b->placed; i++) {
    const uint32_t v = b->out->order[i];
    cell_of(b, shift, v, cell);
    const uint64_t slot = find_cell(b, g, cell);
    g->table[slot] = v;
    g->slot[v] = (uint32_t)slot;
  }
  for (uint32_t v = 0; v < b->out->vertex_count; v++) {
    if (b->place[v] != EMPTY) continue;
    cell_of(b, shift, v, cell);
    const uint64_t slot = find_cell(b, g, cell);
    const uint32_t other = g->table[slot];
    g->slot[v] = (uint32_t)slot;
    if (other == EMPTY) {
      g->table[slot] = v;
      g->count++;
    } else if (b->place[other] == EMPTY && from_centre(b, shift, v) < from_centre(b, shift, other)) {
      g->table[slot] = v;
    }
  }
}

static const surroundings *look_around(build *b, uint32_t node) {
  surroundings *s = &b->kept[node % KEPT_CELLS];
  if (s->node == node) return s;
  s->node = node;
  s->count = 0;
  int32_t centre[3];
  cell_of(b, b->coarse.shift, node, centre);
  for (int i = 0; i < CELLS_AROUND; i++) {
    const int32_t cell[3] = {centre[0] + i / 9 - 1, centre[1] + i / 3 % 3 - 1, centre[2] + i % 3 - 1};
    const uint32_t found = b->coarse.table[find_cell(b, &b->coarse, cell)];
    if (found != EMPTY) s->around[s->count++] = found;
  }
  return s;
}

/* The nearest nodes around the vertex's cell in the coarse grid, of equally near ones the lower vertex. */
static void set_stencil(build *b, uint32_t vertex, fvv_delta_stencil *stencil) {
  const surroundings *s = look_around(b, b->coarse.table[b->coarse.slot[vertex]]);
  const int32_t *x = b->positions + 3 * (size_t)vertex;
  uint64_t distance[FVV_DELTA_NEIGHBOURS];
  uint32_t nearest[FVV_DELTA_NEIGHBOURS], count = 0;
  for (uint32_t i = 0; i < s->count; i++) {
    const uint32_t node = s->around[i];
    uint64_t d = 0;
    for (size_t a = 0; a < 3; a++) {
      const int64_t u = (int64_t)b->positions[3 * (size_t)node + a] - x[a];
      d += (uint64_t)(u * u);
    }
    uint32_t at = count < FVV_DELTA_NEIGHBOURS ? count++ : FVV_DELTA_NEIGHBOURS;
    for (; at && (d < distance[at - 1] || (d == distance[at - 1] && node < nearest[at - 1])); at--) {
      if (at == FVV_DELTA_NEIGHBOURS) continue;
      distance[at] = distance[at - 1];
      nearest[at] = nearest[at - 1];
    }
    if (at == FVV_DELTA_NEIGHBOURS) continue;
    distance[at] = d;
    nearest[at] = node;
  }
  /* Neighbouring cells: an offset is below twice the side. */
  const int reduced = b->coarse.shift + 1 > OFFSET_BITS ? b->coarse.shift + 1 - OFFSET_BITS : 0;
  int32_t offsets[FVV_DELTA_NEIGHBOURS][3];
  for (uint32_t i = 0; i < count; i++) {
    stencil->node[i] = b->place[nearest[i]];
    for (size_t a = 0; a < 3; a++)
      offsets[i][a] =
          (int32_t)fvv_shift_right((int64_t)b->positions[3 * (size_t)nearest[i] + a] - x[a], reduced);
  }
  fvv_delta_weights(offsets, count, stencil->weight);
}

static void end_level(build *b) {
  b->out->level_end[b->out->level_count++] = b->placed;
}

/* The entries of the fine grid that are no nodes yet become the next level, in order of vertices. */
static void take_level(build *b) {
  const int first = b->out->level_count == 0;
  memset(b->kept, 0xff, KEPT_CELLS * sizeof *b->kept);
  for (uint32_t v = 0; v < b->out->vertex_count; v++) {
    if (b->place[v] != EMPTY || b->fine.table[b->fine.slot[v]] != v) continue;
    if (!first) set_stencil(b, v, &b->out->stencils[b->placed]);
    b->out->order[b->placed] = v;
    b->place[v] = b->placed++;
  }
  end_level(b);
  const grid former = b->coarse;
  b->coarse = b->fine;
  b->fine = former;
}

/* What is left lies on points of vertices that are in, and moves with them. */
static void take_twins(build *b) {
  if (b->placed == b->out->vertex_count) return;
  b->out->has_twins = 1;
  for (uint32_t v = 0; v < b->out->vertex_count; v++) {
    if (b->place[v] != EMPTY) continue;
    fvv_delta_stencil *stencil = &b->out->stencils[b->placed];
    stencil->node[0] = b->place[b->coarse.table[b->coarse.slot[v]]];
    stencil->weight[0] = 1 << FVV_DELTA_WEIGHT_BITS;
    b->out->order[b->placed++] = v;
  }
  end_level(b);
}

/* A level has at least twice the vertices of those before it, so that there are few, and the one before the
 * last at most a third of all. */
static void take_levels(build *b) {
  const uint32_t all = b->out->vertex_count;
  uint32_t extent = 0;
  for (size_t a = 0; a < 3; a++) {
    int32_t low = INT32_MAX, high = INT32_MIN;
    for (size_t v = 0; v < all; v++) {
      const int32_t x = b->positions[3 * v + a];
      b->seed = fvv_mix(b->seed ^ (uint32_t)x);
      if (x < low) low = x;
      if (x > high) high = x;
    }
    b->least[a] = low;
    extent |= (uint32_t)(high - low);
  }
  int shift = 0;
  while (extent >> shift) shift++;
  /* With fewer than eight cells along the longest side there is no point in counting them. */
  shift = shift > FIRST_HALVINGS ? shift - FIRST_HALVINGS : 0;
  for (; shift > 0 && 3 * (uint64_t)FVV_DELTA_COARSEST <= all; shift--) {
    fill(b, shift);
    if (3 * (uint64_t)b->fine.count > all) break;
    const uint64_t wanted = b->placed ? 2 * (uint64_t)b->placed : FVV_DELTA_COARSEST;
    if (b->fine.count >= wanted) take_level(b);
  }
  fill(b, 0);
  take_level(b);
  take_twins(b);
}

static fvv_status allocate_grid(build *b, grid *g) {
  g->table = fvv_allocate_array(&b->out->allocator, (size_t)b->slots, sizeof *g->table);
  g->slot = fvv_allocate_array(&b->out->allocator, b->out->vertex_count, sizeof *g->slot);
  return g->table && g->slot ? FVV_OK : FVV_ERROR_MEMORY;
}
static void release_grid(const build *b, const grid *g) {
  fvv_release(&b->out->allocator, g->table, (size_t)b->slots * sizeof *g->table);
  fvv_release(&b->out->allocator, g->slot, b->out->vertex_count * sizeof *g->slot);
}

fvv_status fvv_delta_hierarchy_build(const int32_t *positions, uint32_t vertex_count,
                                     const fvv_allocator *allocator, fvv_delta_hierarchy *hierarchy) {
  memset(hierarchy, 0, sizeof *hierarchy);
  hierarchy->vertex_count = vertex_count;
  hierarchy->allocator = *allocator;
  build b;
  memset(&b, 0, sizeof b);
  b.out = hierarchy;
  b.positions = positions;
  b.slots = fvv_hash_slots(vertex_count);
  if (b.slots > SIZE_MAX / sizeof(uint32_t)) return FVV_ERROR_MEMORY;
  const size_t size = vertex_count * sizeof(uint32_t);
  hierarchy->order = fvv_allocate(allocator, size);
  hierarchy->stencils = fvv_allocate_array(allocator, vertex_count, sizeof *hierarchy->stencils);
  b.place = fvv_allocate(allocator, size);
  b.kept = fvv_allocate_array(allocator, KEPT_CELLS, sizeof *b.kept);
  fvv_status status = FVV_ERROR_MEMORY;
  if (hierarchy->order && hierarchy->stencils && b.place && b.kept) status = FVV_OK;
  if (status == FVV_OK) status = allocate_grid(&b, &b.coarse);
  if (status == FVV_OK) status = allocate_grid(&b, &b.fine);
  if (status == FVV_OK) {
    memset(hierarchy->stencils, 0, vertex_count * sizeof *hierarchy->stencils);
    memset(b.place, 0xff, size);
    take_levels(&b);
  }
  fvv_release(allocator, b.place, size);
  fvv_release(allocator, b.kept, KEPT_CELLS * sizeof *b.kept);
  release_grid(&b, &b.coarse);
  release_grid(&b, &b.fine);
  return status;
}

void fvv_delta_hierarchy_free(fvv_delta_hierarchy *hierarchy) {
  if (!hierarchy->allocator.resize) return;
  fvv_release(&hierarchy->allocator, hierarchy->order, hierarchy->vertex_count * sizeof *hierarchy->order);
  fvv_release(&hierarchy->allocator, hierarchy->stencils,
              hierarchy->vertex_count * sizeof *hierarchy->stencils);
  memset(hierarchy, 0, sizeof *hierarchy);
}
