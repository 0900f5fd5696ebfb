#include "container/table.h"

#include "base/bytes.h"
#include "base/diagnostic.h"

void fvv_group_table_init(fvv_group_table *table, const fvv_allocator *allocator) {
  memset(table, 0, sizeof *table);
  table->kinds.allocator = table->entries.allocator = *allocator;
}

void fvv_group_table_free(fvv_group_table *table) {
  fvv_bytes_free(&table->kinds);
  fvv_bytes_free(&table->entries);
}

void fvv_group_table_begin(fvv_group_table *table, const fvv_chunk_header *group, uint32_t sequence) {
  table->sequence = sequence;
  table->chunk_count = 1;
  table->chain_crc = fvv_header_chain(0, group);
  table->frame_count = 0;
  table->kind_count = table->last_kind = 0;
  table->last_time = group->time;
  table->kinds.size = table->entries.size = 0;
}

/* Frames repeat the same kinds in the same order, so the row after the last one used is tried first. */
static fvv_status kind_of(fvv_group_table *table, const fvv_chunk_header *header, uint32_t *kind) {
  uint8_t row[FVV_GEND_KIND_SIZE] = {0};
  fvv_put_u32(row + FVV_GEND_KIND_TYPE, header->type);
  fvv_put_u16(row + FVV_GEND_KIND_TRACK, header->track);
  row[FVV_GEND_KIND_FLAGS] = header->flags;
  for (uint32_t i = 0; i < table->kind_count; i++) {
    *kind = (table->last_kind + 1 + i) % table->kind_count;
    if (!memcmp(table->kinds.data + *kind * sizeof row, row, sizeof row)) return FVV_OK;
  }
  if (table->kind_count == FVV_MAX_GROUP_KINDS) return FVV_ERROR_LIMIT;
  *kind = table->kind_count;
  const fvv_status status = fvv_bytes_append(&table->kinds, row, sizeof row);
  if (status == FVV_OK) table->kind_count++;
  return status;
}

fvv_status fvv_group_table_add(fvv_group_table *table, const fvv_chunk_header *header) {
  uint32_t kind = 0;
  fvv_status status = kind_of(table, header, &kind);
  if (status < 0) return status;
  uint8_t entry[30];
  size_t size = fvv_put_uleb(entry, kind);
  size += fvv_put_uleb(entry + size, header->size);
  /* Modulo 2^64: a hostile stream may have times at both ends of the range. */
  const uint64_t delta = (uint64_t)header->time - (uint64_t)table->last_time;
  int64_t signed_delta;
  memcpy(&signed_delta, &delta, sizeof delta);
  size += fvv_put_uleb(entry + size, fvv_zigzag(signed_delta));
  status = fvv_bytes_append(&table->entries, entry, size);
  if (status < 0) return status;
  if (header->track && (!table->frame_count || header->time != table->frame_time)) {
    table->frame_count++;
    table->frame_time = header->time;
  }
  table->last_kind = kind;
  table->last_time = header->time;
  table->chain_crc = fvv_header_chain(table->chain_crc, header);
  table->chunk_count++;
  return FVV_OK;
}

fvv_status fvv_group_table_encode(const fvv_group_table *table, fvv_bytes *out) {
  uint8_t fixed[FVV_GEND_SIZE];
  fvv_put_u32(fixed + FVV_GEND_SEQUENCE, table->sequence);
  fvv_put_u32(fixed + FVV_GEND_CHUNK_COUNT, table->chunk_count);
  fvv_put_u32(fixed + FVV_GEND_CHAIN_CRC, table->chain_crc);
  fvv_put_u32(fixed + FVV_GEND_FRAME_COUNT, table->frame_count);
  fvv_put_u32(fixed + FVV_GEND_KIND_COUNT, table->kind_count);
  fvv_put_u32(fixed + FVV_GEND_TABLE_SIZE, (uint32_t)table->entries.size);
  out->size = 0;
  fvv_status status = fvv_bytes_append(out, fixed, sizeof fixed);
  if (status == FVV_OK) status = fvv_bytes_append(out, table->kinds.data, table->kinds.size);
  if (status == FVV_OK) status = fvv_bytes_append(out, table->entries.data, table->entries.size);
  return status;
}

