/* The environment of a group: in the group itself, or where clause 18.5 has a writer put it. At most three
 * tables of groups are read; the stream is never scanned. */
#include "stream/stream.h"

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"

void fvv_stream_release_environment(fvv_stream *stream) {
  fvv_environment_free(&stream->environment);
  fvv_bytes_free(&stream->environment_payload);
  stream->environment_chunk = 0;
}

/* *digest: of the configuration block. FVV_END: the group's GRUP is not intact. */
static fvv_status digest_of(fvv_stream *s, size_t group, uint32_t *digest, fvv_diagnostic *diagnostic) {
  const fvv_group_info *info = fvv_file_group(s->file, group);
  const fvv_chunk_info chunk = {
      info->offset, FVV_GRUP_SIZE, info->start, FVV_CHUNK_GROUP, 0, FVV_FLAG_CRITICAL | FVV_FLAG_KEY};
  const uint8_t *payload;
  const fvv_status status = fvv_file_read_chunk(s->file, &chunk, &payload, diagnostic);
  if (status == FVV_OK) *digest = fvv_get_u32(payload + FVV_GRUP_CONFIGURATION_CRC);
  if (status > FVV_ERROR_DAMAGED) return status;
  fvv_diagnostic_clear(diagnostic);
  return FVV_END;
}

/* The first group after the configuration block of a group. */
static size_t first_of_block(const fvv_stream *s, size_t group) {
  const uint64_t block = fvv_file_group(s->file, group)->configuration_offset;
  while (group && fvv_file_group(s->file, group - 1)->configuration_offset == block) group--;
  return group;
}

/* The same, with all blocks before it that only repeat it. */
static fvv_status first_of_configuration(fvv_stream *s, size_t *group, fvv_diagnostic *diagnostic) {
  uint32_t digest = 0, other = 0;
  *group = first_of_block(s, *group);
  fvv_status status = *group ? digest_of(s, *group, &digest, diagnostic) : FVV_END;
  while (status == FVV_OK && *group) {
    status = digest_of(s, *group - 1, &other, diagnostic);
    if (other != digest) break;
    if (status == FVV_OK) *group = first_of_block(s, *group - 1);
  }
  return status < 0 ? status : FVV_OK;
}

/* FVV_END: the group has none of the track. */
static fvv_status find_environment_in(fvv_stream *s, size_t group, uint16_t track,
                                      const fvv_chunk_info **chunk, fvv_diagnostic *diagnostic) {
  size_t count;
  const fvv_status status = fvv_file_group_chunks(s->file, group, chunk, &count, diagnostic);
  if (status < 0) return status;
  for (; count; (*chunk)++, count--)
    if ((*chunk)->type == FVV_CHUNK_ENVIRONMENT && (*chunk)->track == track) return FVV_OK;
  return FVV_END;
}

static fvv_status load_environment(fvv_stream *s, const fvv_chunk_info *chunk, fvv_diagnostic *diagnostic) {
  const uint8_t *payload;
  fvv_stream_release_environment(s);
  fvv_status status = fvv_file_read_chunk(s->file, chunk, &payload, diagnostic);
  if (status < 0) return status;
  s->environment_payload.allocator = s->allocator;
  if (fvv_bytes_append(&s->environment_payload, payload, (size_t)chunk->size) != FVV_OK)
    return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, FVV_CHUNK_ENVIRONMENT, chunk->offset,
                    "out of memory for an environment of %llu bytes", (unsigned long long)chunk->size);
  status = fvv_environment_decode(s->environment_payload.data, (size_t)chunk->size, &s->limits, &s->allocator,
                                  &s->environment, diagnostic);
  if (status == FVV_OK)
    s->environment_chunk = chunk->offset;
  else
    fvv_diagnostic_rebase(diagnostic, chunk->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_ENVIRONMENT);
  return status;
}

fvv_status fvv_stream_find_environment(fvv_stream *stream, size_t group, uint16_t track,
                                       const fvv_chunk_info **chunk, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_configuration *configuration;
  fvv_status status = fvv_stream_configuration(stream, group, &configuration, diagnostic);
  if (status < 0) return status;
  const fvv_track *declared = fvv_configuration_track(configuration, track);
  if (!declared || declared->kind != FVV_TRACK_ENVIRONMENT) return FVV_END;
  status = find_environment_in(stream, group, track, chunk, diagnostic);
  if (status == FVV_END)
    status = find_environment_in(stream, first_of_block(stream, group), track, chunk, diagnostic);
  if (status != FVV_END) return status;
  status = first_of_configuration(stream, &group, diagnostic);
  return status == FVV_OK ? find_environment_in(stream, group, track, chunk, diagnostic) : status;
}

fvv_status fvv_stream_environment(fvv_stream *stream, size_t group, uint16_t track,
                                  const fvv_environment **environment, fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *chunk = NULL;
  *environment = NULL;
  fvv_status status = fvv_stream_find_environment(stream, group, track, &chunk, diagnostic);
  if (status == FVV_OK && chunk->offset != stream->environment_chunk)
    status = load_environment(stream, chunk, diagnostic);
  if (status == FVV_OK) *environment = &stream->environment;
  return status;
}
