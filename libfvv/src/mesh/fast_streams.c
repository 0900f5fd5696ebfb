#include "mesh/fast.h"

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"

/* The codecs' bitstreams: Appendix A of the glTF extension EXT_meshopt_compression. */

/* After the deltas is the vertex before the first one, filled up from the front to 32 bytes. */
#define VERTEX_TAIL 32
/* After the codes and numbers of the faces is a table of pairs. */
#define TABLE_SIZE 16
#define TABLE_ENTRIES 14

/* Two bits for each 16 bytes of deltas, filled up to a byte for each byte of a vertex and each block of 256
 * vertices, when all deltas are 0. */
static uint64_t least_vertices_size(const fvv_mesh_header *header) {
  const uint64_t stride = fvv_fast_stride(header->texture_bits, header->normal_bits);
  return 1 + stride * (((uint64_t)header->vertex_count + 63) / 64) + VERTEX_TAIL;
}

/* A byte a face. */
static uint64_t least_faces_size(uint32_t faces) {
  return 1 + (uint64_t)faces + TABLE_SIZE;
}

static fvv_status too_dense(fvv_diagnostic *diagnostic, uint64_t offset, size_t size, uint32_t count,
                            const char *elements, uint64_t least) {
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FAST_DENSITY, FVV_CHUNK_MESH, offset,
                  "%zu bytes cannot carry %lu %s, which take at least %llu", size, (unsigned long)count,
                  elements, (unsigned long long)least);
}

fvv_status fvv_fast_split(const uint8_t *data, const fvv_mesh_header *header, fvv_fast_streams *streams,
                          fvv_diagnostic *diagnostic) {
  if (header->data_size < FVV_FAST_HEADER_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FAST_SIZE, FVV_CHUNK_MESH, FVV_MESH_SIZE,
                    "%zu bytes follow the header, the size of the vertex stream has %d", header->data_size,
                    FVV_FAST_HEADER_SIZE);
  const uint32_t size = fvv_get_u32(data);
  const size_t rest = header->data_size - FVV_FAST_HEADER_SIZE;
  if (size > rest)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FAST_SIZE, FVV_CHUNK_MESH, FVV_MESH_SIZE,
                    "a vertex stream of %lu bytes, %zu follow its size", (unsigned long)size, rest);
  streams->vertices = data + FVV_FAST_HEADER_SIZE;
  streams->vertices_size = size;
  streams->faces = streams->vertices + size;
  streams->faces_size = rest - size;
  uint64_t least = least_vertices_size(header);
  if (size < least)
    return too_dense(diagnostic, FVV_MESH_VERTEX_COUNT, size, header->vertex_count, "vertices", least);
  least = least_faces_size(header->face_count);
  if (streams->faces_size < least)
    return too_dense(diagnostic, FVV_MESH_FACE_COUNT, streams->faces_size, header->face_count, "faces",
                     least);
  return FVV_OK;
}

static fvv_status check_vertices(const fvv_fast_streams *streams, size_t stride, fvv_diagnostic *diagnostic) {
  const uint64_t offset = FVV_MESH_SIZE + FVV_FAST_HEADER_SIZE;
  if (streams->vertices[0] != FVV_FAST_VERTEX_CODEC)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FAST_VERTICES, FVV_CHUNK_MESH, offset,
                    "the vertex stream begins with 0x%02x, not with 0x%02x", streams->vertices[0],
                    FVV_FAST_VERTEX_CODEC);
  const size_t tail = streams->vertices_size - VERTEX_TAIL;
  const size_t fill = VERTEX_TAIL - stride;
  if (fvv_all_zero(streams->vertices + tail, fill)) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FAST_VERTICES, FVV_CHUNK_MESH, offset + tail,
                  "the %zu bytes before the last vertex of the stream are not 0", fill);
}

static int table_is_valid(const uint8_t *table) {
  for (int i = 0; i < TABLE_ENTRIES; i++)
    if (table[i] >> 4 == 15 || (table[i] & 15) == 15) return 0;
  return fvv_all_zero(table + TABLE_ENTRIES, TABLE_SIZE - TABLE_ENTRIES);
}

static void skip_number(fvv_cursor *cursor) {
  if (fvv_cursor_uleb(cursor) > UINT32_MAX) cursor->failed = 1;
}

/* What the code of a face takes from the bytes after the codes. */
static void skip_face(uint8_t code, fvv_cursor *cursor) {
  if (code < 0xf0) {
    if ((code & 15) == 15) skip_number(cursor);
    return;
  }
  if (code < 0xfe) return;
  const uint8_t *pair = fvv_cursor_take(cursor, 1);
  if (!pair) return;
  if (code == 0xff) skip_number(cursor);
  if (*pair >> 4 == 15) skip_number(cursor);
  if ((*pair & 15) == 15) skip_number(cursor);
}

static fvv_status check_faces(const fvv_fast_streams *streams, uint32_t count, fvv_diagnostic *diagnostic) {
  const uint64_t offset = FVV_MESH_SIZE + FVV_FAST_HEADER_SIZE + streams->vertices_size;
  const uint8_t *codes = streams->faces + 1, *table = streams->faces + streams->faces_size - TABLE_SIZE;
  if (streams->faces[0] != FVV_FAST_INDEX_CODEC)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FAST_FACES, FVV_CHUNK_MESH, offset,
                    "the index stream begins with 0x%02x, not with 0x%02x", streams->faces[0],
                    FVV_FAST_INDEX_CODEC);
  if (!table_is_valid(table))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FAST_FACES, FVV_CHUNK_MESH,
                    offset + streams->faces_size - TABLE_SIZE,
                    "the table of the index stream has a 15, or other bytes than 0 at its end");
  fvv_cursor cursor = {streams->faces, streams->faces_size - TABLE_SIZE, 1 + (size_t)count, 0};
  for (uint32_t f = 0; f < count; f++) {
    skip_face(codes[f], &cursor);
    if (cursor.failed)
      return fvv_fail(
          diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FAST_FACES, FVV_CHUNK_MESH, offset + cursor.position,
          "face %lu: a number is cut, not in its shortest form, or above 2^32 - 1", (unsigned long)f);
  }
  if (cursor.position == cursor.size) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_FAST_FACES, FVV_CHUNK_MESH,
                  offset + cursor.position, "%zu bytes more than the faces take",
                  cursor.size - cursor.position);
}

fvv_status fvv_fast_check(const fvv_fast_streams *streams, const fvv_mesh_header *header,
                          fvv_diagnostic *diagnostic) {
  const fvv_status status =
      check_vertices(streams, fvv_fast_stride(header->texture_bits, header->normal_bits), diagnostic);
  return status == FVV_OK ? check_faces(streams, header->face_count, diagnostic) : status;
}
