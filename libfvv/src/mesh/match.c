/* Vertices of a decoded mesh found again in the one that was encoded. */
#include <string.h>

#include "base/diagnostic.h"
#include "base/memory.h"
#include "fvv/mesh.h"
#include "mesh/hash.h"

#define EMPTY UINT32_MAX

static uint64_t hash_of(const fvv_mesh *mesh, uint32_t vertex) {
  const int32_t *p = mesh->positions + 3 * (size_t)vertex;
  const uint64_t hash = fvv_hash3((uint32_t)p[0], (uint32_t)p[1], (uint32_t)p[2]);
  if (!mesh->texture) return hash;
  return hash ^ fvv_hash3(mesh->texture[2 * (size_t)vertex], mesh->texture[2 * (size_t)vertex + 1], 1);
}

static int alike(const fvv_mesh *a, uint32_t i, const fvv_mesh *b, uint32_t j) {
  return !memcmp(a->positions + 3 * (size_t)i, b->positions + 3 * (size_t)j, 3 * sizeof *a->positions) &&
         (!a->texture ||
          !memcmp(a->texture + 2 * (size_t)i, b->texture + 2 * (size_t)j, 2 * sizeof *a->texture));
}

/* The slot of the vertex of encoded that is like this one, or the empty slot where it would stand. */
static uint64_t find(const fvv_mesh *encoded, const uint32_t *table, uint64_t slots, const fvv_mesh *mesh,
                     uint32_t vertex) {
  uint64_t slot = hash_of(mesh, vertex) & (slots - 1);
  while (table[slot] != EMPTY && !alike(mesh, vertex, encoded, table[slot])) slot = (slot + 1) & (slots - 1);
  return slot;
}

fvv_status fvv_mesh_match(const fvv_mesh *decoded, const fvv_mesh *encoded, const fvv_allocator *allocator,
                          uint32_t *vertices, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (decoded->texture_bits != encoded->texture_bits)
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, 0, 0, 0, "%u texture bits decoded, %u encoded",
                    decoded->texture_bits, encoded->texture_bits);
  const fvv_allocator memory = fvv_allocator_or_default(allocator);
  const uint64_t slots = fvv_hash_slots(encoded->vertex_count);
  uint32_t *table =
      slots > SIZE_MAX / sizeof *table ? NULL : fvv_allocate(&memory, (size_t)slots * sizeof *table);
  if (!table)
    return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory to match %lu vertices",
                    (unsigned long)encoded->vertex_count);
  memset(table, 0xff, (size_t)slots * sizeof *table);
  for (uint32_t v = 0; v < encoded->vertex_count; v++) table[find(encoded, table, slots, encoded, v)] = v;
  fvv_status status = FVV_OK;
  for (uint32_t v = 0; v < decoded->vertex_count && status == FVV_OK; v++) {
    vertices[v] = table[find(encoded, table, slots, decoded, v)];
    if (vertices[v] == EMPTY)
      status = fvv_fail(diagnostic, FVV_ERROR_INPUT, 0, 0, 0,
                        "decoded vertex %lu is none of those that were encoded", (unsigned long)v);
  }
  fvv_release(&memory, table, (size_t)slots * sizeof *table);
  return status;
}
