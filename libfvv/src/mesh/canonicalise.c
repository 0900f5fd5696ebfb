/* The canonicaliser: a mesh in metres, as a reconstruction produced it, becomes a mesh on the lattice that
 * every encoder can take. It reports what it changed and refuses what it cannot mend. Each step keeps the
 * order of what remains, so that the result depends on the source alone. With texture coordinates or normals
 * several vertices may lie on one point: the steps see faces as triples of points, and the triples of
 * vertices go along. */
#include <math.h>
#include <string.h>

#include "base/diagnostic.h"
#include "base/memory.h"
#include "fvv/mesh.h"
#include "mesh/hash.h"
#include "mesh/mesh.h"
#include "mesh/normals.h"
#include "mesh/topology.h"

#define EMPTY_SLOT UINT32_MAX

/* Half-edges are counted in 32 bits, and tables have twice as many slots as entries. */
#define COUNT_MAX ((uint32_t)1 << 30)

/* All that the steps share. points and faces shrink from step to step; the capacities stay what was
 * allocated. */
typedef struct canonicalising {
  const fvv_mesh_source *source;
  fvv_mesh_options options;
  fvv_allocator allocator;
  fvv_mesh_report report;
  fvv_diagnostic *diagnostic;
  const int32_t *const *later; /* of the run: lattice indices of the source vertices in frames 1 and up */
  size_t later_count;
  uint32_t *map;     /* the caller's: source vertex -> vertex of the mesh; NULL: not wanted */
  int32_t *points;   /* 3 * point_count of 3 * source->vertex_count */
  uint32_t *origins; /* point -> the first source vertex that lies there; NULL without later frames */
  uint32_t *renamed; /* source vertex -> vertex; without attributes a vertex is a point */
  uint32_t *faces;   /* points: 3 * face_count of 3 * source->face_count */
  uint32_t *texture; /* of vertices: 2 * vertex_count of 2 * source->vertex_count; NULL: none is wanted */
  uint32_t *normals; /* indices, like texture */
  uint32_t *placed;  /* vertex -> point; NULL: no attributes, texture or normals, are wanted */
  uint32_t *corners; /* the faces' vertices, as long as faces; like placed */
  uint32_t *table;   /* slots of whichever step is running */
  uint64_t slots;
  uint32_t point_count;
  uint32_t vertex_count;
  uint32_t face_count;
} canonicalising;

static fvv_status no_memory(canonicalising *w) {
  return fvv_fail(w->diagnostic, FVV_ERROR_MEMORY, 0, 0, 0,
                  "no memory to canonicalise a mesh of %zu vertices and %zu faces", w->source->vertex_count,
                  w->source->face_count);
}

/* A cleared table for that many entries, in place of the former one. */
static fvv_status clear_table(canonicalising *w, uint64_t entries) {
  fvv_release(&w->allocator, w->table, (size_t)w->slots * sizeof *w->table);
  w->slots = fvv_hash_slots(entries);
  w->table = w->slots > SIZE_MAX / sizeof *w->table
                 ? NULL
                 : fvv_allocate(&w->allocator, (size_t)w->slots * sizeof *w->table);
  if (!w->table) return no_memory(w);
  memset(w->table, 0xff, (size_t)w->slots * sizeof *w->table);
  return FVV_OK;
}

