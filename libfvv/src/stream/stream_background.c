/* The environment that belongs to a group: in the group itself, or where clause 18.5 says that a writer puts
 * it. At most three tables of groups are read; the stream is never scanned. */
#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "stream/stream.h"

void fvv_stream_release_background(fvv_stream *stream) {
  fvv_background_free(&stream->background);
  fvv_bytes_free(&stream->background_payload);
  stream->background_chunk = 0;
}

/* 1 and *digest, that of the configuration block, when the group's GRUP is intact. */
static int digest_of(fvv_stream *s, size_t group, uint32_t *digest) {
  const fvv_group_info *info = fvv_file_group(s->file, group);
  const fvv_chunk_info chunk = {
      info->offset, FVV_GRUP_SIZE, info->start, FVV_CHUNK_GROUP, 0, FVV_FLAG_CRITICAL | FVV_FLAG_KEY};
  const uint8_t *payload;
  if (fvv_file_read_chunk(s->file, &chunk, &payload, NULL) != FVV_OK) return 0;
  *digest = fvv_get_u32(payload + FVV_GRUP_CONFIGURATION_CRC);
  return 1;
}

/* The first group behind the configuration block of a group. */
static size_t first_of_block(const fvv_stream *s, size_t group) {
  const uint64_t block = fvv_file_group(s->file, group)->configuration_offset;
  while (group && fvv_file_group(s->file, group - 1)->configuration_offset == block) group--;
  return group;
}

/* The same, with all blocks in front of it that only repeat it. */
static size_t first_of_configuration(fvv_stream *s, size_t group) {
  uint32_t digest, other;
  group = first_of_block(s, group);
  if (!group || !digest_of(s, group, &digest)) return group;
  while (group && digest_of(s, group - 1, &other) && other == digest) group = first_of_block(s, group - 1);
  return group;
}

/* FVV_END: the group has none of the track. */
static fvv_status find_in(fvv_stream *s, size_t group, uint16_t track, const fvv_chunk_info **chunk,
                          fvv_diagnostic *diagnostic) {
  size_t count;
  const fvv_status status = fvv_file_group_chunks(s->file, group, chunk, &count, diagnostic);
  if (status < 0) return status;
  for (; count; (*chunk)++, count--)
    if ((*chunk)->type == FVV_CHUNK_BACKGROUND && (*chunk)->track == track) return FVV_OK;
  return FVV_END;
}

static fvv_status load(fvv_stream *s, const fvv_chunk_info *chunk, fvv_diagnostic *diagnostic) {
  const uint8_t *payload;
  fvv_stream_release_background(s);
  fvv_status status = fvv_file_read_chunk(s->file, chunk, &payload, diagnostic);
  if (status < 0) return status;
  s->background_payload.allocator = s->allocator;
  if (fvv_bytes_append(&s->background_payload, payload, (size_t)chunk->size) != FVV_OK)
    return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, FVV_CHUNK_BACKGROUND, chunk->offset,
                    "no memory for a background of %llu bytes", (unsigned long long)chunk->size);
  status = fvv_background_decode(s->background_payload.data, (size_t)chunk->size, &s->limits, &s->allocator,
                                 &s->background, diagnostic);
  if (status == FVV_OK)
    s->background_chunk = chunk->offset;
  else
    fvv_diagnostic_rebase(diagnostic, chunk->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_BACKGROUND);
  return status;
}

fvv_status fvv_stream_find_background(fvv_stream *stream, size_t group, uint16_t track,
                                      const fvv_chunk_info **chunk, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_configuration *configuration;
  fvv_status status = fvv_stream_configuration(stream, group, &configuration, diagnostic);
  if (status < 0) return status;
  const fvv_track *declared = fvv_configuration_track(configuration, track);
  if (!declared || declared->kind != FVV_TRACK_BACKGROUND) return FVV_END;
  status = find_in(stream, group, track, chunk, diagnostic);
  if (status == FVV_END) status = find_in(stream, first_of_block(stream, group), track, chunk, diagnostic);
  if (status == FVV_END)
    status = find_in(stream, first_of_configuration(stream, group), track, chunk, diagnostic);
  return status;
}

fvv_status fvv_stream_background(fvv_stream *stream, size_t group, uint16_t track,
                                 const fvv_background **background, fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *chunk = NULL;
  *background = NULL;
  fvv_status status = fvv_stream_find_background(stream, group, track, &chunk, diagnostic);
  if (status == FVV_OK && chunk->offset != stream->background_chunk) status = load(stream, chunk, diagnostic);
  if (status == FVV_OK) *background = &stream->background;
  return status;
}
