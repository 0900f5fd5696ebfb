/* Random access to a stream: its groups by the index or by scanning, their chunks, and the configuration of
 * each. Damage is listed and skipped. */
#include "container/file.h"

#include <string.h>

#include "base/bytes.h"
#include "base/checked.h"
#include "base/diagnostic.h"
#include "base/memory.h"

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
                    "%zu bytes expected, but the file ends at 0x%llx", size,
                    (unsigned long long)f->input.size);
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
  const uint64_t most = fvv_payload_limit(&f->limits, header->type);
  if (header->size > most)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, header->type, offset,
                    "payload of %llu bytes, limit %llu", (unsigned long long)header->size,
                    (unsigned long long)most);
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

/* A stream without a usable index is read from end to end; what is found there and
 * what an intact INDX chunk lists are joined (clause 7.5). */

enum { BLOCK_SIZE = 1 << 18 };

typedef struct scan_state {
  fvv_file *file;
  fvv_file_table *found;
  fvv_bytes index;  /* fvv_index_entry of an intact INDX chunk */
  fvv_bytes blocks; /* of that chunk: fvv_index_block */
  uint64_t configuration_offset;
  uint64_t end;    /* after a valid FOOT: the stream ends there; 0: none came */
  uint32_t digest; /* of the block that is read */
  int in_block, whole_file;
} scan_state;

static fvv_index_entry *last_entry(const fvv_file *f) {
  return group_count(f) ? (fvv_index_entry *)f->entries.data + group_count(f) - 1 : NULL;
}

