/* Edgebreaker (Rossignac, IEEE TVCG 5(1), 1999; decoded backwards after Isenburg and Snoeyink, Spirale
 * Reversi, 2001) on boundary loops alone. No face is built: a loop of vertices with their valences says all
 * about what Draco's decoder will do. Its S costs as many steps as the joined vertex has faces, so that a few
 * kilobytes of hostile symbols around one vertex take it time in the square of their number; here every
 * symbol is one step. */
#include "mesh/draco_connectivity.h"

#include "base/memory.h"
#include "mesh/draco_symbols.h"

#define NONE UINT32_MAX

/* Vertices carry Draco's own numbers. An edge of a boundary is named by the vertex that it leaves. */
typedef struct boundary {
  const fvv_draco_connectivity *given;
  uint32_t *follower; /* of each vertex along its loop */
  uint32_t *valence;
  uint32_t *alias;  /* the vertex that an S made this one the same as; itself otherwise */
  uint32_t *stack;  /* active edges; the face of the next symbol is put onto the top one */
  uint32_t *joined; /* vertices that an S made the same as another one, in order */
  uint32_t *glued;  /* by symbol: the edge that an event keeps for this S, or NONE */
  uint32_t made, most;
  uint32_t height;
  uint32_t joined_count;
  uint32_t events_left;
  uint32_t left[FVV_DRACO_CONTEXTS];
  uint64_t steps;
} boundary;

static uint32_t new_vertex(boundary *b) {
  const uint32_t v = b->made++;
  b->valence[v] = 2;
  b->alias[v] = v;
  return v;
}

/* What an edge that waits, on the stack or for its S, is called now: another S may have joined the vertex
 * that it leaves. Never a cycle: only vertices that are on a loop, and so no aliases themselves, are joined.
 */
static uint32_t present_name(boundary *b, uint32_t v) {
  while (b->alias[v] != v) v = b->alias[v] = b->alias[b->alias[v]];
  return v;
}

/* The next symbol, FVV_DRACO_SYMBOLS when its context has none left. */
static unsigned symbol_at(boundary *b, uint32_t i) {
  if (!b->given->valence) return b->given->symbols[i];
  if (i == 0) return FVV_DRACO_E;
  const uint32_t valence = b->valence[b->follower[b->stack[b->height - 1]]];
  const unsigned context = valence < 2 ? 0 : valence > 7 ? 5 : valence - 2;
  if (b->left[context] == b->given->begin[context]) return FVV_DRACO_SYMBOLS;
  return b->given->symbols[--b->left[context]];
}

/* Each of these puts one face onto the active edge p -> n; 0 when that is impossible. */

static int put_c(boundary *b) {
  const uint32_t p = b->stack[b->height - 1], n = b->follower[p], m = b->follower[n];
  if (m == p) return 0;
  b->follower[p] = m;
  b->valence[p]++;
  b->valence[m]++;
  return 1;
}

static int put_lr(boundary *b, int right, uint32_t *tip) {
  if (b->made == b->most) return 0;
  const uint32_t p = b->stack[b->height - 1], n = b->follower[p], v = new_vertex(b);
  b->follower[p] = v;
  b->follower[v] = n;
  b->valence[p]++;
  b->valence[n]++;
  if (right) b->stack[b->height - 1] = v;
  *tip = right ? p : n;
  return 1;
}

static int put_s(boundary *b, uint32_t i) {
  const uint32_t second = b->stack[--b->height];
  if (b->glued && b->glued[i] != NONE) b->stack[b->height++] = b->glued[i];
  if (!b->height || b->joined_count == b->given->split_count) return 0;
  const uint32_t first = present_name(b, b->stack[b->height - 1]), n = b->follower[second],
                 m = b->follower[first];
  if (first == second || n == first) return 0;
  b->steps += b->valence[n];
  b->valence[first] += b->valence[n];
  b->valence[second]++;
  b->valence[m]++;
  b->follower[second] = m;
  b->follower[first] = b->follower[n];
  b->alias[n] = first;
  b->joined[b->joined_count++] = n;
  b->stack[b->height - 1] = second;
  return 1;
}

static int put_e(boundary *b, uint32_t *tip) {
  if (b->most - b->made < 3) return 0;
  const uint32_t first = new_vertex(b), second = new_vertex(b), third = new_vertex(b);
  b->follower[third] = second;
  b->follower[second] = first;
  b->follower[first] = third;
  b->stack[b->height++] = third;
  *tip = first;
  return 1;
}

