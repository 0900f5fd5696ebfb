/* Random access through the index. Bytes come from a function of JavaScript that answers at once or not at
 * all: it notes what it lacks, fetches that, and calls again. The layers below take a failed read as an error
 * of input and keep no trace of it. */
#include <string.h>

#include "base/diagnostic.h"
#include "container/file.h"
#include "decoder.h"
#include "stream/stream.h"

/* Copies size bytes at offset to out, or answers 0. */
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
  return d->index ? (uint32_t)fvv_file_group_count(fvv_stream_file(d->index)) : 0;
}
/* 1: a good index; 2: made by reading all of the file. */
FVVJS_EXPORT uint32_t fvvjs_index_state(const fvvjs_decoder *d) {
  return d->index ? (uint32_t)fvv_file_index_state(fvv_stream_file(d->index)) : 0;
}

FVVJS_EXPORT const flat_group *fvvjs_group(fvvjs_decoder *d, uint32_t i) {
  const fvv_group_info *info = d->index ? fvv_file_group(fvv_stream_file(d->index), i) : NULL;
  if (!info) return NULL;
  const fvv_index_entry *entries = (const fvv_index_entry *)d->index->file->entries.data;
  const flat_group flat = {
      info->offset,           info->size,         info->start, info->end, info->sequence, info->frame_count,
      (uint32_t)info->intact, entries[i].end_size};
  d->group = flat;
  return &d->group;
}

/* Makes ready to be pushed the bytes from a group on. FVV_ERROR_IO as above. */
FVVJS_EXPORT int32_t fvvjs_play(fvvjs_decoder *d, uint32_t group) {
  const fvv_group_info *info = d->index ? fvv_file_group(fvv_stream_file(d->index), group) : NULL;
  if (!info) return FVV_ERROR_ARGUMENT;
  const fvv_configuration *configuration;
  forget(d);
  const fvv_status status = fvv_stream_configuration(d->index, group, &configuration, &d->diagnostic);
  if (status < 0) return status;
  d->configuration = configuration;
  return fvvjs_start(d, (double)info->offset, 1);
}

/* Reads the environment of a track that belongs to a group (clause 18.5). FVV_ERROR_IO as above, and
 * JavaScript has to ask itself whether FVV_END was answered for lack of bytes. */
FVVJS_EXPORT int32_t fvvjs_find_background(fvvjs_decoder *d, uint32_t group, uint32_t track) {
  const fvv_chunk_info *chunk;
  const uint8_t *payload;
  forget(d);
  if (!d->index) return FVV_END;
  fvv_status status = fvv_stream_find_background(d->index, group, (uint16_t)track, &chunk, &d->diagnostic);
  if (status == FVV_OK) status = fvv_file_read_chunk(d->index->file, chunk, &payload, &d->diagnostic);
  if (status != FVV_OK) return status;
  const flat_sample flat = {track, 1, payload, (uint32_t)chunk->size};
  d->background = flat;
  return FVV_OK;
}
FVVJS_EXPORT const flat_sample *fvvjs_background(const fvvjs_decoder *d) {
  return &d->background;
}