size_t fvv_first_from(const void *items, size_t count, size_t item_size, uint64_t offset) {
  size_t low = 0, high = count;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    uint64_t found;
    memcpy(&found, (const uint8_t *)items + middle * item_size, sizeof found);
    if (found < offset)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

const fvv_index_block *fvv_file_listed_block(const fvv_file *f, const fvv_group_info *group) {
  const fvv_index_block *blocks = (const fvv_index_block *)f->listed.data;
  const size_t count = f->listed.size / sizeof *blocks;
  const size_t i = fvv_first_from(blocks, count, sizeof *blocks, group->configuration_offset);
  return i < count && blocks[i].offset == group->configuration_offset ? &blocks[i] : NULL;
}

/* A group without GEND ends where something else begins. */
static void close_open_group(fvv_file *f, uint64_t offset) {
  fvv_index_entry *last = last_entry(f);
  if (last && !last->end_size && !last->group.size) last->group.size = offset - last->group.offset;
}

/* The block that ends where a group begins. */
static fvv_status list_block(scan_state *s, uint64_t end) {
  if (!s->in_block) return FVV_OK;
  s->in_block = 0;
  const uint64_t size = end - s->configuration_offset;
  const fvv_index_block block = {s->configuration_offset, size > UINT32_MAX ? 0 : (uint32_t)size, s->digest};
  return fvv_bytes_append(&s->file->listed, &block, sizeof block);
}

static fvv_status take_group(scan_state *s, const fvv_event *event) {
  fvv_file *f = s->file;
  close_open_group(f, event->offset);
  const fvv_status status = list_block(s, event->offset);
  if (status < 0 || event->chunk.size != FVV_GRUP_SIZE || group_count(f) >= f->limits.max_groups)
    return status;
  fvv_index_entry entry;
  memset(&entry, 0, sizeof entry);
  entry.group.offset = event->offset;
  entry.group.start = fvv_get_i64(event->payload + FVV_GRUP_START);
  entry.group.end = fvv_get_i64(event->payload + FVV_GRUP_END);
  entry.group.sequence = fvv_get_u32(event->payload + FVV_GRUP_SEQUENCE);
  entry.group.configuration_offset = s->configuration_offset;
  const fvv_index_block *block = fvv_file_listed_block(f, &entry.group);
  entry.group.configuration_size = block ? block->size : 0;
  return fvv_bytes_append(&f->entries, &entry, sizeof entry);
}

static fvv_status list_chunk(fvv_bytes *list, const fvv_event *event) {
  const fvv_chunk_header *header = &event->chunk;
  const fvv_chunk_info info = {event->offset, header->size,  header->time,
                               header->type,  header->track, header->flags};
  return fvv_bytes_append(list, &info, sizeof info);
}

static fvv_status take_chunk(scan_state *s, const fvv_event *event) {
  fvv_file *f = s->file;
  const fvv_chunk_header *header = &event->chunk;
  const fvv_place place = fvv_chunk_place(header->type, header->flags);
  if (header->type == FVV_CHUNK_SCENE) {
    s->in_block = 1;
    s->digest = 0;
  }
  if (s->in_block && (place == FVV_PLACE_CONFIGURATION || place == FVV_PLACE_UNKNOWN))
    s->digest = fvv_header_chain(s->digest, header);
  /* Its end was lost, and with it the GRUP. */
  if (place == FVV_PLACE_FRAME) {
    const fvv_status status = list_block(s, s->configuration_offset);
    if (status < 0) return status;
  }
  if (place == FVV_PLACE_FRAME || place == FVV_PLACE_UNKNOWN) {
    const int listed = place == FVV_PLACE_FRAME || event->group_intact;
    return list_chunk(listed ? &s->found->chunks : &s->found->unlisted, event);
  }
  if (!s->whole_file) return FVV_OK;
  fvv_diagnostic ignored = {0};
  fvv_index_entry *last = last_entry(f);
  switch (header->type) {
  case FVV_CHUNK_GROUP:
    return take_group(s, event);
  case FVV_CHUNK_GROUP_END:
    if (!last || last->end_size || header->time != last->group.end) return FVV_OK;
    last->end_size = (uint32_t)fvv_chunk_extent(header->size);
    last->group.size = event->offset + last->end_size - last->group.offset;
    last->group.intact = event->group_intact;
    return FVV_OK;
  case FVV_CHUNK_SCENE:
    close_open_group(f, event->offset);
    s->configuration_offset = event->offset;
    return FVV_OK;
  case FVV_CHUNK_INDEX:
    close_open_group(f, event->offset);
    if (fvv_index_decode(event->payload, (size_t)header->size, event->offset, &f->limits, &s->index,
                         &s->blocks, &ignored) < 0)
      s->index.size = 0;
    return FVV_OK;
  default:
    return FVV_OK;
  }
}

static fvv_status take_damage(scan_state *s, const fvv_event *event) {
  fvv_status status = FVV_OK;
  if (s->whole_file)
    status = fvv_bytes_append(&s->file->damage, &event->diagnostic, sizeof event->diagnostic);
  const fvv_place place = fvv_chunk_place(event->chunk.type, event->chunk.flags);
  if (status == FVV_OK && event->has_chunk && (place == FVV_PLACE_FRAME || place == FVV_PLACE_UNKNOWN))
    status = list_chunk(&s->found->unlisted, event);
  return status;
}

static fvv_status scan_events(scan_state *s, fvv_reader *reader, fvv_diagnostic *diagnostic) {
  fvv_event event;
  fvv_status status;
  while ((status = fvv_reader_next(reader, &event, diagnostic)) == FVV_OK) {
    if (event.kind == FVV_EVENT_CHUNK)
      status = take_chunk(s, &event);
    else if (event.kind == FVV_EVENT_DAMAGE)
      status = take_damage(s, &event);
    else if (event.kind == FVV_EVENT_END && s->whole_file) {
      s->end = event.offset;
      return FVV_END;
    }
    if (status < 0) return fvv_fail(diagnostic, status, 0, 0, event.offset, "%s", fvv_status_text(status));
  }
  return status;
}

static fvv_status scan_range(scan_state *s, uint64_t offset, uint64_t size, fvv_diagnostic *diagnostic) {
  fvv_file *f = s->file;
  fvv_reader *reader;
  fvv_status status = fvv_reader_create(&f->limits, &f->allocator, offset, &reader);
  if (status < 0) return fvv_fail(diagnostic, status, 0, 0, offset, "out of memory");
  f->buffer.size = 0;
  status = fvv_bytes_reserve(&f->buffer, BLOCK_SIZE);
  for (uint64_t done = 0; done < size && status >= 0 && !s->end;) {
    const size_t part = size - done < BLOCK_SIZE ? (size_t)(size - done) : BLOCK_SIZE;
    if (f->input.read_at(f->input.user, offset + done, f->buffer.data, part) != FVV_OK)
      status = fvv_fail(diagnostic, FVV_ERROR_IO, 0, 0, offset + done, "cannot read %zu bytes at 0x%llx",
                        part, (unsigned long long)(offset + done));
    else if ((status = fvv_reader_push(reader, f->buffer.data, part)) >= 0)
      status = scan_events(s, reader, diagnostic);
    done += part;
  }
  if (status >= 0 && !s->end) {
    fvv_reader_finish(reader);
    status = scan_events(s, reader, diagnostic);
  }
  fvv_reader_destroy(reader);
  if (status < 0) return fvv_fail(diagnostic, status, 0, 0, offset, "%s", fvv_status_text(status));
  return FVV_OK;
}

/* The number of frames among chunks of a group. */
static uint32_t frames_among(fvv_file *f, size_t group, const fvv_chunk_info *chunks, size_t count) {
  fvv_frame_rule rule = {f, group, 0, NULL};
  uint32_t frames = 0;
  int64_t last = 0;
  for (size_t c = 0; c < count; c++) {
    if ((frames && chunks[c].time == last) || !fvv_file_makes_frame(&rule, &chunks[c])) continue;
    frames++;
    last = chunks[c].time;
  }
  return frames;
}

/* Counts the frames among the scanned chunks of each group, for groups without a usable table. */
static void count_frames(fvv_file *f) {
  const fvv_chunk_info *chunks = (const fvv_chunk_info *)f->scanned.chunks.data;
  const size_t chunk_count = f->scanned.chunks.size / sizeof *chunks;
  fvv_index_entry *entries = (fvv_index_entry *)f->entries.data;
  size_t c = 0;
  for (size_t g = 0; g < group_count(f); g++) {
    const fvv_group_info *group = &entries[g].group;
    while (c < chunk_count && chunks[c].offset < group->offset) c++;
    const size_t begin = c;
    while (c < chunk_count && chunks[c].offset - group->offset < group->size) c++;
    if (c > begin) entries[g].group.frame_count = frames_among(f, g, chunks + begin, c - begin);
  }
}

/* Whether the scan found a group at another offset than the index states: bytes were added or lost before it.
 * What was found has rising sequence numbers unless groups are out of order; then it may be missed. */
static int is_found_elsewhere(const fvv_file *f, const fvv_group_info *listed) {
  size_t low = 0, high = group_count(f);
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (entry_at(f, middle)->group.sequence < listed->sequence)
      low = middle + 1;
    else
      high = middle;
  }
  if (low == group_count(f)) return 0;
  const fvv_group_info *found = &entry_at(f, low)->group;
  return found->sequence == listed->sequence && found->start == listed->start && found->end == listed->end;
}

