/* stream/stream.c: frames by number, through the index of the file. */
#include "stream/stream.h"

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"

fvv_status fvv_stream_open(const fvv_input *input, const fvv_limits *limits, const fvv_allocator *allocator,
                           fvv_stream **stream, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_allocator chosen = fvv_allocator_or_default(allocator);
  *stream = fvv_allocate_zeroed(&chosen, sizeof **stream);
  if (!*stream) return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory");
  fvv_stream *s = *stream;
  s->allocator = s->firsts.allocator = s->meshes.allocator = s->visibility.allocator = s->layouts.allocator =
      chosen;
  fvv_configuration_init(&s->configuration, limits, &chosen);
  s->limits = s->configuration.limits;
  const fvv_status status = fvv_file_open(input, limits, &chosen, &s->file, diagnostic);
  if (status < 0) {
    fvv_stream_close(s);
    *stream = NULL;
    return status;
  }
  for (size_t g = 0; g < fvv_file_group_count(s->file); g++) {
    const uint64_t first = s->frame_count;
    s->frame_count += fvv_file_group(s->file, g)->frame_count;
    if (fvv_bytes_append(&s->firsts, &first, sizeof first) < 0) {
      fvv_stream_close(s);
      *stream = NULL;
      return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory");
    }
  }
  return FVV_OK;
}

void fvv_stream_close(fvv_stream *stream) {
  if (!stream) return;
  const fvv_allocator allocator = stream->allocator;
  fvv_configuration_free(&stream->configuration);
  fvv_bytes_free(&stream->firsts);
  fvv_stream_release_cameras(stream);
  fvv_stream_release_meshes(stream);
  fvv_stream_release_tiles(stream);
  fvv_stream_release_visibility(stream);
  fvv_stream_release_background(stream);
  fvv_file_close(stream->file);
  fvv_release(&allocator, stream, sizeof *stream);
}

const fvv_file *fvv_stream_file(const fvv_stream *stream) {
  return stream->file;
}
size_t fvv_stream_frame_count(const fvv_stream *stream) {
  return stream->frame_count;
}

fvv_status fvv_stream_find(fvv_stream *s, size_t frame, fvv_frame_chunks *found, fvv_diagnostic *diagnostic) {
  if (frame >= s->frame_count)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "frame %zu of %zu", frame, s->frame_count);
  /* The last group that begins at or before the frame; groups without frames begin where the next one does.
   */
  const uint64_t *firsts = (const uint64_t *)s->firsts.data;
  size_t group = 0, beyond = fvv_file_group_count(s->file);
  while (beyond - group > 1) {
    const size_t middle = group + (beyond - group) / 2;
    if (firsts[middle] <= frame)
      group = middle;
    else
      beyond = middle;
  }
  size_t left = frame - (size_t)firsts[group];
  const fvv_chunk_info *chunks;
  size_t count;
  const fvv_status status = fvv_file_group_chunks(s->file, group, &chunks, &count, diagnostic);
  if (status < 0) return status;
  found->group = group;
  found->first = chunks;
  size_t i = 0;
  for (;; left--) {
    while (i < count && !chunks[i].track) i++;
    size_t end = i;
    while (end < count && (!chunks[end].track || chunks[end].time == chunks[i].time)) end++;
    found->chunks = chunks + i;
    found->count = end - i;
    if (!left || i == count) break;
    i = end;
  }
  if (!found->count)
    return fvv_fail(diagnostic, FVV_ERROR_DAMAGED, FVV_ISSUE_GROUP_END, 0,
                    fvv_file_group(s->file, group)->offset,
                    "frame %zu is lost: group %u has fewer intact frames than the index tells", frame,
                    fvv_file_group(s->file, group)->sequence);
  return FVV_OK;
}

fvv_status fvv_stream_frame(fvv_stream *stream, size_t frame, fvv_frame *out, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_frame_chunks found;
  const fvv_status status = fvv_stream_find(stream, frame, &found, diagnostic);
  if (status < 0) return status;
  out->time = found.chunks[0].time;
  out->group = found.group;
  return FVV_OK;
}

