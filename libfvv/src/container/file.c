/* container/file.c: random access. Trusts the index only after its CRC and bounds, and every chunk only after
 * its own. */
#include "container/file.h"

#include "base/bytes.h"
#include "base/checked.h"
#include "base/diagnostic.h"
#include "base/limits.h"

#include <string.h>

static size_t group_count(const fvv_file *f) {
  return f->entries.size / sizeof(fvv_index_entry);
}
static fvv_index_entry *entry_at(const fvv_file *f, size_t i) {
  return (fvv_index_entry *)f->entries.data + i;
}

static fvv_status read_bytes(fvv_file *f, uint64_t offset, void *out, size_t size,
                             fvv_diagnostic *diagnostic) {
  if (offset > f->input.size || size > f->input.size - offset)
    return fvv_fail(diagnostic, FVV_ERROR_TRUNCATED, FVV_ISSUE_CHUNK_TRUNCATED, 0, offset,
                    "%zu bytes asked for, the file ends at 0x%llx", size, (unsigned long long)f->input.size);
  if (f->input.read_at(f->input.user, offset, out, size) != FVV_OK)
    return fvv_fail(diagnostic, FVV_ERROR_IO, 0, 0, offset, "cannot read %zu bytes at 0x%llx", size,
                    (unsigned long long)offset);
  return FVV_OK;
}

fvv_status fvv_file_load(fvv_file *f, uint64_t offset, fvv_chunk_header *header, fvv_diagnostic *diagnostic) {
  uint8_t bytes[FVV_CHUNK_HEADER_SIZE];
  fvv_status status = read_bytes(f, offset, bytes, sizeof bytes, diagnostic);
  if (status < 0) return status;
  if (!fvv_header_read(header, bytes))
    return fvv_fail(diagnostic, FVV_ERROR_DAMAGED, FVV_ISSUE_CHUNK_HEADER, 0, offset,
                    "no chunk header where one is expected");
  status = fvv_header_check(header, offset, diagnostic);
  if (status < 0) return status;
  if (header->size > f->limits.max_payload)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, header->type, offset,
                    "payload of %llu bytes, limit %llu", (unsigned long long)header->size,
                    (unsigned long long)f->limits.max_payload);
  const uint64_t padded = fvv_padded(header->size), at = offset + sizeof bytes;
  if (padded > f->input.size - at)
    return fvv_fail(diagnostic, FVV_ERROR_TRUNCATED, FVV_ISSUE_CHUNK_TRUNCATED, header->type, offset,
                    "the file ends inside a chunk");
  f->buffer.size = 0;
  status = fvv_bytes_reserve(&f->buffer, (size_t)padded + 1);
  if (status < 0) return fvv_fail(diagnostic, status, 0, header->type, offset, "out of memory");
  status = read_bytes(f, at, f->buffer.data, (size_t)padded, diagnostic);
  if (status < 0) return status;
  if (fvv_crc32c(0, f->buffer.data, (size_t)header->size) != header->payload_crc)
    return fvv_fail(diagnostic, FVV_ERROR_DAMAGED, FVV_ISSUE_PAYLOAD_CRC, header->type, offset,
                    "CRC of the payload does not match");
  if (!fvv_all_zero(f->buffer.data + header->size, (size_t)(padded - header->size)))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_PADDING, header->type, at + header->size,
                    "padding is not 0");
  return FVV_OK;
}

/* Footer, then index. Any failure only means that the index has to be rebuilt. */
static fvv_status load_index(fvv_file *f, fvv_diagnostic *diagnostic) {
  const uint64_t footer_extent = fvv_chunk_extent(FVV_FOOT_SIZE);
  if (f->input.size < FVV_FILE_HEADER_SIZE + footer_extent) return FVV_ERROR_TRUNCATED;
  const uint64_t footer_offset = f->input.size - footer_extent;
  fvv_chunk_header footer, index;
  fvv_status status = fvv_file_load(f, footer_offset, &footer, diagnostic);
  if (status < 0) return status;
  if (footer.type != FVV_CHUNK_FOOTER || footer.size != FVV_FOOT_SIZE) return FVV_ERROR_TRUNCATED;
  const uint64_t index_offset = fvv_get_u64(f->buffer.data + FVV_FOOT_INDEX_OFFSET);
  const uint32_t index_crc = fvv_get_u32(f->buffer.data + FVV_FOOT_INDEX_CRC);
  if (fvv_get_u64(f->buffer.data + FVV_FOOT_FILE_SIZE) != f->input.size || index_offset >= footer_offset)
    return FVV_ERROR_INVALID;
  status = fvv_file_load(f, index_offset, &index, diagnostic);
  if (status < 0) return status;
  if (index.type != FVV_CHUNK_INDEX || index.payload_crc != index_crc ||
      index_offset + fvv_chunk_extent(index.size) != footer_offset)
    return FVV_ERROR_INVALID;
  return fvv_index_decode(f->buffer.data, (size_t)index.size, index_offset, &f->limits, &f->entries,
                          diagnostic);
}