/* Groups that only the index lists: their GRUP was lost, their frames may still be there. */
static fvv_status join_index(fvv_file *f, const fvv_bytes *index) {
  const fvv_index_entry *known = (const fvv_index_entry *)index->data;
  const size_t known_count = index->size / sizeof *known, found_count = group_count(f);
  fvv_bytes joined = {NULL, 0, 0, f->allocator};
  fvv_status status = FVV_OK;
  for (size_t k = 0, g = 0; (k < known_count || g < found_count) && status == FVV_OK;) {
    /* Without groups there is no array, and NULL + 0 is undefined. */
    const fvv_index_entry *found = found_count ? (fvv_index_entry *)f->entries.data + g : NULL;
    if (g < found_count && (k == known_count || found->group.offset <= known[k].group.offset)) {
      k += k < known_count && found->group.offset == known[k].group.offset;
      status = fvv_bytes_append(&joined, found, sizeof *found);
      g++;
    } else {
      fvv_index_entry lost = known[k++];
      lost.group.intact = 0;
      if (!is_found_elsewhere(f, &lost.group)) status = fvv_bytes_append(&joined, &lost, sizeof lost);
    }
  }
  fvv_bytes_free(&f->entries);
  f->entries = joined;
  return status;
}

static void forget_lists(fvv_file *f) {
  f->entries.size = f->listed.size = f->damage.size = 0;
  f->scanned.chunks.size = f->scanned.unlisted.size = 0;
}