static fvv_status quantise(canonicalising *w, size_t vertex, int32_t point[3]) {
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
static uint64_t hash_of_path(const canonicalising *w, size_t vertex, const int32_t first[3]) {
  uint64_t hash = fvv_hash3((uint32_t)first[0], (uint32_t)first[1], (uint32_t)first[2]);
  for (size_t i = 0; i < w->later_count; i++) {
    const int32_t *p = w->later[i] + 3 * vertex;
    hash = fvv_mix(hash ^ fvv_hash3((uint32_t)p[0], (uint32_t)p[1], (uint32_t)p[2]));
  }
  return hash;
}

static int same_path(const canonicalising *w, size_t vertex, const int32_t first[3], uint32_t point) {
  if (memcmp(w->points + 3 * (size_t)point, first, 3 * sizeof *first) != 0) return 0;
  for (size_t i = 0; i < w->later_count; i++)
    if (memcmp(w->later[i] + 3 * vertex, w->later[i] + 3 * (size_t)w->origins[point], 3 * sizeof *first) != 0)
      return 0;
  return 1;
}

/* The first vertex of a lattice point, in a run of one path, represents all of them. */
static fvv_status weld_positions(canonicalising *w) {
  fvv_status status = clear_table(w, w->source->vertex_count);
  for (size_t v = 0; status == FVV_OK && v < w->source->vertex_count; v++) {
    int32_t *point = w->points + 3 * (size_t)w->point_count;
    status = quantise(w, v, point);
    if (status != FVV_OK) break;
    uint64_t slot = hash_of_path(w, v, point) & (w->slots - 1);
    while (w->table[slot] != EMPTY_SLOT && !same_path(w, v, point, w->table[slot]))
      slot = (slot + 1) & (w->slots - 1);
    if (w->table[slot] == EMPTY_SLOT) {
      if (w->origins) w->origins[w->point_count] = (uint32_t)v;
      w->table[slot] = w->point_count++;
    } else if (!w->placed) {
      w->report.welded_vertices++;
    }
    w->renamed[v] = w->table[slot];
  }
  return status;
}

static fvv_status quantise_texture(canonicalising *w, size_t vertex, uint32_t index[2]) {
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
static fvv_status quantise_normal(canonicalising *w, size_t vertex, uint32_t index[2]) {
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
static fvv_status quantise_attributes(canonicalising *w, size_t vertex) {
  const size_t next = 2 * (size_t)w->vertex_count;
  fvv_status status = FVV_OK;
  if (w->texture) status = quantise_texture(w, vertex, w->texture + next);
  if (status == FVV_OK && w->normals) status = quantise_normal(w, vertex, w->normals + next);
  return status;
}

static uint64_t hash_attributes(const canonicalising *w, uint32_t point, uint32_t vertex) {
  uint64_t hash = point;
  const uint32_t *const pairs[2] = {w->texture, w->normals};
  for (int i = 0; i < 2; i++)
    if (pairs[i])
      hash =
          fvv_mix(hash) ^ ((uint64_t)pairs[i][2 * (size_t)vertex] << 32 | pairs[i][2 * (size_t)vertex + 1]);
  return fvv_mix(hash);
}

static int same_attributes(const canonicalising *w, uint32_t a, uint32_t b) {
  const uint32_t *const pairs[2] = {w->texture, w->normals};
  for (int i = 0; i < 2; i++)
    if (pairs[i] && memcmp(pairs[i] + 2 * (size_t)a, pairs[i] + 2 * (size_t)b, 2 * sizeof *pairs[i]) != 0)
      return 0;
  return 1;
}

/* The first vertex of a lattice point with the same texture and normal indices represents all of them. */
static fvv_status weld_attributes(canonicalising *w) {
  fvv_status status = clear_table(w, w->source->vertex_count);
  for (size_t v = 0; status == FVV_OK && v < w->source->vertex_count; v++) {
    const uint32_t point = w->renamed[v];
    status = quantise_attributes(w, v);
    if (status != FVV_OK) break;
    uint64_t slot = hash_attributes(w, point, w->vertex_count) & (w->slots - 1);
    for (; w->table[slot] != EMPTY_SLOT; slot = (slot + 1) & (w->slots - 1)) {
      const uint32_t other = w->table[slot];
      if (w->placed[other] == point && same_attributes(w, other, w->vertex_count)) break;
    }
    if (w->table[slot] == EMPTY_SLOT) {
      w->placed[w->vertex_count] = point;
      w->table[slot] = w->vertex_count++;
    } else {
      w->report.welded_vertices++;
    }
    w->renamed[v] = w->table[slot];
  }
  return status;
}

/* Quantises every source vertex and fills points, renamed and, with attributes, texture, normals and placed:
 * the first vertex of several that are alike represents them. Vertices are numbered as they come first. */
static fvv_status weld(canonicalising *w) {
  fvv_status status = weld_positions(w);
  if (status == FVV_OK && w->placed) status = weld_attributes(w);
  if (!w->placed) w->vertex_count = w->point_count;
  if (status == FVV_OK) w->report.seam_vertices = w->vertex_count - w->point_count;
  return status;
}

void fvv_mesh_options_default(fvv_mesh_options *options) {
  memset(options, 0, sizeof *options);
  options->struct_size = sizeof *options;
  /* 1 mm: a third of what a pixel of an HD camera covers on a person. */
  options->lattice_step = 0.001;
  options->texture_bits = 12;
}

static fvv_status check_options(canonicalising *w) {
  const fvv_mesh_options *o = &w->options;
  int good = isfinite(o->lattice_step) && o->lattice_step > 0;
  for (int k = 0; k < 3; k++) good = good && isfinite(o->lattice_origin[k]);
  if (good && o->texture_bits > FVV_TEXTURE_BITS_MAX)
    return fvv_fail(w->diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "%lu bits for a texture index, at most %d",
                    (unsigned long)o->texture_bits, FVV_TEXTURE_BITS_MAX);
  if (good && (o->normal_bits == 1 || o->normal_bits > FVV_NORMAL_BITS_MAX))
    return fvv_fail(w->diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "%lu bits for a normal index, not 2 to %d",
                    (unsigned long)o->normal_bits, FVV_NORMAL_BITS_MAX);
  if (good) return FVV_OK;
  return fvv_fail(w->diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0,
                  "lattice origin (%g, %g, %g) and step %g must be finite, the step positive",
                  o->lattice_origin[0], o->lattice_origin[1], o->lattice_origin[2], o->lattice_step);
}

static fvv_status check_counts(canonicalising *w) {
  const fvv_mesh_source *s = w->source;
  if (s->vertex_count >= COUNT_MAX || s->face_count >= COUNT_MAX)
    return fvv_fail(w->diagnostic, FVV_ERROR_INPUT, 0, 0, 0,
                    "%zu vertices and %zu faces: a mesh has fewer than 2^30 of each", s->vertex_count,
                    s->face_count);
  if (!s->vertex_count || !s->face_count)
    return fvv_fail(w->diagnostic, FVV_ERROR_INPUT, 0, 0, 0,
                    "no face is left: the source has %zu vertices and %zu faces", s->vertex_count,
                    s->face_count);
  for (size_t i = 0; i < 3 * s->face_count; i++)
    if (s->faces[i] >= s->vertex_count)
      return fvv_fail(w->diagnostic, FVV_ERROR_INPUT, 0, 0, 0, "face %zu: index %lu of %zu vertices", i / 3,
                      (unsigned long)s->faces[i], s->vertex_count);
  return FVV_OK;
}

static fvv_status allocate(canonicalising *w) {
  const size_t vertices = w->source->vertex_count, faces = w->source->face_count;
  w->points = fvv_allocate_array(&w->allocator, vertices, 3 * sizeof *w->points);
  w->renamed = fvv_allocate_array(&w->allocator, vertices, sizeof *w->renamed);
  w->faces = fvv_allocate_array(&w->allocator, faces, 3 * sizeof *w->faces);
  if (!w->points || !w->renamed || !w->faces) return no_memory(w);
  if (w->later_count && !(w->origins = fvv_allocate_array(&w->allocator, vertices, sizeof *w->origins)))
    return no_memory(w);
  const int texture = w->source->texture && w->options.texture_bits;
  const int normals = w->source->normals && w->options.normal_bits;
  if (!texture && !normals) return FVV_OK;
  if (texture) w->texture = fvv_allocate_array(&w->allocator, vertices, 2 * sizeof *w->texture);
  if (normals) w->normals = fvv_allocate_array(&w->allocator, vertices, 2 * sizeof *w->normals);
  w->placed = fvv_allocate_array(&w->allocator, vertices, sizeof *w->placed);
  w->corners = fvv_allocate_array(&w->allocator, faces, 3 * sizeof *w->corners);
  const int enough = (w->texture || !texture) && (w->normals || !normals) && w->placed && w->corners;
  return enough ? FVV_OK : no_memory(w);
}

static void release(canonicalising *w) {
  fvv_release(&w->allocator, w->points, w->source->vertex_count * 3 * sizeof *w->points);
  fvv_release(&w->allocator, w->origins, w->source->vertex_count * sizeof *w->origins);
  fvv_release(&w->allocator, w->renamed, w->source->vertex_count * sizeof *w->renamed);
  fvv_release(&w->allocator, w->faces, w->source->face_count * 3 * sizeof *w->faces);
  fvv_release(&w->allocator, w->texture, w->source->vertex_count * 2 * sizeof *w->texture);
  fvv_release(&w->allocator, w->normals, w->source->vertex_count * 2 * sizeof *w->normals);
  fvv_release(&w->allocator, w->placed, w->source->vertex_count * sizeof *w->placed);
  fvv_release(&w->allocator, w->corners, w->source->face_count * 3 * sizeof *w->corners);
  fvv_release(&w->allocator, w->table, (size_t)w->slots * sizeof *w->table);
}

static uint32_t point_of(const canonicalising *w, uint32_t vertex) {
  return w->placed ? w->placed[vertex] : vertex;
}

/* Twice the area is the length of the cross product. Differences are at most 2^29, products 2^58: exact. */
static int zero_area(const int32_t *a, const int32_t *b, const int32_t *c) {
  int64_t u[3], v[3];
  for (int k = 0; k < 3; k++) {
    u[k] = (int64_t)b[k] - a[k];
    v[k] = (int64_t)c[k] - a[k];
  }
  return u[1] * v[2] == u[2] * v[1] && u[2] * v[0] == u[0] * v[2] && u[0] * v[1] == u[1] * v[0];
}

/* In every frame of the run. */
static int degenerate(const canonicalising *w, const uint32_t face[3]) {
  if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) return 1;
  const int32_t *p = w->points;
  if (!zero_area(p + 3 * (size_t)face[0], p + 3 * (size_t)face[1], p + 3 * (size_t)face[2])) return 0;
  for (size_t i = 0; i < w->later_count; i++) {
    const int32_t *corner[3];
    for (int c = 0; c < 3; c++) corner[c] = w->later[i] + 3 * (size_t)w->origins[face[c]];
    if (!zero_area(corner[0], corner[1], corner[2])) return 0;
  }
  return 1;
}

static void sort3(const uint32_t face[3], uint32_t sorted[3]) {
  const uint32_t a = face[0], b = face[1], c = face[2];
  const uint32_t low = a < b ? a : b, high = a < b ? b : a;
  sorted[0] = low < c ? low : c;
  sorted[1] = low < c ? (high < c ? high : c) : low;
  sorted[2] = high < c ? c : high;
}

/* Whether two faces with the same three points are the sides of a sheet: opposite windings, and each with its
 * own part of the texture. face: of vertices and points. */
static int other_side(const canonicalising *w, uint32_t kept, const uint32_t face[3],
                      const uint32_t *corners) {
  if (!w->texture) return 0;
  const uint32_t *former = w->faces + 3 * (size_t)kept, *former_corners = w->corners + 3 * (size_t)kept;
  size_t at = 0;
  while (former[at] != face[0]) at++;
  if (former[(at + 1) % 3] == face[1]) return 0;
  const size_t same[3] = {at, (at + 2) % 3, (at + 1) % 3};
  for (size_t c = 0; c < 3; c++)
    if (memcmp(w->texture + 2 * (size_t)corners[c], w->texture + 2 * (size_t)former_corners[same[c]],
               2 * sizeof *w->texture) != 0)
      return 1;
  return 0;
}

/* Keeps the first of the faces with the same three points, both of a sheet with two sides, and none that is
 * degenerate. */
static fvv_status gather_faces(canonicalising *w) {
  const fvv_status status = clear_table(w, w->source->face_count);
  if (status != FVV_OK) return status;
  for (size_t f = 0; f < w->source->face_count; f++) {
    uint32_t *face = w->faces + 3 * (size_t)w->face_count, key[3], other[3];
    for (size_t c = 0; c < 3; c++) {
      const uint32_t vertex = w->renamed[w->source->faces[3 * f + c]];
      face[c] = point_of(w, vertex);
      if (w->corners) w->corners[3 * (size_t)w->face_count + c] = vertex;
    }
    if (degenerate(w, face)) {
      w->report.degenerate_faces++;
      continue;
    }
    sort3(face, key);
    uint64_t slot = fvv_hash3(key[0], key[1], key[2]) & (w->slots - 1);
    for (; w->table[slot] != EMPTY_SLOT; slot = (slot + 1) & (w->slots - 1)) {
      sort3(w->faces + 3 * (size_t)w->table[slot], other);
      if (!memcmp(key, other, sizeof key) &&
          !other_side(w, w->table[slot], face, w->corners ? w->corners + 3 * (size_t)w->face_count : NULL))
        break;
    }
    if (w->table[slot] == EMPTY_SLOT)
      w->table[slot] = w->face_count++;
    else
      w->report.duplicate_faces++;
  }
  return FVV_OK;
}

static fvv_status drop_specks(canonicalising *w) {
  fvv_topology topology;
  fvv_status status = fvv_topology_build(w->faces, w->face_count, &w->allocator, &topology);
  const size_t size = (size_t)w->face_count * sizeof(uint32_t);
  uint32_t *members = status == FVV_OK ? fvv_allocate_zeroed(&w->allocator, size) : NULL;
  if (members) {
    const uint32_t all = w->face_count, least = w->options.min_component_faces;
    for (uint32_t f = 0; f < all; f++) members[fvv_topology_group(&topology, f)]++;
    w->face_count = 0;
    for (uint32_t f = 0; f < all; f++) {
      const uint32_t group = fvv_topology_group(&topology, f);
      if (members[group] < least) {
        w->report.dropped_components += group == f;
        w->report.dropped_component_faces++;
      } else {
        const size_t to = 3 * (size_t)w->face_count++, from = 3 * (size_t)f;
        memmove(w->faces + to, w->faces + from, 3 * sizeof *w->faces);
        if (w->corners) memmove(w->corners + to, w->corners + from, 3 * sizeof *w->corners);
      }
    }
  } else {
    status = no_memory(w);
  }
  fvv_release(&w->allocator, members, size);
  fvv_topology_free(&topology);
  return status;
}

/* The three points of a face differ, so that a turned one shows. */
static void turn_corners(canonicalising *w) {
  for (size_t f = 0; f < w->face_count; f++) {
    uint32_t *corners = w->corners + 3 * f;
    if (w->faces[3 * f + 1] == point_of(w, corners[1])) continue;
    const uint32_t corner = corners[1];
    corners[1] = corners[2];
    corners[2] = corner;
  }
}

static fvv_status orient(canonicalising *w) {
  fvv_topology topology;
  fvv_status status = fvv_topology_build(w->faces, w->face_count, &w->allocator, &topology);
  w->report.boundary_edges = topology.boundary_edges;
  w->report.nonmanifold_edges = topology.nonmanifold_edges;
  if (status == FVV_OK && !w->options.keep_winding)
    status = fvv_topology_orient(&topology, w->faces, &w->report.flipped_faces);
  if (status == FVV_OK && w->corners) turn_corners(w);
  fvv_topology_free(&topology);
  return status == FVV_OK ? FVV_OK : no_memory(w);
}

static fvv_status no_face_left(canonicalising *w) {
  return fvv_fail(
      w->diagnostic, FVV_ERROR_INPUT, 0, 0, 0,
      "no face is left of %zu: %lu degenerate, %lu duplicate, %lu in components of fewer than %lu",
      w->source->face_count, (unsigned long)w->report.degenerate_faces,
      (unsigned long)w->report.duplicate_faces, (unsigned long)w->report.dropped_component_faces,
      (unsigned long)w->options.min_component_faces);
}

/* Drops vertices without faces and hands the rest over in blocks of exact size. */
static fvv_status hand_over(canonicalising *w, fvv_mesh *mesh) {
  const size_t sources = w->source->vertex_count;
  const uint32_t *corners = w->corners ? w->corners : w->faces;
  uint32_t *used = w->renamed, kept = 0;
  if (w->map) memcpy(w->map, w->renamed, sources * sizeof *w->map);
  memset(used, 0, (size_t)w->vertex_count * sizeof *used);
  for (size_t i = 0; i < 3 * (size_t)w->face_count; i++) used[corners[i]] = 1;
  for (uint32_t v = 0; v < w->vertex_count; v++) kept += used[v];
  w->report.unreferenced_vertices = w->vertex_count - kept;
  mesh->allocator = w->allocator;
  mesh->vertex_count = kept;
  mesh->face_count = w->face_count;
  mesh->texture_bits = w->texture ? (uint8_t)w->options.texture_bits : 0;
  mesh->normal_bits = w->normals ? (uint8_t)w->options.normal_bits : 0;
  if (!fvv_mesh_allocate(mesh)) {
    fvv_mesh_free(mesh);
    return no_memory(w);
  }
  kept = 0;
  for (uint32_t v = 0; v < w->vertex_count; v++) {
    if (!used[v]) {
      used[v] = EMPTY_SLOT;
      continue;
    }
    memcpy(mesh->lattice + 3 * (size_t)kept, w->points + 3 * (size_t)point_of(w, v),
           3 * sizeof *mesh->lattice);
    if (w->texture)
      memcpy(mesh->texture + 2 * (size_t)kept, w->texture + 2 * (size_t)v, 2 * sizeof *mesh->texture);
    if (w->normals)
      memcpy(mesh->normals + 2 * (size_t)kept, w->normals + 2 * (size_t)v, 2 * sizeof *mesh->normals);
    used[v] = kept++;
  }
  for (size_t i = 0; i < 3 * (size_t)w->face_count; i++) mesh->faces[i] = used[corners[i]];
  for (size_t v = 0; w->map && v < sources; v++) w->map[v] = used[w->map[v]];
  return FVV_OK;
}

static fvv_status canonicalise(canonicalising *w, fvv_mesh *mesh) {
  fvv_status status = check_options(w);
  if (status == FVV_OK) status = check_counts(w);
  if (status == FVV_OK) status = allocate(w);
  if (status == FVV_OK) status = weld(w);
  if (status == FVV_OK) status = gather_faces(w);
  if (status == FVV_OK && w->face_count && w->options.min_component_faces > 1) status = drop_specks(w);
  if (status == FVV_OK && !w->face_count) status = no_face_left(w);
  if (status == FVV_OK) status = orient(w);
  if (status == FVV_OK) status = hand_over(w, mesh);
  return status;
}

fvv_status fvv_mesh_canonicalise_run(const fvv_mesh_source *source, const int32_t *const *later,
                                     size_t later_count, const fvv_mesh_options *options,
                                     const fvv_allocator *allocator, fvv_mesh *mesh, uint32_t *vertices,
                                     fvv_mesh_report *report, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  memset(mesh, 0, sizeof *mesh);
  if (report && report->struct_size < sizeof report->struct_size)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "struct_size of the report is not set");
  canonicalising w;
  memset(&w, 0, sizeof w);
  w.source = source;
  w.later = later;
  w.later_count = later_count;
  w.map = vertices;
  w.diagnostic = diagnostic;
  w.allocator = fvv_allocator_or_default(allocator);
  fvv_mesh_options_default(&w.options);
  memcpy(&w.options, options,
         options->struct_size < sizeof w.options ? options->struct_size : sizeof w.options);
  const fvv_status status = canonicalise(&w, mesh);
  release(&w);
  if (report) {
    const size_t known = report->struct_size < sizeof w.report ? report->struct_size : sizeof w.report;
    w.report.struct_size = report->struct_size;
    memcpy(report, &w.report, known);
  }
  return status;
}

fvv_status fvv_mesh_canonicalise(const fvv_mesh_source *source, const fvv_mesh_options *options,
                                 const fvv_allocator *allocator, fvv_mesh *mesh, fvv_mesh_report *report,
                                 fvv_diagnostic *diagnostic) {
  return fvv_mesh_canonicalise_run(source, NULL, 0, options, allocator, mesh, NULL, report, diagnostic);
}
