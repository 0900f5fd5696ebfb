#include "mesh/topology.h"

#include <string.h>

#include "base/memory.h"
#include "mesh/hash.h"

#define EMPTY UINT32_MAX

uint32_t fvv_topology_group(const fvv_topology *topology, uint32_t face) {
  uint32_t *group = topology->group;
  while (group[face] != face) {
    group[face] = group[group[face]];
    face = group[face];
  }
  return face;
}

/* The lower face leads, so that the result does not depend on the order of joining. Path halving alone keeps
 * this at n log n. */
static void join(const fvv_topology *topology, uint32_t a, uint32_t b) {
  a = fvv_topology_group(topology, a);
  b = fvv_topology_group(topology, b);
  if (a < b) topology->group[b] = a;
  if (b < a) topology->group[a] = b;
}

/* first: for every edge that was met, its first half-edge; uses: how many half-edges it has, stored there. */
static void link_edges(const uint32_t *faces, uint32_t *first, uint64_t slots, uint32_t *uses,
                       fvv_topology *topology) {
  const uint32_t half_edges = 3 * topology->face_count;
  for (uint32_t h = 0; h < half_edges; h++) {
    const uint32_t a = faces[h], b = faces[h % 3 == 2 ? h - 2 : h + 1];
    const uint32_t low = a < b ? a : b, high = a < b ? b : a;
    uint64_t slot = fvv_hash3(low, high, 0) & (slots - 1);
    for (; first[slot] != EMPTY; slot = (slot + 1) & (slots - 1)) {
      const uint32_t g = first[slot], ga = faces[g], gb = faces[g % 3 == 2 ? g - 2 : g + 1];
      if ((ga == low && gb == high) || (ga == high && gb == low)) break;
    }
    if (first[slot] == EMPTY) {
      first[slot] = h;
      uses[h] = 1;
      topology->boundary_edges++;
      continue;
    }
    const uint32_t g = first[slot];
    join(topology, g / 3, h / 3);
    if (uses[g] == 1) {
      topology->twin[g] = h;
      topology->twin[h] = g;
      topology->boundary_edges--;
    } else if (uses[g] == 2) {
      topology->twin[topology->twin[g]] = FVV_NO_TWIN;
      topology->twin[g] = FVV_NO_TWIN;
      topology->nonmanifold_edges++;
    }
    /* Three is as good as more, and never overflows. */
    if (uses[g] < 3) uses[g]++;
  }
}

fvv_status fvv_topology_build(const uint32_t *faces, uint32_t face_count, const fvv_allocator *allocator,
                              fvv_topology *topology) {
  memset(topology, 0, sizeof *topology);
  topology->face_count = face_count;
  topology->allocator = *allocator;
  const uint64_t slots = fvv_hash_slots(3 * (uint64_t)face_count);
  if (slots > SIZE_MAX / sizeof(uint32_t)) return FVV_ERROR_MEMORY;
  const size_t half_edges = 3 * (size_t)face_count;
  topology->twin = fvv_allocate_array(allocator, half_edges, sizeof(uint32_t));
  topology->group = fvv_allocate_array(allocator, face_count, sizeof(uint32_t));
  uint32_t *uses = fvv_allocate_array(allocator, half_edges, sizeof(uint32_t));
  uint32_t *first = fvv_allocate_array(allocator, (size_t)slots, sizeof(uint32_t));
  fvv_status status = FVV_ERROR_MEMORY;
  if (topology->twin && topology->group && uses && first) {
    memset(first, 0xff, (size_t)slots * sizeof(uint32_t));
    memset(topology->twin, 0xff, half_edges * sizeof(uint32_t));
    for (uint32_t f = 0; f < face_count; f++) topology->group[f] = f;
    link_edges(faces, first, slots, uses, topology);
    status = FVV_OK;
  }
  fvv_release(allocator, uses, half_edges * sizeof(uint32_t));
  fvv_release(allocator, first, (size_t)slots * sizeof(uint32_t));
  return status;
}

void fvv_topology_free(fvv_topology *topology) {
  if (!topology->allocator.resize) return;
  fvv_release(&topology->allocator, topology->twin, 3 * (size_t)topology->face_count * sizeof(uint32_t));
  fvv_release(&topology->allocator, topology->group, (size_t)topology->face_count * sizeof(uint32_t));
  memset(topology, 0, sizeof *topology);
}

enum { UNSEEN, AS_IS, TURNED };

/* Patches: faces joined over edges along which they agree. A patch is doubtful when at least half of its
 * border is against a neighbour: then it, or what is around it, is inside out. Two sound bodies that touch
 * along an edge are not. */
typedef struct patches {
  uint32_t *of_face;   /* the lowest face of the patch */
  uint32_t *disagrees; /* of that face: half-edges of the border against a neighbour */
  uint32_t *ends;      /* of that face: the other half-edges of the border */
  uint32_t *sizes;     /* of that face: faces */
} patches;

#define FEW_FACES 4 /* for each such half-edge: two triangles, or two quadrilaterals, are no bodies */