/* Reads the whole stream, fills entries, scanned and damage. *end: after a valid FOOT, 0: there is none. */
static fvv_status rebuild(fvv_file *file, uint64_t *end, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  forget_lists(file);
  scan_state state = {.file = file, .found = &file->scanned, .whole_file = 1};
  state.index.allocator = state.blocks.allocator = file->allocator;
  fvv_status status = scan_range(&state, 0, file->input.size, diagnostic);
  *end = state.end;
  if (status == FVV_OK) {
    close_open_group(file, state.end ? state.end : file->input.size);
    status = join_index(file, &state.index);
  }
  fvv_bytes_free(&state.index);
  fvv_bytes_free(&state.blocks);
  if (status == FVV_OK) count_frames(file);
  return status;
}

/* Reads one group's bytes and lists the chunks in them: for a group whose own table is damaged. Where
 * one has a time of another group, all belong to that one. */
static fvv_status scan_group(fvv_file *file, const fvv_group_info *group, fvv_file_table *table,
                             fvv_diagnostic *diagnostic) {
  fvv_bytes *chunks = &table->chunks;
  scan_state state = {.file = file, .found = table};
  chunks->size = 0;
  const fvv_status status = scan_range(&state, group->offset, group->size, diagnostic);
  const fvv_chunk_info *chunk = (const fvv_chunk_info *)chunks->data;
  for (size_t c = 0; c < chunks->size / sizeof *chunk; c++)
    if (fvv_type_makes_frame(chunk[c].type) == 1 &&
        (chunk[c].time < group->start || chunk[c].time >= group->end))
      chunks->size = 0;
  return status;
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
  status = fvv_index_decode(f->buffer.data, (size_t)index.size, index_offset, &f->limits, &f->entries,
                            &f->listed, diagnostic);
  /* That of a long stream takes more than any other chunk. */
  fvv_bytes_free(&f->buffer);
  return status;
}

/* Where bytes follow the footer it is among these last ones, or found by scanning from the front. */
enum { TAIL_SIZE = 1 << 16 };

/* *end: of the last FOOT in the tail whose file_size is where it ends; 0: there is none. */
static fvv_status search_footer(fvv_file *f, uint64_t *end, fvv_diagnostic *diagnostic) {
  const size_t extent = (size_t)fvv_chunk_extent(FVV_FOOT_SIZE);
  const size_t size = f->input.size < TAIL_SIZE ? (size_t)f->input.size : TAIL_SIZE;
  const uint64_t begin = f->input.size - size;
  *end = 0;
  f->buffer.size = 0;
  fvv_status status = fvv_bytes_reserve(&f->buffer, TAIL_SIZE);
  if (status < 0) return fvv_fail(diagnostic, status, 0, 0, begin, "out of memory");
  status = read_bytes(f, begin, f->buffer.data, size, diagnostic);
  for (size_t at = size < extent ? 0 : size - extent + 1; status == FVV_OK && !*end && at-- > 0;) {
    const uint8_t *bytes = f->buffer.data + at, *payload = bytes + FVV_CHUNK_HEADER_SIZE;
    fvv_chunk_header header;
    if (fvv_header_read(&header, bytes) && header.type == FVV_CHUNK_FOOTER && header.size == FVV_FOOT_SIZE &&
        fvv_crc32c(0, payload, FVV_FOOT_SIZE) == header.payload_crc &&
        fvv_get_u64(payload + FVV_FOOT_FILE_SIZE) == begin + at + extent)
      *end = begin + at + extent;
  }
  return status;
}

/* Nothing after the end of the stream is looked at. */
static fvv_status end_early(fvv_file *f, uint64_t end) {
  fvv_diagnostic trailing = {0};
  fvv_fail(&trailing, FVV_ERROR_DAMAGED, FVV_ISSUE_TRAILING, 0, end, "bytes follow the footer");
  f->input.size = end;
  return fvv_bytes_append(&f->damage, &trailing, sizeof trailing);
}

static int is_final(fvv_status status) {
  return status == FVV_ERROR_MEMORY || status == FVV_ERROR_LIMIT || status == FVV_ERROR_IO;
}

/* As load_index, where bytes follow the footer, too. */
static fvv_status find_index(fvv_file *f, fvv_diagnostic *diagnostic) {
  fvv_status status = load_index(f, diagnostic);
  if (status == FVV_OK || is_final(status)) return status;
  uint64_t end;
  fvv_diagnostic_clear(diagnostic);
  const fvv_status searched = search_footer(f, &end, diagnostic);
  if (searched < 0) return searched;
  if (!end || end == f->input.size) return status;
  const uint64_t size = f->input.size;
  f->input.size = end;
  status = load_index(f, diagnostic);
  if (status == FVV_OK) return end_early(f, end);
  f->input.size = size;
  return status;
}

