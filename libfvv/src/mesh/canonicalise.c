/* The canonicaliser: a mesh in metres, as somebody's reconstruction left it, becomes a mesh on the lattice
 * that every encoder can take. It says what it changed and refuses what it cannot mend; it knows nothing of
 * payloads. Each step leaves the order of what stays alone, so that the result depends on nothing but the
 * source. With texture coordinates or normals several vertices may lie on one point; the steps look at faces
 * as triples of points, and the triples of vertices go along. */
#include <math.h>
#include <string.h>

#include "base/diagnostic.h"
#include "base/memory.h"
#include "mesh/canonicalise.h"
#include "mesh/hash.h"
#include "mesh/storage.h"
#include "mesh/topology.h"

/* Half-edges are counted in 32 bits, and tables have twice as many slots as entries. */
#define COUNT_MAX ((uint32_t)1 << 30)

void fvv_mesh_options_default(fvv_mesh_options *options) {
  memset(options, 0, sizeof *options);
  options->struct_size = sizeof *options;
  /* 1 mm: a third of what a pixel of an HD camera covers on a person. */
  options->lattice_step = 0.001;
  options->texture_bits = 12;
}

fvv_status fvv_canonicalise_no_memory(fvv_canonicalising *w) {
  return fvv_fail(w->diagnostic, FVV_ERROR_MEMORY, 0, 0, 0,
                  "no memory to canonicalise a mesh of %zu vertices and %zu faces", w->source->vertex_count,
                  w->source->face_count);
}

static fvv_status check_options(fvv_canonicalising *w) {
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

static fvv_status check_counts(fvv_canonicalising *w) {
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

static fvv_status allocate(fvv_canonicalising *w) {
  const size_t vertices = w->source->vertex_count, faces = w->source->face_count;
  w->points = fvv_allocate_array(&w->allocator, vertices, 3 * sizeof *w->points);
  w->renamed = fvv_allocate_array(&w->allocator, vertices, sizeof *w->renamed);
  w->faces = fvv_allocate_array(&w->allocator, faces, 3 * sizeof *w->faces);
  if (!w->points || !w->renamed || !w->faces) return fvv_canonicalise_no_memory(w);
  if (w->later_count && !(w->origins = fvv_allocate_array(&w->allocator, vertices, sizeof *w->origins)))
    return fvv_canonicalise_no_memory(w);
  const int texture = w->source->texture && w->options.texture_bits;
  const int normals = w->source->normals && w->options.normal_bits;
  if (!texture && !normals) return FVV_OK;
  if (texture) w->texture = fvv_allocate_array(&w->allocator, vertices, 2 * sizeof *w->texture);
  if (normals) w->normals = fvv_allocate_array(&w->allocator, vertices, 2 * sizeof *w->normals);
  w->placed = fvv_allocate_array(&w->allocator, vertices, sizeof *w->placed);
  w->corners = fvv_allocate_array(&w->allocator, faces, 3 * sizeof *w->corners);
  const int enough = (w->texture || !texture) && (w->normals || !normals) && w->placed && w->corners;
  return enough ? FVV_OK : fvv_canonicalise_no_memory(w);
}

static void release(fvv_canonicalising *w) {
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

static uint32_t point_of(const fvv_canonicalising *w, uint32_t vertex) {
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
static int degenerate(const fvv_canonicalising *w, const uint32_t face[3]) {
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

/* Keeps the first of the faces with the same three points, and none that is degenerate. */
static fvv_status gather_faces(fvv_canonicalising *w) {
  const fvv_status status = fvv_canonicalise_table(w, w->source->face_count);
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
    for (; w->table[slot] != FVV_EMPTY_SLOT; slot = (slot + 1) & (w->slots - 1)) {
      sort3(w->faces + 3 * (size_t)w->table[slot], other);
      if (!memcmp(key, other, sizeof key)) break;
    }
    if (w->table[slot] == FVV_EMPTY_SLOT)
      w->table[slot] = w->face_count++;
    else
      w->report.duplicate_faces++;
  }
  return FVV_OK;
}

static fvv_status drop_specks(fvv_canonicalising *w) {
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
    status = fvv_canonicalise_no_memory(w);
  }
  fvv_release(&w->allocator, members, size);
  fvv_topology_free(&topology);
  return status;
}

/* The three points of a face differ, so that a turned one shows. */
static void turn_corners(fvv_canonicalising *w) {
  for (size_t f = 0; f < w->face_count; f++) {
    uint32_t *corners = w->corners + 3 * f;
    if (w->faces[3 * f + 1] == point_of(w, corners[1])) continue;
    const uint32_t corner = corners[1];
    corners[1] = corners[2];
    corners[2] = corner;
  }
}

static fvv_status orient(fvv_canonicalising *w) {
  fvv_topology topology;
  fvv_status status = fvv_topology_build(w->faces, w->face_count, &w->allocator, &topology);
  w->report.boundary_edges = topology.boundary_edges;
  w->report.nonmanifold_edges = topology.nonmanifold_edges;
  if (status == FVV_OK && !w->options.keep_winding)
    status = fvv_topology_orient(&topology, w->faces, &w->report.flipped_faces);
  if (status == FVV_OK && w->corners) turn_corners(w);
  fvv_topology_free(&topology);
  return status == FVV_OK ? FVV_OK : fvv_canonicalise_no_memory(w);
}

static fvv_status no_face_left(fvv_canonicalising *w) {
  return fvv_fail(
      w->diagnostic, FVV_ERROR_INPUT, 0, 0, 0,
      "no face is left of %zu: %lu degenerate, %lu duplicate, %lu in components of fewer than %lu",
      w->source->face_count, (unsigned long)w->report.degenerate_faces,
      (unsigned long)w->report.duplicate_faces, (unsigned long)w->report.dropped_component_faces,
      (unsigned long)w->options.min_component_faces);
}

/* Drops vertices without faces and hands the rest over in blocks of exact size. */
static fvv_status hand_over(fvv_canonicalising *w, fvv_mesh *mesh) {
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
    return fvv_canonicalise_no_memory(w);
  }
  kept = 0;
  for (uint32_t v = 0; v < w->vertex_count; v++) {
    if (!used[v]) {
      used[v] = FVV_EMPTY_SLOT;
      continue;
    }
    memcpy(mesh->positions + 3 * (size_t)kept, w->points + 3 * (size_t)point_of(w, v),
           3 * sizeof *mesh->positions);
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

static fvv_status canonicalise(fvv_canonicalising *w, fvv_mesh *mesh) {
  fvv_status status = check_options(w);
  if (status == FVV_OK) status = check_counts(w);
  if (status == FVV_OK) status = allocate(w);
  if (status == FVV_OK) status = fvv_canonicalise_weld(w);
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
  fvv_canonicalising w;
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
