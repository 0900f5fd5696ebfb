/* The canonicaliser: a mesh in metres, as somebody's reconstruction left it, becomes a mesh on the lattice
 * that every encoder can take. It says what it changed and refuses what it cannot mend; it knows nothing of
 * payloads. Each step leaves the order of what stays alone, so that the result depends on nothing but the
 * source. */
#include <math.h>
#include <string.h>

#include "base/diagnostic.h"
#include "base/memory.h"
#include "fvv/mesh.h"
#include "mesh/hash.h"
#include "mesh/lattice.h"
#include "mesh/topology.h"

#define EMPTY UINT32_MAX
/* Half-edges are counted in 32 bits, and tables have twice as many slots as entries. */
#define COUNT_MAX ((uint32_t)1 << 30)

/* All that the steps share. points and faces shrink from step to step; the capacities stay what was
 * allocated. */
typedef struct work {
  const fvv_mesh_source *source;
  fvv_mesh_options options;
  fvv_allocator allocator;
  fvv_mesh_report report;
  fvv_diagnostic *diagnostic;
  int32_t *points;   /* 3 * point_count of 3 * source->vertex_count */
  uint32_t *renamed; /* source vertex -> point */
  uint32_t *faces;   /* 3 * face_count of 3 * source->face_count */
  uint32_t *table;   /* slots of whichever step is running */
  uint64_t slots;
  uint32_t point_count;
  uint32_t face_count;
} work;

void fvv_mesh_options_default(fvv_mesh_options *options) {
  memset(options, 0, sizeof *options);
  options->struct_size = sizeof *options;
  /* 1 mm: a third of what a pixel of an HD camera covers on a person. */
  options->lattice_step = 0.001;
}

void fvv_mesh_free(fvv_mesh *mesh) {
  if (mesh->allocator.resize) {
    fvv_release(&mesh->allocator, mesh->positions, (size_t)mesh->vertex_count * 3 * sizeof(int32_t));
    fvv_release(&mesh->allocator, mesh->faces, (size_t)mesh->face_count * 3 * sizeof(uint32_t));
  }
  memset(mesh, 0, sizeof *mesh);
}

static fvv_status out_of_memory(work *w) {
  return fvv_fail(w->diagnostic, FVV_ERROR_MEMORY, 0, 0, 0,
                  "no memory to canonicalise a mesh of %zu vertices and %zu faces", w->source->vertex_count,
                  w->source->face_count);
}

static fvv_status check_options(work *w) {
  const fvv_mesh_options *o = &w->options;
  int good = isfinite(o->lattice_step) && o->lattice_step > 0;
  for (int k = 0; k < 3; k++) good = good && isfinite(o->lattice_origin[k]);
  if (good) return FVV_OK;
  return fvv_fail(w->diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0,
                  "lattice origin (%g, %g, %g) and step %g must be finite, the step positive",
                  o->lattice_origin[0], o->lattice_origin[1], o->lattice_origin[2], o->lattice_step);
}

