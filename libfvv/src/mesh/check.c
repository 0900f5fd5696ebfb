#include "mesh/check.h"

#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "mesh/octahedral.h"

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
    if (mesh->positions[i] < -FVV_LATTICE_MAX || mesh->positions[i] > FVV_LATTICE_MAX)
      return fvv_fail(diagnostic, status_of(origin), FVV_ISSUE_MESH_LATTICE, FVV_CHUNK_MESH,
                      position_offset(origin, i / 3), "vertex %zu: %c index %ld is outside +-2^28", i / 3,
                      "xyz"[i % 3], (long)mesh -> positions[i]);
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

static fvv_status check_faces(const fvv_mesh *mesh, fvv_mesh_origin origin, uint8_t *used,
                              fvv_diagnostic *diagnostic) {
  for (size_t f = 0; f < mesh->face_count; f++) {
    const uint32_t *face = mesh->faces + 3 * f;
    const uint64_t offset = face_offset(origin, mesh, f);
    for (int c = 0; c < 3; c++) {
      if (face[c] >= mesh->vertex_count)
        return fvv_fail(diagnostic, status_of(origin), FVV_ISSUE_MESH_INDEX, FVV_CHUNK_MESH, offset,
                        "face %zu: index %lu of %lu vertices", f, (unsigned long)face[c],
                        (unsigned long)mesh->vertex_count);
      used[face[c]] = 1;
    }
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0])
      return fvv_fail(diagnostic, status_of(origin), FVV_ISSUE_MESH_INDEX, FVV_CHUNK_MESH, offset,
                      "face %zu: corners %lu, %lu and %lu are not three different vertices", f,
                      (unsigned long)face[0], (unsigned long)face[1], (unsigned long)face[2]);
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