fvv_status fvv_stream_configuration(fvv_stream *stream, size_t group, const fvv_configuration **configuration,
                                    fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_group_info *info = fvv_file_group(stream->file, group);
  if (!info)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "group %zu of %zu", group,
                    fvv_file_group_count(stream->file));
  const uint64_t offset = info->configuration_offset;
  if (offset != stream->configuration_offset) {
    stream->configuration_offset = 0;
    fvv_stream_release_cameras(stream); /* names are borrowed */
    const fvv_chunk_info *chunks;
    size_t count;
    fvv_status status = fvv_file_configuration(stream->file, group, &chunks, &count, diagnostic);
    for (size_t i = 0; i < count && status >= 0; i++) {
      const uint8_t *payload;
      status = fvv_file_read_chunk(stream->file, &chunks[i], &payload, diagnostic);
      if (status < 0) break;
      const fvv_chunk_header header = {chunks[i].type, chunks[i].flags, 0, chunks[i].track,
                                       chunks[i].time, chunks[i].size,  0, 0};
      status = fvv_configuration_add(&stream->configuration, &header, payload, chunks[i].offset, diagnostic);
    }
    if (status >= 0) status = fvv_configuration_complete(&stream->configuration, offset, diagnostic);
    if (status < 0) return status;
    stream->configuration_offset = offset;
  }
  *configuration = &stream->configuration.view;
  return FVV_OK;
}

const fvv_chunk_info *fvv_stream_chunk_of(const fvv_frame_chunks *found, uint32_t type, uint16_t track) {
  for (size_t i = 0; i < found->count; i++)
    if (found->chunks[i].type == type && found->chunks[i].track == track) return &found->chunks[i];
  return NULL;
}

fvv_status fvv_stream_kept_of(const fvv_stream *stream, fvv_bytes *list, size_t size, uint16_t track,
                              void **element) {
  for (size_t at = 0; at < list->size; at += size) {
    uint16_t id;
    memcpy(&id, list->data + at, sizeof id);
    *element = list->data + at;
    if (id == track) return FVV_OK;
  }
  if (list->size / size >= stream->limits.max_tracks) return FVV_ERROR_LIMIT;
  const fvv_status status = fvv_bytes_reserve(list, size);
  if (status != FVV_OK) return status;
  *element = list->data + list->size;
  memset(*element, 0, size);
  memcpy(*element, &track, sizeof track);
  list->size += size;
  return FVV_OK;
}

fvv_status fvv_stream_sample(fvv_stream *stream, size_t frame, uint16_t track, const uint8_t **sample,
                             size_t *size, int *key, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *sample = NULL;
  *size = 0;
  fvv_frame_chunks found;
  fvv_status status = fvv_stream_find(stream, frame, &found, diagnostic);
  if (status < 0) return status;
  /* The configuration first: reading it uses the buffer that the sample will stand in. */
  const fvv_configuration *configuration;
  status = fvv_stream_configuration(stream, found.group, &configuration, diagnostic);
  if (status < 0) return status;
  const fvv_video_layout *video = fvv_configuration_video(configuration, track);
  if (!video) return FVV_END;
  const fvv_chunk_info *info = fvv_stream_chunk_of(&found, FVV_CHUNK_VIDEO_PACKET, track);
  if (!info) return FVV_END;
  const uint8_t *payload;
  status = fvv_file_read_chunk(stream->file, info, &payload, diagnostic);
  if (status != FVV_OK) return status;
  *key = (info->flags & FVV_FLAG_KEY) != 0;
  status = fvv_video_sample_check(&video->config, *key, payload, (size_t)info->size, diagnostic);
  if (status < 0) {
    fvv_diagnostic_rebase(diagnostic, info->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_VIDEO_PACKET);
    return status;
  }
  *sample = payload;
  *size = (size_t)info->size;
  return FVV_OK;
}
