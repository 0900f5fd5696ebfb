/* The canonicaliser's first step: source vertices -> lattice points, texture and normal indices; alike ones
 * are welded. */
#include <math.h>
#include <string.h>

#include "base/diagnostic.h"
#include "base/memory.h"
#include "mesh/canonicalise.h"
#include "mesh/hash.h"
#include "mesh/lattice.h"
#include "mesh/octahedral.h"

fvv_status fvv_canonicalise_table(fvv_canonicalising *w, uint64_t entries) {
  fvv_release(&w->allocator, w->table, (size_t)w->slots * sizeof *w->table);
  w->slots = fvv_hash_slots(entries);
  w->table = w->slots > SIZE_MAX / sizeof *w->table
                 ? NULL
                 : fvv_allocate(&w->allocator, (size_t)w->slots * sizeof *w->table);
  if (!w->table) return fvv_canonicalise_no_memory(w);
  memset(w->table, 0xff, (size_t)w->slots * sizeof *w->table);
  return FVV_OK;
}

static fvv_status quantise(fvv_canonicalising *w, size_t vertex, int32_t point[3]) {
  const fvv_mesh_options *o = &w->options;
  const fvv_status status = fvv_lattice_point(o->lattice_origin, o->lattice_step, w->source->positions,
                                              vertex, point, w->diagnostic);
  for (size_t k = 0; status == FVV_OK && k < 3; k++) {
    const double product = o->lattice_step * (double)point[k];
    const double error = fabs(w->source->positions[3 * vertex + k] - (o->lattice_origin[k] + product));
    if (error > w->report.max_error) w->report.max_error = error;
  }
  return status;
}

/* Of a source vertex and its point in the first frame: all its points in the run. */
static uint64_t hash_of_path(const fvv_canonicalising *w, size_t vertex, const int32_t first[3]) {
  uint64_t hash = fvv_hash3((uint32_t)first[0], (uint32_t)first[1], (uint32_t)first[2]);
  for (size_t i = 0; i < w->later_count; i++) {
    const int32_t *p = w->later[i] + 3 * vertex;
    hash = fvv_mix(hash ^ fvv_hash3((uint32_t)p[0], (uint32_t)p[1], (uint32_t)p[2]));
  }
  return hash;
}

static int same_path(const fvv_canonicalising *w, size_t vertex, const int32_t first[3], uint32_t point) {
  if (memcmp(w->points + 3 * (size_t)point, first, 3 * sizeof *first) != 0) return 0;
  for (size_t i = 0; i < w->later_count; i++)
    if (memcmp(w->later[i] + 3 * vertex, w->later[i] + 3 * (size_t)w->origins[point], 3 * sizeof *first) != 0)
      return 0;
  return 1;
}

/* The first vertex of a lattice point, in a run of one path, stands for all of them. */
static fvv_status weld_positions(fvv_canonicalising *w) {
  fvv_status status = fvv_canonicalise_table(w, w->source->vertex_count);
  for (size_t v = 0; status == FVV_OK && v < w->source->vertex_count; v++) {
    int32_t *point = w->points + 3 * (size_t)w->point_count;
    status = quantise(w, v, point);
    if (status != FVV_OK) break;
    uint64_t slot = hash_of_path(w, v, point) & (w->slots - 1);
    while (w->table[slot] != FVV_EMPTY_SLOT && !same_path(w, v, point, w->table[slot]))
      slot = (slot + 1) & (w->slots - 1);
    if (w->table[slot] == FVV_EMPTY_SLOT) {
      if (w->origins) w->origins[w->point_count] = (uint32_t)v;
      w->table[slot] = w->point_count++;
    } else if (!w->placed) {
      w->report.welded_vertices++;
    }
    w->renamed[v] = w->table[slot];
  }
  return status;
}

static fvv_status quantise_texture(fvv_canonicalising *w, size_t vertex, uint32_t index[2]) {
  int clamped = 0;
  for (int k = 0; k < 2; k++) {
    const double x = w->source->texture[2 * vertex + (size_t)k];
    if (!isfinite(x))
      return fvv_fail(w->diagnostic, FVV_ERROR_INPUT, 0, 0, 0,
                      "vertex %zu: texture coordinate %c is %s, not a finite number", vertex, "uv"[k],
                      fvv_lattice_not_finite(x));
    if (x < -FVV_TEXTURE_TOLERANCE || x > 1 + FVV_TEXTURE_TOLERANCE)
      return fvv_fail(w->diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_TEXTURE_RANGE, 0, 0,
                      "vertex %zu: texture coordinate %c = %g is outside 0 to 1", vertex, "uv"[k], x);
    const double inside = x < 0 ? 0 : x > 1 ? 1 : x;
    int32_t nearest = 0;
    (void)fvv_lattice_quantise(inside, 0, 1.0 / (UINT32_C(1) << w->options.texture_bits), &nearest);
    index[k] = (uint32_t)nearest;
    clamped |= inside != x;
  }
  w->report.clamped_vertices += (uint32_t)clamped;
  return FVV_OK;
}

