#include "mesh/fast.h"

#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"

static fvv_status broken_vertices(fvv_diagnostic *diagnostic) {
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FAST_VERTICES, FVV_CHUNK_MESH,
                  FVV_MESH_SIZE + FVV_FAST_HEADER_SIZE,
                  "the vertex stream does not decode, or not to its last byte");
}

static int32_t read_i32(const uint8_t *p) {
  const uint32_t bits = fvv_get_u32(p);
  int32_t value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static fvv_status decode_positions(const fvv_fast_streams *streams, fvv_mesh *mesh,
                                   fvv_diagnostic *diagnostic) {
  if (!fvv_fast_decode_vertices(streams->vertices, streams->vertices_size, FVV_FAST_POSITION,
                                mesh->vertex_count, mesh->lattice))
    return broken_vertices(diagnostic);
  for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++)
    mesh->lattice[i] = read_i32((const uint8_t *)&mesh->lattice[i]);
  return FVV_OK;
}

static fvv_status decode_attributes(const fvv_fast_streams *streams, uint8_t *vertices, size_t stride,
                                    fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  if (!fvv_fast_decode_vertices(streams->vertices, streams->vertices_size, stride, mesh->vertex_count,
                                vertices))
    return broken_vertices(diagnostic);
  const size_t normals = FVV_FAST_POSITION + (mesh->texture ? FVV_FAST_PAIR : 0);
  const uint8_t *p = vertices;
  for (size_t v = 0; v < mesh->vertex_count; v++, p += stride) {
    for (size_t a = 0; a < 3; a++) mesh->lattice[3 * v + a] = read_i32(p + 4 * a);
    for (size_t a = 0; mesh->texture && a < 2; a++)
      mesh->texture[2 * v + a] = fvv_get_u32(p + FVV_FAST_POSITION + 4 * a);
    for (size_t a = 0; mesh->normals && a < 2; a++)
      mesh->normals[2 * v + a] = fvv_get_u32(p + normals + 4 * a);
  }
  return FVV_OK;
}

static fvv_status decode_vertices(const fvv_fast_streams *streams, fvv_mesh *mesh,
                                  fvv_diagnostic *diagnostic) {
  const size_t stride = fvv_fast_stride(mesh->texture != NULL, mesh->normals != NULL);
  if (stride == FVV_FAST_POSITION) return decode_positions(streams, mesh, diagnostic);
  uint8_t *vertices = fvv_allocate_array(&mesh->allocator, mesh->vertex_count, stride);
  if (!vertices)
    return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory to decode %lu vertices",
                    (unsigned long)mesh->vertex_count);
  const fvv_status status = decode_attributes(streams, vertices, stride, mesh, diagnostic);
  fvv_release(&mesh->allocator, vertices, (size_t)mesh->vertex_count * stride);
  return status;
}

fvv_status fvv_fast_decode(const uint8_t *data, const fvv_mesh_header *header, fvv_mesh *mesh,
                           fvv_diagnostic *diagnostic) {
  fvv_fast_streams streams;
  fvv_status status = fvv_fast_split(data, header, &streams, diagnostic);
  if (status == FVV_OK) status = fvv_fast_check(&streams, header, diagnostic);
  if (status == FVV_OK) status = decode_vertices(&streams, mesh, diagnostic);
  if (status != FVV_OK) return status;
  if (fvv_fast_decode_faces(streams.faces, streams.faces_size, mesh->face_count, mesh->faces)) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FAST_FACES, FVV_CHUNK_MESH,
                  FVV_MESH_SIZE + FVV_FAST_HEADER_SIZE + streams.vertices_size,
                  "the index stream does not decode, or not to its last byte");
}
