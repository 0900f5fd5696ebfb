/* Normals of a decoded mesh. Each face counts by its area: its cross product as it is, which needs no root
 * and no angle. On a lattice that is the most accurate choice too: short edges, whose directions rounding
 * turns most, have the least say. The sums are of integers, and every operation is rounded by itself, so that
 * all machines find the same bits. */
#include "mesh/normals.h"

#include <math.h>
#include <string.h>

#include "base/diagnostic.h"
#include "base/memory.h"
#include "mesh/check.h"
#include "mesh/hash.h"

/* Differences of lattice indices are at most 2^29, products 2^58: exact before the one rounding to double. */
static void add_face(const fvv_mesh *mesh, const uint32_t *face, const uint32_t *first, double *sums) {
  const int32_t *a = mesh->positions + 3 * (size_t)face[0], *b = mesh->positions + 3 * (size_t)face[1],
                *c = mesh->positions + 3 * (size_t)face[2];
  int64_t u[3], v[3];
  for (int k = 0; k < 3; k++) {
    u[k] = (int64_t)b[k] - a[k];
    v[k] = (int64_t)c[k] - a[k];
  }
  const double area[3] = {(double)(u[1] * v[2] - u[2] * v[1]), (double)(u[2] * v[0] - u[0] * v[2]),
                          (double)(u[0] * v[1] - u[1] * v[0])};
  for (int i = 0; i < 3; i++) {
    double *sum = sums + 3 * (size_t)(first ? first[face[i]] : face[i]);
    for (int k = 0; k < 3; k++) sum[k] += area[k];
  }
}

void fvv_normals_of_faces(const fvv_mesh *mesh, const uint32_t *first, double *normals) {
  const size_t vertices = mesh->vertex_count;
  memset(normals, 0, 3 * vertices * sizeof *normals);
  for (size_t f = 0; f < mesh->face_count; f++) add_face(mesh, mesh->faces + 3 * f, first, normals);
  for (size_t v = 0; v < vertices; v++) {
    double *n = normals + 3 * v;
    if (first && first[v] != v) { /* it stands before, and is done */
      memcpy(n, normals + 3 * (size_t)first[v], 3 * sizeof *n);
      continue;
    }
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3 && length > 0; k++) n[k] /= length;
  }
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double product[3]) {
  product[0] = a[1] * b[2] - a[2] * b[1];
  product[1] = a[2] * b[0] - a[0] * b[2];
  product[2] = a[0] * b[1] - a[1] * b[0];
}

/* Rodrigues' formula with the axis a x b, whose length is the sine: no angle is needed. */
int fvv_normal_turn(const double before[3], const double after[3], double normal[3]) {
  if (!dot(before, before) || !dot(after, after)) return 0;
  double axis[3], moved[3];
  const double cosine = dot(before, after);
  cross(before, after, axis);
  cross(axis, normal, moved);
  if (1 + cosine < 0x1p-20) {
    for (int k = 0; k < 3; k++) normal[k] = -normal[k];
    return 1;
  }
  const double along = dot(axis, normal) / (1 + cosine);
  for (int k = 0; k < 3; k++) normal[k] = cosine * normal[k] + moved[k] + along * axis[k];
  return 1;
}

/* For each vertex the first one on its point. table: slots entries, all UINT32_MAX. */
static void join(const fvv_mesh *mesh, uint32_t *table, uint64_t slots, uint32_t *first) {
  for (uint32_t v = 0; v < mesh->vertex_count; v++) {
    const int32_t *p = mesh->positions + 3 * (size_t)v;
    uint64_t slot = fvv_hash3((uint32_t)p[0], (uint32_t)p[1], (uint32_t)p[2]) & (slots - 1);
    while (table[slot] != UINT32_MAX &&
           memcmp(mesh->positions + 3 * (size_t)table[slot], p, 3 * sizeof *p) != 0)
      slot = (slot + 1) & (slots - 1);
    if (table[slot] == UINT32_MAX) table[slot] = v;
    first[v] = table[slot];
  }
}

static fvv_status compute(const fvv_mesh *mesh, const fvv_allocator *memory, float *normals) {
  const size_t vertices = mesh->vertex_count;
  const uint64_t slots = fvv_hash_slots(vertices);
  uint32_t *first = fvv_allocate_array(memory, vertices, sizeof *first);
  double *exact = fvv_allocate_array(memory, vertices, 3 * sizeof *exact);
  uint32_t *table = slots > SIZE_MAX ? NULL : fvv_allocate_array(memory, (size_t)slots, sizeof *table);
  const fvv_status status = first && exact && table ? FVV_OK : FVV_ERROR_MEMORY;
  if (status == FVV_OK) {
    memset(table, 0xff, (size_t)slots * sizeof *table);
    join(mesh, table, slots, first);
    fvv_normals_of_faces(mesh, first, exact);
    for (size_t i = 0; i < 3 * vertices; i++) normals[i] = (float)exact[i];
  }
  fvv_release(memory, first, vertices * sizeof *first);
  fvv_release(memory, exact, vertices * 3 * sizeof *exact);
  fvv_release(memory, table, (size_t)slots * sizeof *table);
  return status;
}

fvv_status fvv_mesh_normals(const fvv_mesh *mesh, const fvv_allocator *allocator, float *normals,
                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_allocator memory = fvv_allocator_or_default(allocator);
  if (!mesh->vertex_count)
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_COUNTS, 0, 0, "a mesh without vertices");
  fvv_status status = fvv_mesh_check(mesh, FVV_MESH_FROM_CALLER, &memory, diagnostic);
  if (status != FVV_OK) return status;
  if (mesh->normals) {
    fvv_normals_to_floats(mesh->normal_bits, mesh->normals, mesh->vertex_count, normals);
    return FVV_OK;
  }
  status = compute(mesh, &memory, normals);
  if (status == FVV_OK) return status;
  return fvv_fail(diagnostic, status, 0, 0, 0, "no memory for the normals of %lu vertices",
                  (unsigned long)mesh->vertex_count);
}