static fvv_status rebuild_index(fvv_file *f, fvv_diagnostic *diagnostic) {
  uint64_t end;
  fvv_status status = rebuild(f, &end, diagnostic);
  if (status < 0 || !end || end == f->input.size) return status;
  /* The footer is far before the end of the file. */
  forget_lists(f);
  f->input.size = end;
  status = load_index(f, diagnostic);
  if (status == FVV_OK)
    f->index_state = FVV_INDEX_PRESENT;
  else if (!is_final(status))
    status = rebuild(f, &end, diagnostic);
  return status < 0 ? status : end_early(f, end);
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
  status = find_index(f, &why);
  if (is_final(status)) {
    if (diagnostic) *diagnostic = why;
    return status;
  }
  f->index_state = status == FVV_OK ? FVV_INDEX_PRESENT : FVV_INDEX_REBUILT;
  if (status < 0) status = rebuild_index(f, diagnostic);
  if (status < 0) return status;
  const size_t size = group_count(f) * sizeof(fvv_file_table *);
  status = fvv_bytes_reserve(&f->tables, size);
  if (status < 0) return fvv_fail(diagnostic, status, 0, 0, 0, "out of memory");
  if (size) memset(f->tables.data, 0, size);
  f->tables.size = size;
  return FVV_OK;
}

enum { LIST_COUNT = 8 };

/* Everything that grows; freed when the file is closed. */
static void lists_of(fvv_file *f, fvv_bytes *lists[LIST_COUNT]) {
  fvv_bytes *const all[LIST_COUNT] = {&f->entries, &f->tables,         &f->listed,           &f->blocks,
                                      &f->damage,  &f->scanned.chunks, &f->scanned.unlisted, &f->buffer};
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

static void release_table(fvv_file *f, fvv_file_table **table) {
  if (!*table) return;
  fvv_bytes_free(&(*table)->chunks);
  fvv_bytes_free(&(*table)->unlisted);
  fvv_release(&f->allocator, *table, sizeof **table);
  *table = NULL;
}

void fvv_file_close(fvv_file *file) {
  if (!file) return;
  const fvv_allocator allocator = file->allocator;
  for (size_t i = 0; i < file->tables.size / sizeof(fvv_file_table *); i++)
    release_table(file, (fvv_file_table **)file->tables.data + i);
  for (size_t i = 0; i < file->blocks.size / sizeof(fvv_file_block *); i++) {
    fvv_file_block *block = ((fvv_file_block **)file->blocks.data)[i];
    fvv_file_release_block(file, block);
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

static int is_listed_digest(const fvv_file *f, const fvv_group_info *group, uint32_t digest) {
  const fvv_index_block *block = fvv_file_listed_block(f, group);
  return block && block->digest == digest;
}

/* GRUP as the index has it, and GEND with its table. */
static fvv_status load_table(fvv_file *f, const fvv_index_entry *entry, fvv_bytes *chunks,
                             fvv_diagnostic *diagnostic) {
  const fvv_group_info *group = &entry->group;
  fvv_chunk_header header;
  fvv_status status = fvv_file_load(f, group->offset, &header, diagnostic);
  if (status < 0) return status;
  const uint8_t *p = f->buffer.data;
  if (header.type != FVV_CHUNK_GROUP || header.size != FVV_GRUP_SIZE ||
      fvv_get_u32(p + FVV_GRUP_SEQUENCE) != group->sequence ||
      fvv_get_i64(p + FVV_GRUP_START) != group->start || fvv_get_i64(p + FVV_GRUP_END) != group->end ||
      !is_listed_digest(f, group, fvv_get_u32(p + FVV_GRUP_CONFIGURATION_CRC)))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_INDEX, FVV_CHUNK_INDEX, group->offset,
                    "group %u differs from its entry in the index", group->sequence);
  const uint64_t end = group->offset + group->size - entry->end_size;
  status = fvv_file_load(f, end, &header, diagnostic);
  if (status < 0) return status;
  if (header.type != FVV_CHUNK_GROUP_END || fvv_chunk_extent(header.size) != entry->end_size ||
      header.size < FVV_GEND_SIZE || fvv_get_u32(f->buffer.data + FVV_GEND_CHAIN_CRC) != entry->chain_crc ||
      fvv_get_u32(f->buffer.data + FVV_GEND_SEQUENCE) != group->sequence ||
      fvv_get_u32(f->buffer.data + FVV_GEND_FRAME_COUNT) != group->frame_count)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_GROUP_END, FVV_CHUNK_GROUP_END, end,
                    "end of group %u differs from its entry in the index", group->sequence);
  status = fvv_group_table_decode(f->buffer.data, (size_t)header.size, group->offset, group->start,
                                  group->size - entry->end_size, &f->limits, chunks, diagnostic);
  if (status < 0) fvv_diagnostic_rebase(diagnostic, end + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_GROUP_END);
  if (status < 0) return status;
  const size_t number = (size_t)(entry - (const fvv_index_entry *)f->entries.data);
  const size_t count = chunks->size / sizeof(fvv_chunk_info);
  if (frames_among(f, number, (const fvv_chunk_info *)chunks->data, count) != group->frame_count)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_GROUP_TABLE, FVV_CHUNK_GROUP_END,
                    end + FVV_CHUNK_HEADER_SIZE + FVV_GEND_FRAME_COUNT,
                    "table does not match the frame count");
  return status;
}