static fvv_status check_counts(work *w) {
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

/* A cleared table for so many entries, in place of the former one. */
static fvv_status table_for(work *w, uint64_t entries) {
  fvv_release(&w->allocator, w->table, (size_t)w->slots * sizeof *w->table);
  w->slots = fvv_hash_slots(entries);
  w->table = w->slots > SIZE_MAX / sizeof *w->table
                 ? NULL
                 : fvv_allocate(&w->allocator, (size_t)w->slots * sizeof *w->table);
  if (!w->table) return out_of_memory(w);
  memset(w->table, 0xff, (size_t)w->slots * sizeof *w->table);
  return FVV_OK;
}

static fvv_status allocate(work *w) {
  w->points = fvv_allocate_array(&w->allocator, w->source->vertex_count, 3 * sizeof *w->points);
  w->renamed = fvv_allocate_array(&w->allocator, w->source->vertex_count, sizeof *w->renamed);
  w->faces = fvv_allocate_array(&w->allocator, w->source->face_count, 3 * sizeof *w->faces);
  return w->points && w->renamed && w->faces ? FVV_OK : out_of_memory(w);
}

static void release(work *w) {
  fvv_release(&w->allocator, w->points, w->source->vertex_count * 3 * sizeof *w->points);
  fvv_release(&w->allocator, w->renamed, w->source->vertex_count * sizeof *w->renamed);
  fvv_release(&w->allocator, w->faces, w->source->face_count * 3 * sizeof *w->faces);
  fvv_release(&w->allocator, w->table, (size_t)w->slots * sizeof *w->table);
}

static fvv_status quantise(work *w, size_t vertex, int32_t point[3]) {
  const double step = w->options.lattice_step;
  for (int k = 0; k < 3; k++) {
    const double x = w->source->positions[3 * vertex + (size_t)k], origin = w->options.lattice_origin[k];
    if (!isfinite(x))
      return fvv_fail(w->diagnostic, FVV_ERROR_INPUT, 0, 0, 0, "vertex %zu: %c is %s, not a finite number",
                      vertex, "xyz"[k],
                      isnan(x) ? "NaN"
                      : x < 0  ? "-infinity"
                               : "infinity");
    if (!fvv_lattice_quantise(x, origin, step, &point[k]))
      return fvv_fail(w->diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_LATTICE, 0, 0,
                      "vertex %zu: %c = %g m lies more than 2^28 steps of %g m from the origin %g m", vertex,
                      "xyz"[k], x, step, origin);
    const double product = step * (double)point[k], error = fabs(x - (origin + product));
    if (error > w->report.max_error) w->report.max_error = error;
  }
  return FVV_OK;
}

/* The first vertex of a lattice point stands for all of them. */
static fvv_status weld(work *w) {
  fvv_status status = table_for(w, w->source->vertex_count);
  for (size_t v = 0; status == FVV_OK && v < w->source->vertex_count; v++) {
    int32_t *point = w->points + 3 * (size_t)w->point_count;
    status = quantise(w, v, point);
    if (status != FVV_OK) break;
    uint64_t slot = fvv_hash3((uint32_t)point[0], (uint32_t)point[1], (uint32_t)point[2]) & (w->slots - 1);
    while (w->table[slot] != EMPTY &&
           memcmp(w->points + 3 * (size_t)w->table[slot], point, 3 * sizeof *point) != 0)
      slot = (slot + 1) & (w->slots - 1);
    if (w->table[slot] == EMPTY)
      w->table[slot] = w->point_count++;
    else
      w->report.welded_vertices++;
    w->renamed[v] = w->table[slot];
  }
  return status;
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

static int degenerate(const work *w, const uint32_t face[3]) {
  if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) return 1;
  const int32_t *p = w->points;
  return zero_area(p + 3 * (size_t)face[0], p + 3 * (size_t)face[1], p + 3 * (size_t)face[2]);
}

static void sort3(const uint32_t face[3], uint32_t sorted[3]) {
  const uint32_t a = face[0], b = face[1], c = face[2];
  const uint32_t low = a < b ? a : b, high = a < b ? b : a;
  sorted[0] = low < c ? low : c;
  sorted[1] = low < c ? (high < c ? high : c) : low;
  sorted[2] = high < c ? c : high;
}

/* Keeps the first of the faces with the same three corners, and none that is degenerate. */
static fvv_status gather_faces(work *w) {
  const fvv_status status = table_for(w, w->source->face_count);
  if (status != FVV_OK) return status;
  for (size_t f = 0; f < w->source->face_count; f++) {
    uint32_t *face = w->faces + 3 * (size_t)w->face_count, key[3], other[3];
    for (size_t c = 0; c < 3; c++) face[c] = w->renamed[w->source->faces[3 * f + c]];
    if (degenerate(w, face)) {
      w->report.degenerate_faces++;
      continue;
    }
    sort3(face, key);
    uint64_t slot = fvv_hash3(key[0], key[1], key[2]) & (w->slots - 1);
    for (; w->table[slot] != EMPTY; slot = (slot + 1) & (w->slots - 1)) {
      sort3(w->faces + 3 * (size_t)w->table[slot], other);
      if (!memcmp(key, other, sizeof key)) break;
    }
    if (w->table[slot] == EMPTY)
      w->table[slot] = w->face_count++;
    else
      w->report.duplicate_faces++;
  }
  return FVV_OK;
}

static fvv_status drop_specks(work *w) {
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
        memmove(w->faces + 3 * (size_t)w->face_count++, w->faces + 3 * (size_t)f, 3 * sizeof *w->faces);
      }
    }
  } else {
    status = out_of_memory(w);
  }
  fvv_release(&w->allocator, members, size);
  fvv_topology_free(&topology);
  return status;
}

