/* Normals: stored as indices on the octahedron, or computed from faces. */
#include "mesh/normals.h"

#include <math.h>
#include <string.h>

#include "base/diagnostic.h"
#include "base/memory.h"
#include "fvv/mesh.h"
#include "mesh/hash.h"
#include "mesh/mesh.h"

static double sign_of(double x) {
  return x < 0 ? -1 : 1;
}

/* The fold, which is its own inverse: the lower half of the octahedron lies in the corners of the square.
 * Exact for integers. */
static void fold(double half, double at[2]) {
  const double a = at[0], b = at[1];
  at[0] = (half - fabs(b)) * sign_of(a);
  at[1] = (half - fabs(a)) * sign_of(b);
}

/* A grid point (integers within +-half) -> its vector of integers; returns the length. */
static double grid_vector(double half, double a, double b, double vector[3]) {
  double at[2] = {a, b};
  const double z = half - fabs(a) - fabs(b);
  if (z < 0) fold(half, at);
  /* An integer has no -0, which the fold makes of (half - half) * -1. */
  vector[0] = at[0] + 0.0;
  vector[1] = at[1] + 0.0;
  vector[2] = z;
  return sqrt(at[0] * at[0] + at[1] * at[1] + z * z);
}

static double half_of(unsigned bits) {
  return (double)(fvv_octahedral_most(bits) / 2);
}

void fvv_octahedral_vector(unsigned bits, const uint32_t index[2], double vector[3]) {
  const double half = half_of(bits);
  const double length = grid_vector(half, (double)index[0] - half, (double)index[1] - half, vector);
  for (int k = 0; k < 3; k++) vector[k] /= length;
}

void fvv_octahedral_index(unsigned bits, const double vector[3], uint32_t index[2]) {
  const double half = half_of(bits), sum = fabs(vector[0]) + fabs(vector[1]) + fabs(vector[2]);
  double at[2] = {vector[0] / sum * half, vector[1] / sum * half};
  if (vector[2] < 0) fold(half, at);
  const double low[2] = {floor(at[0]), floor(at[1])};
  double best = -INFINITY, chosen[2] = {0, 0};
  for (int i = 0; i < 4; i++) {
    double grid[3];
    const double a = low[0] + i % 2, b = low[1] + i / 2;
    if (fabs(a) > half || fabs(b) > half) continue;
    const double length = grid_vector(half, a, b, grid);
    const double cosine = (grid[0] * vector[0] + grid[1] * vector[1] + grid[2] * vector[2]) / length;
    if (cosine <= best) continue;
    best = cosine;
    chosen[0] = a;
    chosen[1] = b;
  }
  /* Two points of the rim that mirror each other are one on the sphere, the four corners as well. */
  const int rim[2] = {fabs(chosen[0]) == half, fabs(chosen[1]) == half};
  if (rim[1]) chosen[0] = fabs(chosen[0]);
  if (rim[0]) chosen[1] = fabs(chosen[1]);
  for (int k = 0; k < 2; k++) index[k] = (uint32_t)(chosen[k] + half);
}

void fvv_normals_to_floats(uint8_t bits, const uint32_t *indices, size_t count, float *normals) {
  for (size_t i = 0; i < count; i++) {
    double vector[3];
    fvv_octahedral_vector(bits, indices + 2 * i, vector);
    for (size_t k = 0; k < 3; k++) normals[3 * i + k] = (float)vector[k];
  }
}

/* Normals of a decoded mesh. Each face counts by its area: its cross product as it is, which needs no root
 * and no angle. On a lattice that is the most accurate choice too: short edges, whose directions rounding
 * turns most, have the least say. The sums are of integers, and every operation is rounded by itself, so that
 * all machines find the same bits. */

/* Differences of lattice indices are at most 2^29, products 2^58: exact before the one rounding to double. */
static void add_face(const fvv_mesh *mesh, const uint32_t *face, const uint32_t *first, double *sums) {
  const int32_t *a = mesh->lattice + 3 * (size_t)face[0], *b = mesh->lattice + 3 * (size_t)face[1],
                *c = mesh->lattice + 3 * (size_t)face[2];
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
    if (first && first[v] != v) { /* it is earlier, and is done */
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
    const int32_t *p = mesh->lattice + 3 * (size_t)v;
    uint64_t slot = fvv_hash3((uint32_t)p[0], (uint32_t)p[1], (uint32_t)p[2]) & (slots - 1);
    while (table[slot] != UINT32_MAX &&
           memcmp(mesh->lattice + 3 * (size_t)table[slot], p, 3 * sizeof *p) != 0)
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
