/* Random access through the index. Bytes come from a function of JavaScript that returns at once or not at
 * all: it notes what it lacks, fetches that, and calls again. The layers below take a failed read as an error
 * of input and keep no trace of it. */
#include <string.h>

#include "base/diagnostic.h"
#include "container/chunk_order.h"
#include "decoder.h"
#include "stream/stream.h"

/* Copies size bytes at offset to out, or returns 0. */
__attribute__((import_module("fvv"), import_name("read"))) extern int
fvvjs_import_read(double offset, void *out, uint32_t size);

static fvv_status read_at(void *user, uint64_t offset, void *out, size_t size) {
  (void)user;
  return fvvjs_import_read((double)offset, out, (uint32_t)size) ? FVV_OK : FVV_ERROR_IO;
}

static int32_t forget(fvvjs_decoder *d) {
  memset(&d->diagnostic, 0, sizeof d->diagnostic);
  return FVV_OK;
}

/* size: of the whole file. FVV_ERROR_IO: fetch what was lacking and call again. */
FVVJS_EXPORT int32_t fvvjs_open(fvvjs_decoder *d, double size) {
  const fvv_input input = {read_at, NULL, (uint64_t)size};
  fvv_stream_close(d->index);
  d->index = NULL;
  forget(d);
  return fvv_stream_open(&input, &d->limits, &d->allocator, &d->index, &d->diagnostic);
}

FVVJS_EXPORT uint32_t fvvjs_group_count(const fvvjs_decoder *d) {
  return d->index ? (uint32_t)fvv_file_group_count(d->index->file) : 0;
}
/* 1: a good index; 2: made by reading all of the file. */
FVVJS_EXPORT uint32_t fvvjs_index_state(const fvvjs_decoder *d) {
  return d->index ? (uint32_t)fvv_file_index_state(d->index->file) : 0;
}

FVVJS_EXPORT const fvv_index_entry *fvvjs_group(const fvvjs_decoder *d, uint32_t i) {
  if (i >= fvvjs_group_count(d)) return NULL;
  return (const fvv_index_entry *)d->index->file->entries.data + i;
}

/* Makes ready to be pushed the bytes from a group on. FVV_ERROR_IO as above. */
FVVJS_EXPORT int32_t fvvjs_play(fvvjs_decoder *d, uint32_t group) {
  const fvv_group_info *info = d->index ? fvv_file_group(d->index->file, group) : NULL;
  if (!info) return FVV_ERROR_ARGUMENT;
  const fvv_configuration *configuration;
  forget(d);
  const fvv_status status = fvv_stream_configuration(d->index, group, &configuration, &d->diagnostic);
  if (status < 0) return status;
  return fvvjs_start_at(d, info->offset, configuration);
}

/* Whether the index lists the block of a group with a digest. Blocks rise by offset. */
static int is_listed(const fvv_file *file, const fvv_group_info *info, uint32_t digest) {
  const fvv_index_block *blocks = (const fvv_index_block *)file->listed.data;
  size_t low = 0, high = file->listed.size / sizeof *blocks;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (blocks[middle].offset < info->configuration_offset)
      low = middle + 1;
    else
      high = middle;
  }
  return low < file->listed.size / sizeof *blocks && blocks[low].offset == info->configuration_offset &&
         blocks[low].digest == digest;
}

/* FVV_OK: the configuration of a group can be read, if need be from a repetition of its block, and has the
 * digest that its GRUP names. FVV_ERROR_IO as above. What is pushed is not affected. */
FVVJS_EXPORT int32_t fvvjs_find_configuration(fvvjs_decoder *d, uint32_t group, uint32_t digest) {
  const fvv_group_info *info = d->index ? fvv_file_group(d->index->file, group) : NULL;
  const fvv_configuration *configuration;
  forget(d);
  if (!info) return FVV_ERROR_ARGUMENT;
  if (!is_listed(d->index->file, info, digest)) return FVV_ERROR_DAMAGED;
  return fvv_stream_configuration(d->index, group, &configuration, &d->diagnostic);
}

