/* A mesh on the lattice: rounding to it, memory for it, and the rules it keeps. */
#include "mesh/mesh.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "fvv/mesh.h"
#include "mesh/normals.h"

/* Results are rounded once (FVV-9008), which 80 bits of the x87 (2) would not do. Other methods concern
 * floats alone. */
_Static_assert(FLT_EVAL_METHOD >= 0 && FLT_EVAL_METHOD != 2, "compile for SSE2: -msse2 -mfpmath=sse");

/* The product has a name of its own so that it is rounded: FMA would give other last bits. */
static double metres_of(double origin, double step, int32_t index) {
  const double product = step * (double)index;
  return origin + product;
}

void fvv_lattice_to_metres(const double origin[3], double step, const int32_t index[3], double metres[3]) {
  for (int k = 0; k < 3; k++) metres[k] = metres_of(origin[k], step, index[k]);
}

void fvv_lattice_to_floats(const double origin[3], double step, const int32_t *indices, size_t count,
                           float *metres) {
  for (size_t i = 0; i < count; i++)
    for (size_t k = 0; k < 3; k++) metres[3 * i + k] = (float)metres_of(origin[k], step, indices[3 * i + k]);
}

/* Both factors and the product are exact in single precision: an index has at most 17 bits. */
void fvv_texture_to_floats(uint8_t bits, const uint32_t *indices, size_t count, float *uv) {
  const float step = 1.0f / (float)(UINT32_C(1) << bits);
  for (size_t i = 0; i < 2 * count; i++) uv[i] = (float)indices[i] * step;
}

int fvv_lattice_quantise(double x, double origin, double step, int32_t *index) {
  const double v = (x - origin) / step;
  /* Written so that NaN, from inf / inf, fails. The half step on either side rounds to even: inward. */
  if (!(v >= -FVV_LATTICE_MAX - 0.5 && v <= FVV_LATTICE_MAX + 0.5)) return 0;
  int32_t nearest = (int32_t)v;
  const double rest = v - nearest; /* exact: |v| < 2^29 */
  if (rest > 0.5 || (rest == 0.5 && nearest % 2)) nearest++;
  if (rest < -0.5 || (rest == -0.5 && nearest % 2)) nearest--;
  *index = nearest;
  return 1;
}

const char *fvv_lattice_not_finite(double x) {
  return isnan(x) ? "NaN" : x < 0 ? "-infinity" : "infinity";
}

fvv_status fvv_lattice_point(const double origin[3], double step, const double *metres, size_t vertex,
                             int32_t point[3], fvv_diagnostic *diagnostic) {
  for (size_t k = 0; k < 3; k++) {
    const double x = metres[3 * vertex + k];
    if (!isfinite(x))
      return fvv_fail(diagnostic, FVV_ERROR_INPUT, 0, 0, 0, "vertex %zu: %c is %s, not a finite number",
                      vertex, "xyz"[k], fvv_lattice_not_finite(x));
    if (!fvv_lattice_quantise(x, origin[k], step, &point[k]))
      return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_LATTICE, 0, 0,
                      "vertex %zu: %c = %g m lies more than 2^28 steps of %g m from the origin %g m", vertex,
                      "xyz"[k], x, step, origin[k]);
  }
  return FVV_OK;
}

fvv_status fvv_lattice_from_metres(const double origin[3], double step, const double *metres, size_t count,
                                   int32_t *indices, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_status status = FVV_OK;
  for (size_t v = 0; status == FVV_OK && v < count; v++)
    status = fvv_lattice_point(origin, step, metres, v, indices + 3 * v, diagnostic);
  return status;
}

int fvv_mesh_allocate(fvv_mesh *mesh) {
  const fvv_allocator *allocator = &mesh->allocator;
  mesh->lattice = fvv_allocate_array(allocator, mesh->vertex_count, 3 * sizeof *mesh->lattice);
  mesh->faces = fvv_allocate_array(allocator, mesh->face_count, 3 * sizeof *mesh->faces);
  if (mesh->texture_bits)
    mesh->texture = fvv_allocate_array(allocator, mesh->vertex_count, 2 * sizeof *mesh->texture);
  if (mesh->normal_bits)
    mesh->normals = fvv_allocate_array(allocator, mesh->vertex_count, 2 * sizeof *mesh->normals);
  return mesh->lattice && mesh->faces && (mesh->texture || !mesh->texture_bits) &&
         (mesh->normals || !mesh->normal_bits);
}