static fvv_status open_file(fvv_file *f, fvv_diagnostic *diagnostic) {
  uint8_t header[FVV_FILE_HEADER_SIZE];
  if (f->input.size < sizeof header)
    return fvv_fail(diagnostic, FVV_ERROR_TRUNCATED, FVV_ISSUE_FILE_HEADER_TRUNCATED, 0, f->input.size,
                    f->input.size ? "the file ends inside its header" : "the file is empty");
  fvv_status status = read_bytes(f, 0, header, sizeof header, diagnostic);
  if (status == FVV_OK) status = fvv_file_header_check(header, diagnostic);
  if (status < 0) return status;
  fvv_diagnostic why = {0};
  status = load_index(f, &why);
  if (status == FVV_ERROR_MEMORY || status == FVV_ERROR_LIMIT || status == FVV_ERROR_IO) {
    if (diagnostic) *diagnostic = why;
    return status;
  }
  f->index_state = status == FVV_OK ? FVV_INDEX_PRESENT : FVV_INDEX_REBUILT;
  if (status < 0) status = fvv_file_rebuild(f, diagnostic);
  if (status < 0) return status;
  const size_t size = group_count(f) * sizeof(fvv_bytes);
  status = fvv_bytes_reserve(&f->tables, size);
  if (status < 0) return fvv_fail(diagnostic, status, 0, 0, 0, "out of memory");
  if (size) memset(f->tables.data, 0, size);
  f->tables.size = size;
  return FVV_OK;
}

enum { LIST_COUNT = 6 };

/* All that grows, and goes when the file is closed. */
static void lists_of(fvv_file *f, fvv_bytes *lists[LIST_COUNT]) {
  fvv_bytes *const all[LIST_COUNT] = {&f->entries, &f->tables,  &f->blocks,
                                      &f->damage,  &f->scanned, &f->buffer};
  memcpy(lists, all, sizeof all);
}

fvv_status fvv_file_open(const fvv_input *input, const fvv_limits *limits, const fvv_allocator *allocator,
                         fvv_file **file, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_allocator chosen = fvv_allocator_or_default(allocator);
  *file = fvv_allocate_zeroed(&chosen, sizeof **file);
  if (!*file) return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory");
  fvv_file *f = *file;
  f->allocator = chosen;
  f->limits = fvv_limits_or_default(limits);
  f->input = *input;
  fvv_bytes *lists[LIST_COUNT];
  lists_of(f, lists);
  for (size_t i = 0; i < LIST_COUNT; i++) lists[i]->allocator = chosen;
  const fvv_status status = open_file(f, diagnostic);
  if (status < 0) {
    fvv_file_close(f);
    *file = NULL;
    return fvv_fail(diagnostic, status, 0, 0, 0, "%s", fvv_status_text(status));
  }
  return FVV_OK;
}

void fvv_file_close(fvv_file *file) {
  if (!file) return;
  const fvv_allocator allocator = file->allocator;
  for (size_t i = 0; i < file->tables.size / sizeof(fvv_bytes); i++)
    fvv_bytes_free((fvv_bytes *)file->tables.data + i);
  for (size_t i = 0; i < file->blocks.size / sizeof(fvv_file_block *); i++) {
    fvv_file_block *block = ((fvv_file_block **)file->blocks.data)[i];
    fvv_bytes_free(&block->chunks);
    fvv_release(&allocator, block, sizeof *block);
  }
  fvv_bytes *lists[LIST_COUNT];
  lists_of(file, lists);
  for (size_t i = 0; i < LIST_COUNT; i++) fvv_bytes_free(lists[i]);
  fvv_release(&allocator, file, sizeof *file);
}

fvv_index_state fvv_file_index_state(const fvv_file *file) {
  return file->index_state;
}
size_t fvv_file_damage_count(const fvv_file *file) {
  return file->damage.size / sizeof(fvv_diagnostic);
}
const fvv_diagnostic *fvv_file_damage(const fvv_file *file, size_t i) {
  return i < fvv_file_damage_count(file) ? (const fvv_diagnostic *)file->damage.data + i : NULL;
}
size_t fvv_file_group_count(const fvv_file *file) {
  return group_count(file);
}
const fvv_group_info *fvv_file_group(const fvv_file *file, size_t i) {
  return i < group_count(file) ? &entry_at(file, i)->group : NULL;
}

