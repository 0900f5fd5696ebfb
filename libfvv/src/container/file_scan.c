/* container/file_scan.c: a stream without a usable index is read from end to end; what is found there and
 * what an intact INDX chunk tells are joined (clause 7.5). */
#include "container/file.h"

#include "base/bytes.h"
#include "base/diagnostic.h"

enum { BLOCK_SIZE = 1 << 18 };

typedef struct scan_state {
  fvv_file *file;
  fvv_bytes *chunks; /* fvv_chunk_info of intact frame chunks */
  fvv_bytes index;   /* fvv_index_entry of an intact INDX chunk */
  uint64_t configuration_offset;
  int whole_file;
} scan_state;

static size_t count_of(const fvv_file *f) {
  return f->entries.size / sizeof(fvv_index_entry);
}

static fvv_index_entry *last_entry(const fvv_file *f) {
  return count_of(f) ? (fvv_index_entry *)f->entries.data + count_of(f) - 1 : NULL;
}

/* A group without GEND ends where something else begins. */
static void close_open_group(fvv_file *f, uint64_t offset) {
  fvv_index_entry *last = last_entry(f);
  if (last && !last->end_size && !last->group.size) last->group.size = offset - last->group.offset;
}

static fvv_status take_chunk(scan_state *s, const fvv_event *event) {
  fvv_file *f = s->file;
  const fvv_chunk_header *header = &event->chunk;
  const fvv_place place = fvv_chunk_place(header->type);
  if (place == FVV_PLACE_FRAME || (place == FVV_PLACE_UNKNOWN && event->group_intact)) {
    const fvv_chunk_info info = {event->offset, header->size,  header->time,
                                 header->type,  header->track, header->flags};
    return fvv_bytes_append(s->chunks, &info, sizeof info);
  }
  if (!s->whole_file) return FVV_OK;
  fvv_diagnostic ignored = {0};
  fvv_index_entry *last = last_entry(f);
  switch (header->type) {
  case FVV_CHUNK_GROUP: {
    close_open_group(f, event->offset);
    if (header->size != FVV_GRUP_SIZE || count_of(f) >= f->limits.max_groups) return FVV_OK;
    fvv_index_entry entry;
    memset(&entry, 0, sizeof entry);
    entry.group.offset = event->offset;
    entry.group.start = fvv_get_i64(event->payload + FVV_GRUP_START);
    entry.group.end = fvv_get_i64(event->payload + FVV_GRUP_END);
    entry.group.sequence = fvv_get_u32(event->payload + FVV_GRUP_SEQUENCE);
    entry.group.configuration_offset = s->configuration_offset;
    return fvv_bytes_append(&f->entries, &entry, sizeof entry);
  }
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
                         &ignored) < 0)
      s->index.size = 0;
    return FVV_OK;
  default:
    return FVV_OK;
  }
}

static fvv_status scan_events(scan_state *s, fvv_reader *reader, fvv_diagnostic *diagnostic) {
  fvv_event event;
  fvv_status status;
  while ((status = fvv_reader_next(reader, &event, diagnostic)) == FVV_OK) {
    if (event.kind == FVV_EVENT_CHUNK)
      status = take_chunk(s, &event);
    else if (event.kind == FVV_EVENT_DAMAGE && s->whole_file)
      status = fvv_bytes_append(&s->file->damage, &event.diagnostic, sizeof event.diagnostic);
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
  for (uint64_t done = 0; done < size && status >= 0;) {
    const size_t part = size - done < BLOCK_SIZE ? (size_t)(size - done) : BLOCK_SIZE;
    if (f->input.read_at(f->input.user, offset + done, f->buffer.data, part) != FVV_OK)
      status = fvv_fail(diagnostic, FVV_ERROR_IO, 0, 0, offset + done, "cannot read %zu bytes at 0x%llx",
                        part, (unsigned long long)(offset + done));
    else if ((status = fvv_reader_push(reader, f->buffer.data, part)) >= 0)
      status = scan_events(s, reader, diagnostic);
    done += part;
  }
  if (status >= 0) {
    fvv_reader_finish(reader);
    status = scan_events(s, reader, diagnostic);
  }
  fvv_reader_destroy(reader);
  if (status < 0) return fvv_fail(diagnostic, status, 0, 0, offset, "%s", fvv_status_text(status));
  return FVV_OK;
}

/* Distinct times of the scanned chunks of each group, for groups without a table that could be asked. */
static void count_frames(fvv_file *f) {
  const fvv_chunk_info *chunks = (const fvv_chunk_info *)f->scanned.data;
  const size_t chunk_count = f->scanned.size / sizeof *chunks;
  fvv_index_entry *entries = (fvv_index_entry *)f->entries.data;
  size_t c = 0;
  for (size_t g = 0; g < count_of(f); g++) {
    const fvv_group_info *group = &entries[g].group;
    uint32_t frames = 0;
    int64_t last = 0;
    while (c < chunk_count && chunks[c].offset < group->offset) c++;
    for (; c < chunk_count && chunks[c].offset - group->offset < group->size; c++) {
      if (!chunks[c].track || (frames && chunks[c].time == last)) continue;
      frames++;
      last = chunks[c].time;
    }
    entries[g].group.frame_count = frames;
  }
}

/* Groups that only the index knows: their GRUP was lost, their frames may still be there. */
static fvv_status join_index(fvv_file *f, const fvv_bytes *index) {
  const fvv_index_entry *known = (const fvv_index_entry *)index->data;
  const size_t known_count = index->size / sizeof *known, found_count = count_of(f);
  fvv_bytes joined = {NULL, 0, 0, f->allocator};
  fvv_status status = FVV_OK;
  for (size_t k = 0, g = 0; (k < known_count || g < found_count) && status == FVV_OK;) {
    const fvv_index_entry *found = (fvv_index_entry *)f->entries.data + g;
    if (g < found_count && (k == known_count || found->group.offset <= known[k].group.offset)) {
      k += k < known_count && found->group.offset == known[k].group.offset;
      status = fvv_bytes_append(&joined, found, sizeof *found);
      g++;
    } else {
      fvv_index_entry lost = known[k++];
      lost.group.intact = 0;
      status = fvv_bytes_append(&joined, &lost, sizeof lost);
    }
  }
  fvv_bytes_free(&f->entries);
  f->entries = joined;
  return status;
}

fvv_status fvv_file_rebuild(fvv_file *file, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  file->entries.size = file->damage.size = file->scanned.size = 0;
  scan_state state = {file, &file->scanned, {NULL, 0, 0, file->allocator}, 0, 1};
  fvv_status status = scan_range(&state, 0, file->input.size, diagnostic);
  if (status == FVV_OK) {
    close_open_group(file, file->input.size);
    status = join_index(file, &state.index);
  }
  fvv_bytes_free(&state.index);
  if (status == FVV_OK) count_frames(file);
  return status;
}

fvv_status fvv_file_scan_group(fvv_file *file, const fvv_group_info *group, fvv_bytes *chunks,
                               fvv_diagnostic *diagnostic) {
  scan_state state = {file, chunks, {NULL, 0, 0, file->allocator}, 0, 0};
  chunks->size = 0;
  return scan_range(&state, group->offset, group->size, diagnostic);
}