void fvv_mesh_free(fvv_mesh *mesh) {
  if (mesh->allocator.resize) {
    const size_t vertices = mesh->vertex_count, faces = mesh->face_count;
    fvv_release(&mesh->allocator, mesh->lattice, vertices * 3 * sizeof *mesh->lattice);
    fvv_release(&mesh->allocator, mesh->faces, faces * 3 * sizeof *mesh->faces);
    fvv_release(&mesh->allocator, mesh->texture, vertices * 2 * sizeof *mesh->texture);
    fvv_release(&mesh->allocator, mesh->normals, vertices * 2 * sizeof *mesh->normals);
  }
  memset(mesh, 0, sizeof *mesh);
}

fvv_status fvv_mesh_copy(const fvv_mesh *mesh, const fvv_allocator *allocator, fvv_mesh *copy) {
  memset(copy, 0, sizeof *copy);
  copy->allocator = fvv_allocator_or_default(allocator);
  copy->vertex_count = mesh->vertex_count;
  copy->face_count = mesh->face_count;
  copy->texture_bits = mesh->texture_bits;
  copy->normal_bits = mesh->normal_bits;
  if (!fvv_mesh_allocate(copy)) {
    fvv_mesh_free(copy);
    return FVV_ERROR_MEMORY;
  }
  const size_t vertices = mesh->vertex_count;
  memcpy(copy->lattice, mesh->lattice, vertices * 3 * sizeof *mesh->lattice);
  memcpy(copy->faces, mesh->faces, (size_t)mesh->face_count * 3 * sizeof *mesh->faces);
  if (copy->texture) memcpy(copy->texture, mesh->texture, vertices * 2 * sizeof *mesh->texture);
  if (copy->normals) memcpy(copy->normals, mesh->normals, vertices * 2 * sizeof *mesh->normals);
  return FVV_OK;
}

static fvv_status status_of(fvv_mesh_origin origin) {
  return origin == FVV_MESH_FROM_CALLER ? FVV_ERROR_INPUT : FVV_ERROR_INVALID;
}

/* Offsets of an element in a raw payload: positions, texture indices, normal indices, faces. A bitstream of
 * Draco or meshoptimizer has no bytes that belong to one element. */
static uint64_t offset_of(fvv_mesh_origin origin, uint64_t before) {
  return origin == FVV_MESH_FROM_RAW ? FVV_MESH_SIZE + before : FVV_MESH_SIZE;
}
static uint64_t position_offset(fvv_mesh_origin origin, uint64_t vertex) {
  return offset_of(origin, 12 * vertex);
}
static uint64_t texture_offset(fvv_mesh_origin origin, const fvv_mesh *mesh, uint64_t vertex) {
  return offset_of(origin, 12 * (uint64_t)mesh->vertex_count + 8 * vertex);
}
static uint64_t normal_offset(fvv_mesh_origin origin, const fvv_mesh *mesh, uint64_t vertex) {
  return offset_of(origin, (mesh->texture ? 20 : 12) * (uint64_t)mesh->vertex_count + 8 * vertex);
}
static uint64_t face_offset(fvv_mesh_origin origin, const fvv_mesh *mesh, uint64_t face) {
  const uint64_t vertex = 12 + (mesh->texture ? 8 : 0) + (mesh->normals ? 8 : 0);
  return offset_of(origin, vertex * mesh->vertex_count + 12 * face);
}

static fvv_status check_positions(const fvv_mesh *mesh, fvv_mesh_origin origin, fvv_diagnostic *diagnostic) {
  for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++)
    if (mesh->lattice[i] < -FVV_LATTICE_MAX || mesh->lattice[i] > FVV_LATTICE_MAX)
      return fvv_fail(diagnostic, status_of(origin), FVV_ISSUE_MESH_LATTICE, FVV_CHUNK_MESH,
                      position_offset(origin, i / 3), "vertex %zu: %c index %ld is outside +-2^28", i / 3,
                      "xyz"[i % 3], (long)mesh -> lattice[i]);
  return FVV_OK;
}

static fvv_status check_texture(const fvv_mesh *mesh, fvv_mesh_origin origin, fvv_diagnostic *diagnostic) {
  if ((mesh->texture != NULL) != (mesh->texture_bits != 0) || mesh->texture_bits > FVV_TEXTURE_BITS_MAX)
    return fvv_fail(diagnostic, status_of(origin), FVV_ISSUE_MESH_TEXTURE_BITS, FVV_CHUNK_MESH,
                    FVV_MESH_TEXTURE_BITS, "%u texture bits for a mesh with%s texture coordinates",
                    mesh->texture_bits, mesh->texture ? "" : "out");
  const uint32_t most = UINT32_C(1) << mesh->texture_bits;
  for (size_t i = 0; mesh->texture && i < 2 * (size_t)mesh->vertex_count; i++)
    if (mesh->texture[i] > most)
      return fvv_fail(diagnostic, status_of(origin), FVV_ISSUE_MESH_TEXTURE_RANGE, FVV_CHUNK_MESH,
                      texture_offset(origin, mesh, i / 2), "vertex %zu: %c index %lu is above 2^%u", i / 2,
                      "uv"[i % 2], (unsigned long)mesh -> texture[i], mesh -> texture_bits);
  return FVV_OK;
}