/* Scaled by a power of two before anything is multiplied, so that no length is too large or too small. */
static fvv_status quantise_normal(fvv_canonicalising *w, size_t vertex, uint32_t index[2]) {
  double normal[3], most = 0;
  for (int k = 0; k < 3; k++) {
    normal[k] = w->source->normals[3 * vertex + (size_t)k];
    if (!isfinite(normal[k]))
      return fvv_fail(w->diagnostic, FVV_ERROR_INPUT, 0, 0, 0,
                      "vertex %zu: %c of its normal is %s, not a finite number", vertex, "xyz"[k],
                      fvv_lattice_not_finite(normal[k]));
    if (fabs(normal[k]) > most) most = fabs(normal[k]);
  }
  if (!(most > 0))
    return fvv_fail(w->diagnostic, FVV_ERROR_INPUT, 0, 0, 0, "vertex %zu: its normal is (0, 0, 0)", vertex);
  int exponent;
  (void)frexp(most, &exponent);
  for (int k = 0; k < 3; k++) normal[k] = ldexp(normal[k], -exponent);
  fvv_octahedral_index(w->options.normal_bits, normal, index);
  return FVV_OK;
}

/* The attributes of a source vertex become those of the next vertex. */
static fvv_status quantise_attributes(fvv_canonicalising *w, size_t vertex) {
  const size_t next = 2 * (size_t)w->vertex_count;
  fvv_status status = FVV_OK;
  if (w->texture) status = quantise_texture(w, vertex, w->texture + next);
  if (status == FVV_OK && w->normals) status = quantise_normal(w, vertex, w->normals + next);
  return status;
}

static uint64_t hash_attributes(const fvv_canonicalising *w, uint32_t point, uint32_t vertex) {
  uint64_t hash = point;
  const uint32_t *const pairs[2] = {w->texture, w->normals};
  for (int i = 0; i < 2; i++)
    if (pairs[i])
      hash =
          fvv_mix(hash) ^ ((uint64_t)pairs[i][2 * (size_t)vertex] << 32 | pairs[i][2 * (size_t)vertex + 1]);
  return fvv_mix(hash);
}

static int same_attributes(const fvv_canonicalising *w, uint32_t a, uint32_t b) {
  const uint32_t *const pairs[2] = {w->texture, w->normals};
  for (int i = 0; i < 2; i++)
    if (pairs[i] && memcmp(pairs[i] + 2 * (size_t)a, pairs[i] + 2 * (size_t)b, 2 * sizeof *pairs[i]) != 0)
      return 0;
  return 1;
}

/* The first vertex of a lattice point with the same texture and normal indices stands for all of them. */
static fvv_status weld_attributes(fvv_canonicalising *w) {
  fvv_status status = fvv_canonicalise_table(w, w->source->vertex_count);
  for (size_t v = 0; status == FVV_OK && v < w->source->vertex_count; v++) {
    const uint32_t point = w->renamed[v];
    status = quantise_attributes(w, v);
    if (status != FVV_OK) break;
    uint64_t slot = hash_attributes(w, point, w->vertex_count) & (w->slots - 1);
    for (; w->table[slot] != FVV_EMPTY_SLOT; slot = (slot + 1) & (w->slots - 1)) {
      const uint32_t other = w->table[slot];
      if (w->placed[other] == point && same_attributes(w, other, w->vertex_count)) break;
    }
    if (w->table[slot] == FVV_EMPTY_SLOT) {
      w->placed[w->vertex_count] = point;
      w->table[slot] = w->vertex_count++;
    } else {
      w->report.welded_vertices++;
    }
    w->renamed[v] = w->table[slot];
  }
  return status;
}

fvv_status fvv_canonicalise_weld(fvv_canonicalising *w) {
  fvv_status status = weld_positions(w);
  if (status == FVV_OK && w->placed) status = weld_attributes(w);
  if (!w->placed) w->vertex_count = w->point_count;
  if (status == FVV_OK) w->report.seam_vertices = w->vertex_count - w->point_count;
  return status;
}