/* Neighbours agree when they run along their edge in opposite directions. */
static int agree(const uint32_t *faces, uint32_t half_edge, uint32_t twin) {
  return faces[half_edge] != faces[twin];
}

/* queue: as long as there are faces. */
static void find_patches(const fvv_topology *topology, const uint32_t *faces, uint32_t *queue, patches *out) {
  const uint32_t count = topology->face_count;
  memset(out->of_face, 0xff, (size_t)count * sizeof *out->of_face);
  for (uint32_t seed = 0; seed < count; seed++) {
    if (out->of_face[seed] != EMPTY) continue;
    uint32_t end = 0;
    out->of_face[seed] = seed;
    queue[end++] = seed;
    for (uint32_t i = 0; i < end; i++)
      for (uint32_t h = 3 * queue[i]; h < 3 * queue[i] + 3; h++) {
        const uint32_t twin = topology->twin[h];
        if (twin == FVV_NO_TWIN)
          out->ends[seed]++;
        else if (!agree(faces, h, twin))
          out->disagrees[seed]++;
        else if (out->of_face[twin / 3] == EMPTY) {
          out->of_face[twin / 3] = seed;
          queue[end++] = twin / 3;
        }
      }
    out->sizes[seed] = end;
  }
}

static int doubtful(const patches *p, uint32_t face) {
  const uint32_t patch = p->of_face[face];
  return p->disagrees[patch] >= p->ends[patch] || p->sizes[patch] / FEW_FACES < p->disagrees[patch];
}

/* Breadth first from seed; queue[from...] receives the faces reached, side[f] says which way each lies
 * relative to the seed. Returns the end of the queue. */
static uint32_t spread(const fvv_topology *topology, const uint32_t *faces, const patches *sets,
                       uint32_t seed, uint8_t *side, uint32_t *queue, uint32_t from) {
  uint32_t end = from;
  side[seed] = AS_IS;
  queue[end++] = seed;
  for (uint32_t i = from; i < end; i++) {
    const uint32_t f = queue[i];
    for (uint32_t h = 3 * f; h < 3 * f + 3; h++) {
      const uint32_t twin = topology->twin[h];
      if (twin == FVV_NO_TWIN || side[twin / 3] != UNSEEN) continue;
      const int same = agree(faces, h, twin);
      if (!same && !doubtful(sets, f) && !doubtful(sets, twin / 3)) continue;
      side[twin / 3] = (side[f] == AS_IS) == same ? AS_IS : TURNED;
      queue[end++] = twin / 3;
    }
  }
  return end;
}

/* Turns the smaller part of the faces queue[from ... end - 1]; returns how many. */
static uint32_t turn_smaller(uint32_t *faces, const uint8_t *side, const uint32_t *queue, uint32_t from,
                             uint32_t end) {
  uint32_t turned = 0, flipped = 0;
  for (uint32_t i = from; i < end; i++) turned += side[queue[i]] == TURNED;
  const uint8_t turn = turned <= (end - from) - turned ? TURNED : AS_IS;
  for (uint32_t i = from; i < end; i++) {
    if (side[queue[i]] != turn) continue;
    uint32_t *face = faces + 3 * (size_t)queue[i];
    const uint32_t corner = face[1];
    face[1] = face[2];
    face[2] = corner;
    flipped++;
  }
  return flipped;
}

fvv_status fvv_topology_orient(const fvv_topology *topology, uint32_t *faces, uint32_t *flipped) {
  const uint32_t count = topology->face_count;
  const size_t size = (size_t)count * sizeof(uint32_t);
  uint8_t *side = fvv_allocate_zeroed(&topology->allocator, count);
  uint32_t *queue = fvv_allocate_array(&topology->allocator, count, sizeof(uint32_t));
  patches sets = {fvv_allocate_array(&topology->allocator, count, sizeof(uint32_t)),
                  fvv_allocate_zeroed(&topology->allocator, size),
                  fvv_allocate_zeroed(&topology->allocator, size),
                  fvv_allocate_zeroed(&topology->allocator, size)};
  fvv_status status = FVV_ERROR_MEMORY;
  *flipped = 0;
  if (side && queue && sets.of_face && sets.disagrees && sets.ends && sets.sizes) {
    find_patches(topology, faces, queue, &sets);
    uint32_t end = 0;
    for (uint32_t seed = 0; seed < count; seed++) {
      if (side[seed] != UNSEEN) continue;
      const uint32_t from = end;
      end = spread(topology, faces, &sets, seed, side, queue, from);
      *flipped += turn_smaller(faces, side, queue, from, end);
    }
    status = FVV_OK;
  }
  fvv_release(&topology->allocator, side, count);
  fvv_release(&topology->allocator, queue, size);
  fvv_release(&topology->allocator, sets.of_face, size);
  fvv_release(&topology->allocator, sets.disagrees, size);
  fvv_release(&topology->allocator, sets.ends, size);
  fvv_release(&topology->allocator, sets.sizes, size);
  return status;
}