static fvv_status check_normals(const fvv_mesh *mesh, fvv_mesh_origin origin, fvv_diagnostic *diagnostic) {
  const unsigned bits = mesh->normal_bits;
  if (mesh->normals ? bits < 2 || bits > FVV_NORMAL_BITS_MAX : bits != 0)
    return fvv_fail(diagnostic, status_of(origin), FVV_ISSUE_MESH_NORMAL_BITS, FVV_CHUNK_MESH,
                    FVV_MESH_NORMAL_BITS, "%u normal bits for a mesh with%s normals", bits,
                    mesh->normals ? "" : "out");
  for (size_t i = 0; mesh->normals && i < 2 * (size_t)mesh->vertex_count; i++)
    if (mesh->normals[i] > fvv_octahedral_most(bits))
      return fvv_fail(diagnostic, status_of(origin), FVV_ISSUE_MESH_NORMAL_RANGE, FVV_CHUNK_MESH,
                      normal_offset(origin, mesh, i / 2), "vertex %zu: normal index %lu is above 2^%u - 2",
                      i / 2, (unsigned long)mesh->normals[i], bits);
  return FVV_OK;
}

static fvv_status bad_face(const fvv_mesh *mesh, fvv_mesh_origin origin, size_t f,
                           fvv_diagnostic *diagnostic) {
  const uint32_t *face = mesh->faces + 3 * f;
  const uint64_t offset = face_offset(origin, mesh, f);
  for (int c = 0; c < 3; c++)
    if (face[c] >= mesh->vertex_count)
      return fvv_fail(diagnostic, status_of(origin), FVV_ISSUE_MESH_INDEX, FVV_CHUNK_MESH, offset,
                      "face %zu: index %lu of %lu vertices", f, (unsigned long)face[c],
                      (unsigned long)mesh->vertex_count);
  return fvv_fail(diagnostic, status_of(origin), FVV_ISSUE_MESH_INDEX, FVV_CHUNK_MESH, offset,
                  "face %zu: corners %lu, %lu and %lu are not three different vertices", f,
                  (unsigned long)face[0], (unsigned long)face[1], (unsigned long)face[2]);
}

/* What the loop reads is in variables: a store of a byte may change anything that is in memory. */
static fvv_status check_faces(const fvv_mesh *mesh, fvv_mesh_origin origin, uint8_t *used,
                              fvv_diagnostic *diagnostic) {
  const uint32_t *face = mesh->faces;
  const uint32_t vertices = mesh->vertex_count, faces = mesh->face_count;
  for (uint32_t f = 0; f < faces; f++, face += 3) {
    const uint32_t a = face[0], b = face[1], c = face[2];
    if ((a >= vertices) | (b >= vertices) | (c >= vertices) | (a == b) | (b == c) | (c == a))
      return bad_face(mesh, origin, f, diagnostic);
    used[a] = used[b] = used[c] = 1;
  }
  return FVV_OK;
}

static fvv_status check_used(const fvv_mesh *mesh, fvv_mesh_origin origin, const uint8_t *used,
                             fvv_diagnostic *diagnostic) {
  for (size_t v = 0; v < mesh->vertex_count; v++)
    if (!used[v])
      return fvv_fail(diagnostic, status_of(origin), FVV_ISSUE_MESH_UNREFERENCED, FVV_CHUNK_MESH,
                      position_offset(origin, v), "vertex %zu is used by no face", v);
  return FVV_OK;
}

fvv_status fvv_mesh_check(const fvv_mesh *mesh, fvv_mesh_origin origin, const fvv_allocator *allocator,
                          fvv_diagnostic *diagnostic) {
  uint8_t *used = fvv_allocate_zeroed(allocator, mesh->vertex_count);
  if (!used)
    return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory to check a mesh of %lu vertices",
                    (unsigned long)mesh->vertex_count);
  fvv_status status = check_positions(mesh, origin, diagnostic);
  if (status == FVV_OK) status = check_texture(mesh, origin, diagnostic);
  if (status == FVV_OK) status = check_normals(mesh, origin, diagnostic);
  if (status == FVV_OK) status = check_faces(mesh, origin, used, diagnostic);
  if (status == FVV_OK) status = check_used(mesh, origin, used, diagnostic);
  fvv_release(allocator, used, mesh->vertex_count);
  return status;
}