/* Reads the environment of a track that belongs to a group (clause 18.5). FVV_ERROR_IO as above, and
 * JavaScript has to find out whether FVV_END was returned for lack of bytes. */
FVVJS_EXPORT int32_t fvvjs_find_environment(fvvjs_decoder *d, uint32_t group, uint32_t track) {
  const fvv_chunk_info *chunk;
  const uint8_t *payload;
  forget(d);
  if (!d->index) return FVV_END;
  fvv_status status = fvv_stream_find_environment(d->index, group, (uint16_t)track, &chunk, &d->diagnostic);
  if (status == FVV_OK) status = fvv_file_read_chunk(d->index->file, chunk, &payload, &d->diagnostic);
  if (status != FVV_OK) return status;
  const wasm_sample record = {track, 1, payload, (uint32_t)chunk->size};
  d->environment = record;
  return FVV_OK;
}
FVVJS_EXPORT const wasm_sample *fvvjs_environment(const fvvjs_decoder *d) {
  return &d->environment;
}

/* A group out of the index, chunk by chunk, with some of its tracks left out: their bytes need not be
 * fetched. The chunks come as events like those of fvv_reader, and the rest is as for a stream that is
 * pushed. Every rule about the order of chunks is checked on the group's table before the first of them is
 * read. */

static fvv_status begin_sequence(fvvjs_decoder *d, fvv_chunk_order *sequence, const fvv_chunk_info *group) {
  const uint8_t *payload;
  const fvv_configuration *c = d->configuration;
  fvv_status status = fvv_file_read_chunk(d->index->file, group, &payload, &d->diagnostic);
  sequence->configuration = FVV_CONFIGURATION_GOOD;
  for (size_t i = 0; i < c->track_count && status == FVV_OK; i++) {
    const fvv_chunk_order_track track = {c->tracks[i].id, c->tracks[i].kind, 0, 0, 0};
    status = fvv_bytes_append(&sequence->tracks, &track, sizeof track);
  }
  if (status != FVV_OK) return status;
  const fvv_chunk_header header = {group->type, group->flags, 0, 0, group->time, group->size, 0, 0};
  return fvv_chunk_order_apply(sequence, &header, payload, group->offset);
}

/* The counters alone are not in the table. */
static fvv_status check_table(fvvjs_decoder *d, const fvvjs_pick *pick) {
  fvv_chunk_order sequence;
  fvv_chunk_order_init(&sequence, &d->limits, &d->allocator);
  fvv_status status = begin_sequence(d, &sequence, &pick->group);
  for (size_t i = 0; i < pick->count && status == FVV_OK; i++) {
    const fvv_chunk_info *info = &pick->chunks[i];
    const fvv_chunk_header header = {
        info->type, info->flags, sequence.next_counter, info->track, info->time, info->size, 0, 0};
    status = fvv_chunk_order_check(&sequence, &header, NULL, info->offset, &d->diagnostic);
    if (status == FVV_OK) status = fvv_chunk_order_apply(&sequence, &header, NULL, info->offset);
  }
  fvv_chunk_order_free(&sequence);
  return status;
}

static int is_left_out(const fvvjs_decoder *d, uint16_t track) {
  const uint16_t *tracks = (const uint16_t *)d->left_out.data;
  for (size_t i = 0; i < d->left_out.size / sizeof *tracks; i++)
    if (tracks[i] == track) return 1;
  return 0;
}

/* The first chunk from the ith of the table on that is not passed over: where it begins and ends in the file,
 * and the i of the next call. NULL: there is none. */
FVVJS_EXPORT const double *fvvjs_picked(fvvjs_decoder *d, uint32_t i) {
  const fvvjs_pick *pick = &d->pick;
  for (; pick->on && i < pick->count; i++) {
    if (is_left_out(d, pick->chunks[i].track)) continue;
    d->range[0] = (double)pick->chunks[i].offset;
    d->range[1] = d->range[0] + (double)fvv_chunk_extent(pick->chunks[i].size);
    d->range[2] = i + 1;
    return d->range;
  }
  return NULL;
}