/* After rebuilding, a group's chunks are those scanned within its bytes. */
static fvv_status pick_scanned(const fvv_bytes *scanned, const fvv_group_info *group, fvv_bytes *chunks) {
  const fvv_chunk_info *all = (const fvv_chunk_info *)scanned->data;
  const size_t count = scanned->size / sizeof *all;
  const size_t low = fvv_first_from(all, count, sizeof *all, group->offset);
  size_t high = low;
  while (high < count && all[high].offset - group->offset < group->size) high++;
  return high > low ? fvv_bytes_append(chunks, all + low, (high - low) * sizeof *all) : FVV_OK;
}

/* The chunks of a group: as its table lists them, else those that are found in its bytes. */
static fvv_status fill_table(fvv_file *f, fvv_index_entry *entry, fvv_file_table **made,
                             fvv_diagnostic *diagnostic) {
  fvv_file_table *table = *made = fvv_allocate_zeroed(&f->allocator, sizeof *table);
  if (!table) return FVV_ERROR_MEMORY;
  table->chunks.allocator = table->unlisted.allocator = f->allocator;
  fvv_status status = fvv_bytes_reserve(&table->chunks, 1);
  if (f->index_state == FVV_INDEX_REBUILT) {
    if (status == FVV_OK) status = pick_scanned(&f->scanned.chunks, &entry->group, &table->chunks);
    if (status == FVV_OK) status = pick_scanned(&f->scanned.unlisted, &entry->group, &table->unlisted);
    return status;
  }
  fvv_diagnostic why = {0};
  if (status == FVV_OK) status = load_table(f, entry, &table->chunks, &why);
  if (status <= FVV_ERROR_DAMAGED && status != FVV_ERROR_LIMIT) {
    entry->group.intact = 0;
    status = fvv_bytes_append(&f->damage, &why, sizeof why);
    /* Another group is here, of which the listed bytes may be a part. */
    if (status < 0 || why.issue == FVV_ISSUE_INDEX) return status;
    return scan_group(f, &entry->group, table, diagnostic);
  }
  if (status < 0 && diagnostic) *diagnostic = why;
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
  fvv_file_table **table = (fvv_file_table **)file->tables.data + group;
  if (!*table) {
    const fvv_status status = fill_table(file, entry, table, diagnostic);
    if (status < 0) {
      release_table(file, table);
      return fvv_fail(diagnostic, status, 0, 0, entry->group.offset, "%s", fvv_status_text(status));
    }
  }
  *chunks = (const fvv_chunk_info *)(*table)->chunks.data;
  *count = (*table)->chunks.size / sizeof **chunks;
  return FVV_OK;
}

void fvv_file_unlisted_chunks(const fvv_file *file, size_t group, const fvv_chunk_info **chunks,
                              size_t *count) {
  const fvv_file_table *table = ((fvv_file_table **)file->tables.data)[group];
  *chunks = (const fvv_chunk_info *)table->unlisted.data;
  *count = table->unlisted.size / sizeof **chunks;
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
                    "chunk differs from its entry in the table of its group");
  *payload = file->buffer.data;
  return FVV_OK;
}