static fvv_status bad_table(fvv_diagnostic *diagnostic, size_t offset, const char *what) {
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_GROUP_TABLE, FVV_CHUNK_GROUP_END, offset, "%s",
                  what);
}

fvv_status fvv_group_table_decode(const uint8_t *payload, size_t size, uint64_t group_offset,
                                  int64_t group_start, uint64_t chunks_size, const fvv_limits *limits,
                                  fvv_bytes *out, fvv_diagnostic *diagnostic) {
  if (size < FVV_GEND_SIZE) return bad_table(diagnostic, 0, "payload is shorter than its fixed part");
  const uint32_t chunks = fvv_get_u32(payload + FVV_GEND_CHUNK_COUNT);
  const uint32_t kinds = fvv_get_u32(payload + FVV_GEND_KIND_COUNT);
  const uint32_t table_size = fvv_get_u32(payload + FVV_GEND_TABLE_SIZE);
  if (!chunks) return bad_table(diagnostic, FVV_GEND_CHUNK_COUNT, "a group has at least its GRUP chunk");
  if (kinds > FVV_MAX_GROUP_KINDS || chunks > limits->max_group_chunks)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_GROUP_END, FVV_GEND_CHUNK_COUNT,
                    "%u chunks of %u kinds, limits %u and %d", chunks, kinds, limits->max_group_chunks,
                    FVV_MAX_GROUP_KINDS);
  if (size != FVV_GEND_SIZE + (uint64_t)kinds * FVV_GEND_KIND_SIZE + table_size)
    return bad_table(diagnostic, FVV_GEND_KIND_COUNT, "payload has not the size that its counts ask for");
  /* Every entry has at least three bytes: the count is bounded by what is there before memory is asked for.
   */
  if ((uint64_t)(chunks - 1) * 3 > table_size)
    return bad_table(diagnostic, FVV_GEND_CHUNK_COUNT, "more chunks than the table has bytes for");
  out->size = 0;
  fvv_status status = fvv_bytes_reserve(out, (chunks - 1) * sizeof(fvv_chunk_info));
  if (status < 0) return status;
  const uint8_t *rows = payload + FVV_GEND_SIZE;
  fvv_cursor cursor = {payload, size, FVV_GEND_SIZE + (size_t)kinds * FVV_GEND_KIND_SIZE, 0};
  uint64_t offset = fvv_chunk_extent(FVV_GRUP_SIZE), time = (uint64_t)group_start;
  uint32_t frames = 0;
  int64_t frame_time = 0;
  for (uint32_t i = 1; i < chunks; i++) {
    const uint64_t kind = fvv_cursor_uleb(&cursor), payload_size = fvv_cursor_uleb(&cursor);
    time += (uint64_t)fvv_unzigzag(fvv_cursor_uleb(&cursor));
    if (cursor.failed || kind >= kinds) return bad_table(diagnostic, cursor.position, "entry is malformed");
    if (payload_size > chunks_size || fvv_chunk_extent(payload_size) > chunks_size - offset)
      return bad_table(diagnostic, cursor.position, "entry leads beyond the group");
    const uint8_t *row = rows + kind * FVV_GEND_KIND_SIZE;
    fvv_chunk_info info;
    memset(&info, 0, sizeof info);
    info.offset = group_offset + offset;
    info.size = payload_size;
    memcpy(&info.time, &time, sizeof time);
    info.type = fvv_get_u32(row + FVV_GEND_KIND_TYPE);
    info.track = fvv_get_u16(row + FVV_GEND_KIND_TRACK);
    info.flags = row[FVV_GEND_KIND_FLAGS];
    if (info.track && (!frames || info.time != frame_time)) {
      frames++;
      frame_time = info.time;
    }
    status = fvv_bytes_append(out, &info, sizeof info);
    if (status < 0) return status;
    offset += fvv_chunk_extent(payload_size);
  }
  if (frames != fvv_get_u32(payload + FVV_GEND_FRAME_COUNT))
    return bad_table(diagnostic, FVV_GEND_FRAME_COUNT, "table and frame count do not agree");
  if (cursor.position != size || offset != chunks_size)
    return bad_table(diagnostic, cursor.position, "table and group have not the same size");
  return FVV_OK;
}