/* GRUP as the index tells it, and GEND with its table. */
static fvv_status load_table(fvv_file *f, const fvv_index_entry *entry, fvv_bytes *chunks,
                             fvv_diagnostic *diagnostic) {
  const fvv_group_info *group = &entry->group;
  fvv_chunk_header header;
  fvv_status status = fvv_file_load(f, group->offset, &header, diagnostic);
  if (status < 0) return status;
  const uint8_t *p = f->buffer.data;
  if (header.type != FVV_CHUNK_GROUP || header.size != FVV_GRUP_SIZE ||
      fvv_get_u32(p + FVV_GRUP_SEQUENCE) != group->sequence ||
      fvv_get_i64(p + FVV_GRUP_START) != group->start || fvv_get_i64(p + FVV_GRUP_END) != group->end)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_INDEX, FVV_CHUNK_INDEX, group->offset,
                    "the index tells of another group %u", group->sequence);
  const uint64_t end = group->offset + group->size - entry->end_size;
  status = fvv_file_load(f, end, &header, diagnostic);
  if (status < 0) return status;
  if (header.type != FVV_CHUNK_GROUP_END || fvv_chunk_extent(header.size) != entry->end_size ||
      header.size < FVV_GEND_SIZE || fvv_get_u32(f->buffer.data + FVV_GEND_CHAIN_CRC) != entry->chain_crc ||
      fvv_get_u32(f->buffer.data + FVV_GEND_SEQUENCE) != group->sequence ||
      fvv_get_u32(f->buffer.data + FVV_GEND_FRAME_COUNT) != group->frame_count)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_GROUP_END, FVV_CHUNK_GROUP_END, end,
                    "end of group %u is not what the index tells", group->sequence);
  status = fvv_group_table_decode(f->buffer.data, (size_t)header.size, group->offset, group->start,
                                  group->size - entry->end_size, &f->limits, chunks, diagnostic);
  if (status < 0) fvv_diagnostic_rebase(diagnostic, end + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_GROUP_END);
  return status;
}

/* After rebuilding, a group's chunks are those scanned within its bytes. */
static fvv_status pick_scanned(const fvv_file *f, const fvv_group_info *group, fvv_bytes *chunks) {
  const fvv_chunk_info *all = (const fvv_chunk_info *)f->scanned.data;
  const size_t count = f->scanned.size / sizeof *all;
  size_t low = 0, high = count;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (all[middle].offset < group->offset)
      low = middle + 1;
    else
      high = middle;
  }
  for (high = low; high < count && all[high].offset - group->offset < group->size;) high++;
  fvv_status status = fvv_bytes_reserve(chunks, 1);
  if (status == FVV_OK && high > low)
    status = fvv_bytes_append(chunks, all + low, (high - low) * sizeof *all);
  return status;
}

fvv_status fvv_file_group_chunks(fvv_file *file, size_t group, const fvv_chunk_info **chunks, size_t *count,
                                 fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *chunks = NULL;
  *count = 0;
  if (group >= group_count(file))
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "group %zu of %zu", group, group_count(file));
  fvv_index_entry *entry = entry_at(file, group);
  fvv_bytes *table = (fvv_bytes *)file->tables.data + group;
  fvv_status status = FVV_OK;
  if (!table->data) {
    table->allocator = file->allocator;
    if (file->index_state == FVV_INDEX_REBUILT) {
      status = pick_scanned(file, &entry->group, table);
    } else {
      fvv_diagnostic why = {0};
      status = fvv_bytes_reserve(table, 1);
      if (status == FVV_OK) status = load_table(file, entry, table, &why);
      if (status <= FVV_ERROR_DAMAGED && status != FVV_ERROR_LIMIT) {
        entry->group.intact = 0;
        status = fvv_bytes_append(&file->damage, &why, sizeof why);
        if (status == FVV_OK) status = fvv_file_scan_group(file, &entry->group, table, diagnostic);
      } else if (status < 0 && diagnostic) {
        *diagnostic = why;
      }
    }
    if (status < 0) {
      fvv_bytes_free(table);
      return fvv_fail(diagnostic, status, 0, 0, entry->group.offset, "%s", fvv_status_text(status));
    }
  }
  *chunks = (const fvv_chunk_info *)table->data;
  *count = table->size / sizeof **chunks;
  return FVV_OK;
}

fvv_status fvv_file_read_chunk(fvv_file *file, const fvv_chunk_info *info, const uint8_t **payload,
                               fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *payload = NULL;
  fvv_chunk_header header;
  const fvv_status status = fvv_file_load(file, info->offset, &header, diagnostic);
  if (status < 0) return status;
  if (header.type != info->type || header.track != info->track || header.flags != info->flags ||
      header.time != info->time || header.size != info->size)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_GROUP_TABLE, header.type, info->offset,
                    "chunk is not the one that the table of its group tells of");
  *payload = file->buffer.data;
  return FVV_OK;
}