static fvv_status orient(work *w) {
  fvv_topology topology;
  fvv_status status = fvv_topology_build(w->faces, w->face_count, &w->allocator, &topology);
  w->report.boundary_edges = topology.boundary_edges;
  w->report.nonmanifold_edges = topology.nonmanifold_edges;
  if (status == FVV_OK && !w->options.keep_winding)
    status = fvv_topology_orient(&topology, w->faces, &w->report.flipped_faces);
  fvv_topology_free(&topology);
  return status == FVV_OK ? FVV_OK : out_of_memory(w);
}

static fvv_status no_face_left(work *w) {
  return fvv_fail(
      w->diagnostic, FVV_ERROR_INPUT, 0, 0, 0,
      "no face is left of %zu: %lu degenerate, %lu duplicate, %lu in components of fewer than %lu",
      w->source->face_count, (unsigned long)w->report.degenerate_faces,
      (unsigned long)w->report.duplicate_faces, (unsigned long)w->report.dropped_component_faces,
      (unsigned long)w->options.min_component_faces);
}

/* Drops points without faces and hands the rest over in blocks of exact size. */
static fvv_status hand_over(work *w, fvv_mesh *mesh) {
  uint32_t *used = w->renamed, kept = 0;
  memset(used, 0, (size_t)w->point_count * sizeof *used);
  for (size_t i = 0; i < 3 * (size_t)w->face_count; i++) used[w->faces[i]] = 1;
  for (uint32_t p = 0; p < w->point_count; p++) kept += used[p];
  w->report.unreferenced_vertices = w->point_count - kept;
  int32_t *positions = fvv_allocate_array(&w->allocator, kept, 3 * sizeof *positions);
  uint32_t *faces = fvv_allocate_array(&w->allocator, w->face_count, 3 * sizeof *faces);
  const fvv_mesh whole = {positions, faces, kept, w->face_count, w->allocator};
  *mesh = whole;
  if (!positions || !faces) {
    fvv_mesh_free(mesh);
    return out_of_memory(w);
  }
  kept = 0;
  for (uint32_t p = 0; p < w->point_count; p++) {
    if (!used[p]) continue;
    memcpy(positions + 3 * (size_t)kept, w->points + 3 * (size_t)p, 3 * sizeof *positions);
    used[p] = kept++;
  }
  for (size_t i = 0; i < 3 * (size_t)w->face_count; i++) faces[i] = used[w->faces[i]];
  return FVV_OK;
}

static fvv_status canonicalise(work *w, fvv_mesh *mesh) {
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

fvv_status fvv_mesh_canonicalise(const fvv_mesh_source *source, const fvv_mesh_options *options,
                                 const fvv_allocator *allocator, fvv_mesh *mesh, fvv_mesh_report *report,
                                 fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  memset(mesh, 0, sizeof *mesh);
  if (report && report->struct_size < sizeof report->struct_size)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "struct_size of the report is not set");
  work w;
  memset(&w, 0, sizeof w);
  w.source = source;
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
