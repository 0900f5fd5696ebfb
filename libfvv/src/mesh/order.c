/* The order of a decoded mesh in terms of the one that was encoded. The order depends on the faces alone
 * and on options, never on positions: so a second mesh with the same faces, whose positions are the numbers
 * of its vertices, says after decoding which vertex came to stand where. That is checked, not believed. */
#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/memory.h"
#include "mesh/payload.h"
#include "mesh/storage.h"

static fvv_status no_memory(const fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0,
                  "no memory to encode a mesh of %lu vertices and %lu faces",
                  (unsigned long)mesh->vertex_count, (unsigned long)mesh->face_count);
}

/* The numbered mesh as its decoder yields it. Faces, texture coordinates and normals are borrowed from mesh,
 * positions are the caller's: 3 * vertex_count. */
static fvv_status code_numbers(const fvv_mesh *mesh, uint8_t profile, int level, fvv_draco_coding coding,
                               int32_t *positions, const fvv_mesh *decoded, fvv_bytes *bytes,
                               fvv_mesh *numbered, fvv_diagnostic *diagnostic) {
  fvv_mesh source = *mesh;
  source.positions = positions;
  memset(positions, 0, 3 * (size_t)mesh->vertex_count * sizeof *positions);
  for (uint32_t v = 0; v < mesh->vertex_count; v++) positions[3 * (size_t)v] = (int32_t)v;
  fvv_status status;
  if (profile == FVV_MESH_FAST) {
    status = fvv_mesh_encode(&source, profile, level, &bytes->allocator, bytes, diagnostic);
    return status == FVV_OK ? fvv_mesh_decode_own(bytes, &bytes->allocator, numbered, diagnostic) : status;
  }
  /* By Draco alone: what a reader has to believe of a payload is another matter for another mesh. */
  status = fvv_draco_encode(&source, level, coding, bytes, diagnostic);
  if (status != FVV_OK) return status;
  numbered->allocator = bytes->allocator;
  numbered->vertex_count = decoded->vertex_count;
  numbered->face_count = decoded->face_count;
  numbered->texture_bits = decoded->texture_bits;
  numbered->normal_bits = decoded->normal_bits;
  if (!fvv_mesh_allocate(numbered)) return no_memory(mesh, diagnostic);
  return fvv_draco_decode(bytes->data, bytes->size, numbered, diagnostic);
}

static int same_vertex(const fvv_mesh *decoded, uint32_t i, const fvv_mesh *mesh, uint32_t j) {
  return !memcmp(decoded->positions + 3 * (size_t)i, mesh->positions + 3 * (size_t)j,
                 3 * sizeof *mesh->positions) &&
         (!mesh->texture || !memcmp(decoded->texture + 2 * (size_t)i, mesh->texture + 2 * (size_t)j,
                                    2 * sizeof *mesh->texture)) &&
         (!mesh->normals || !memcmp(decoded->normals + 2 * (size_t)i, mesh->normals + 2 * (size_t)j,
                                    2 * sizeof *mesh->normals));
}

static fvv_status read_numbers(const fvv_mesh *mesh, const fvv_mesh *decoded, const fvv_mesh *numbered,
                               uint32_t *vertices, fvv_diagnostic *diagnostic) {
  int same =
      !memcmp(decoded->faces, numbered->faces, 3 * (size_t)decoded->face_count * sizeof *decoded->faces);
  for (uint32_t v = 0; v < decoded->vertex_count && same; v++) {
    const int32_t number = numbered->positions[3 * (size_t)v];
    same = number >= 0 && (uint32_t)number < mesh->vertex_count &&
           same_vertex(decoded, v, mesh, (uint32_t)number);
    vertices[v] = (uint32_t)number;
  }
  return same ? FVV_OK
              : fvv_fail(diagnostic, FVV_ERROR_BUG, 0, 0, 0,
                         "the encoder orders the vertices of a mesh by something else than its faces");
}

static fvv_status find_order(const fvv_mesh *mesh, uint8_t profile, int level, fvv_draco_coding coding,
                             const fvv_allocator *memory, const fvv_mesh *decoded, uint32_t *vertices,
                             fvv_diagnostic *diagnostic) {
  const size_t size = 3 * (size_t)mesh->vertex_count * sizeof(int32_t);
  int32_t *positions = fvv_allocate(memory, size);
  fvv_bytes bytes = {0};
  bytes.allocator = *memory;
  fvv_mesh numbered = {0};
  fvv_status status = positions ? FVV_OK : no_memory(mesh, diagnostic);
  if (status == FVV_OK)
    status = code_numbers(mesh, profile, level, coding, positions, decoded, &bytes, &numbered, diagnostic);
  if (status == FVV_OK) status = read_numbers(mesh, decoded, &numbered, vertices, diagnostic);
  fvv_mesh_free(&numbered);
  fvv_bytes_free(&bytes);
  fvv_release(memory, positions, size);
  return status;
}

fvv_status fvv_mesh_encode_mapped(const fvv_mesh *mesh, uint8_t profile, int level,
                                  const fvv_allocator *allocator, fvv_bytes *payload, fvv_mesh *decoded,
                                  uint32_t *vertices, fvv_diagnostic *diagnostic) {
  const fvv_allocator memory = fvv_allocator_or_default(allocator);
  fvv_draco_coding coding;
  memset(decoded, 0, sizeof *decoded);
  fvv_status status = fvv_mesh_encode_telling(mesh, profile, level, &memory, payload, &coding, diagnostic);
  if (status == FVV_OK) status = fvv_mesh_decode_own(payload, &memory, decoded, diagnostic);
  if (status == FVV_OK && profile == FVV_MESH_RAW)
    for (uint32_t v = 0; v < mesh->vertex_count; v++) vertices[v] = v;
  else if (status == FVV_OK)
    status = find_order(mesh, profile, level, coding, &memory, decoded, vertices, diagnostic);
  if (status == FVV_OK) return FVV_OK;
  fvv_mesh_free(decoded);
  payload->size = 0;
  return status == FVV_ERROR_MEMORY ? no_memory(mesh, diagnostic) : status;
}