/* Copies the chunk out of the buffer of the file, which others use too. */
static fvv_status read_chunk(fvvjs_decoder *d, const fvv_chunk_info *info, fvv_event *event,
                             fvv_diagnostic *diagnostic) {
  const uint8_t *payload;
  fvv_status status = fvv_file_read_chunk(d->index->file, info, &payload, diagnostic);
  if (status == FVV_ERROR_IO) return FVV_NEED_DATA;
  event->offset = info->offset;
  const fvv_chunk_header header = {info->type, info->flags, 0, info->track, info->time, info->size, 0, 0};
  event->chunk = header;
  if (status <= FVV_ERROR_DAMAGED && status != FVV_ERROR_LIMIT) {
    /* The group's table is intact: it is known what the chunk is. */
    event->kind = FVV_EVENT_DAMAGE;
    event->has_chunk = info->track != 0;
    event->skipped = fvv_chunk_extent(info->size);
    event->diagnostic = *diagnostic;
    d->pick.next = info->track ? d->pick.next + 1 : d->pick.count + 2;
    return FVV_OK;
  }
  d->pick.payload.size = 0;
  if (status == FVV_OK) status = fvv_bytes_append(&d->pick.payload, payload, (size_t)info->size);
  if (status != FVV_OK) return status;
  event->payload = d->pick.payload.data;
  d->pick.next++;
  return FVV_OK;
}

/* FVV_END: the group is over; FVV_NEED_DATA: fetch what was lacking. */
static fvv_status next_picked(void *user, fvv_event *event, fvv_diagnostic *diagnostic) {
  fvvjs_decoder *d = user;
  fvvjs_pick *pick = &d->pick;
  memset(event, 0, sizeof *event);
  event->kind = FVV_EVENT_CHUNK;
  event->group_intact = 1;
  if (!pick->next) return read_chunk(d, &pick->group, event, diagnostic);
  while (pick->next <= pick->count && is_left_out(d, pick->chunks[pick->next - 1].track)) pick->next++;
  if (pick->next <= pick->count) return read_chunk(d, &pick->chunks[pick->next - 1], event, diagnostic);
  if (pick->next > pick->count + 1) return FVV_END;
  /* Its GEND was read with the table. */
  pick->next++;
  event->chunk.type = FVV_CHUNK_GROUP_END;
  return FVV_OK;
}

/* Makes ready the chunks of a group of the index, which next reports then without bytes being pushed.
 * FVV_ERROR_IO: as of fvvjs_open. What is damaged or against the rules is reported better by reading all of
 * the group. */
FVVJS_EXPORT int32_t fvvjs_pick_group(fvvjs_decoder *d, uint32_t group) {
  const fvv_group_info *info = d->index ? fvv_file_group(d->index->file, group) : NULL;
  if (!info) return FVV_ERROR_ARGUMENT;
  const fvv_configuration *configuration;
  fvvjs_pick pick = d->pick;
  memset(&d->diagnostic, 0, sizeof d->diagnostic);
  fvv_status status = fvv_stream_configuration(d->index, group, &configuration, &d->diagnostic);
  if (status == FVV_OK)
    status = fvv_file_group_chunks(d->index->file, group, &pick.chunks, &pick.count, &d->diagnostic);
  if (status == FVV_OK && !info->intact) status = FVV_ERROR_DAMAGED;
  if (status != FVV_OK) return status;
  const fvv_chunk_info opening = {
      info->offset, FVV_GRUP_SIZE, info->start, FVV_CHUNK_GROUP, 0, FVV_FLAG_CRITICAL | FVV_FLAG_KEY};
  pick.group = opening;
  pick.next = 0;
  status = fvvjs_start_at(d, info->offset, configuration);
  if (status == FVV_OK) status = check_table(d, &pick);
  pick.on = status == FVV_OK;
  if (pick.on) fvv_frames_read_from(d->frames, next_picked, d);
  d->pick = pick;
  return status;
}