/* Events end in the order in which their sources come; those of one source belong to its E, L or R. */
static int keep_events(boundary *b, uint32_t i, uint32_t tip) {
  const uint32_t count = b->given->symbol_count, id = count - 1 - i;
  for (; b->events_left; b->events_left--) {
    const fvv_draco_event *event = &b->given->events[b->events_left - 1];
    if (event->source < id) return 1;
    if (event->source > id || event->split >= count) return 0;
    b->glued[count - 1 - event->split] = event->right ? tip : b->follower[b->stack[b->height - 1]];
  }
  return 1;
}

static int put_face(boundary *b, uint32_t i) {
  if (b->height) b->stack[b->height - 1] = present_name(b, b->stack[b->height - 1]);
  const unsigned symbol = b->height || i == 0 ? symbol_at(b, i) : FVV_DRACO_SYMBOLS;
  uint32_t tip;
  if (symbol != FVV_DRACO_E && !b->height) return 0;
  switch (symbol) {
  case FVV_DRACO_C:
    return put_c(b);
  case FVV_DRACO_S:
    return put_s(b, i);
  case FVV_DRACO_L:
  case FVV_DRACO_R:
    return put_lr(b, symbol == FVV_DRACO_R, &tip) && keep_events(b, i, tip);
  case FVV_DRACO_E:
    return put_e(b, &tip) && keep_events(b, i, tip);
  default:
    return 0;
  }
}

/* Draco fills each gap that a join left with the last vertex, around which it walks. */
static void renumber(boundary *b) {
  for (uint32_t i = 0; i < b->joined_count; i++) b->valence[b->joined[i]] = 0;
  uint32_t count = b->made;
  for (uint32_t i = 0; i < b->joined_count; i++) {
    while (count && !b->valence[count - 1]) count--;
    const uint32_t gap = b->joined[i], last = count - 1;
    if (!count || last < gap) continue;
    b->steps += b->valence[last];
    b->valence[gap] = b->valence[last];
    b->valence[last] = 0;
  }
}

static fvv_draco_verdict follow(boundary *b) {
  const fvv_draco_connectivity *given = b->given;
  for (uint32_t i = 0; i < given->symbol_count; i++)
    if (!put_face(b, i)) return FVV_DRACO_BROKEN;
  if (b->joined_count != given->split_count || b->made - b->joined_count != given->vertex_count)
    return FVV_DRACO_BROKEN;
  renumber(b);
  return FVV_DRACO_SOUND;
}

fvv_draco_verdict fvv_draco_follow(const fvv_draco_connectivity *connectivity, const fvv_allocator *allocator,
                                   uint64_t *steps) {
  const uint64_t most = (uint64_t)connectivity->vertex_count + connectivity->split_count;
  const uint64_t symbols = connectivity->symbol_count, glued = connectivity->event_count ? symbols : 0;
  /* All tables in one block. Each E takes one place on the stack. */
  const uint64_t total = 3 * most + symbols + connectivity->split_count + glued;
  if (most >= NONE) return FVV_DRACO_BROKEN;
  if (!symbols || total > SIZE_MAX / sizeof(uint32_t))
    return symbols ? FVV_DRACO_NO_MEMORY : FVV_DRACO_BROKEN;
  uint32_t *block = fvv_allocate(allocator, (size_t)total * sizeof(uint32_t));
  if (!block) return FVV_DRACO_NO_MEMORY;
  boundary b = {.given = connectivity, .follower = block, .most = (uint32_t)most};
  b.valence = b.follower + most;
  b.alias = b.valence + most;
  b.stack = b.alias + most;
  b.joined = b.stack + symbols;
  b.events_left = connectivity->event_count;
  if (glued) b.glued = b.joined + connectivity->split_count;
  for (uint64_t i = 0; i < glued; i++) b.glued[i] = NONE;
  for (int i = 0; i < FVV_DRACO_CONTEXTS; i++) b.left[i] = connectivity->end[i];
  const fvv_draco_verdict verdict = follow(&b);
  *steps = b.steps;
  fvv_release(allocator, block, (size_t)total * sizeof(uint32_t));
  return verdict;
}
