/* Groups and chunks of a stream, which the container finds. */
#include "stream/stream.h"

fvv_index_state fvv_stream_index_state(const fvv_stream *stream) {
  return fvv_file_index_state(stream->file);
}

size_t fvv_stream_damage_count(const fvv_stream *stream) {
  return fvv_file_damage_count(stream->file);
}

const fvv_diagnostic *fvv_stream_damage(const fvv_stream *stream, size_t i) {
  return fvv_file_damage(stream->file, i);
}

size_t fvv_stream_group_count(const fvv_stream *stream) {
  return fvv_file_group_count(stream->file);
}

const fvv_group_info *fvv_stream_group(const fvv_stream *stream, size_t i) {
  return fvv_file_group(stream->file, i);
}

fvv_status fvv_stream_group_chunks(fvv_stream *stream, size_t group, const fvv_chunk_info **chunks,
                                   size_t *count, fvv_diagnostic *diagnostic) {
  return fvv_file_group_chunks(stream->file, group, chunks, count, diagnostic);
}

fvv_status fvv_stream_configuration_chunks(fvv_stream *stream, size_t group, const fvv_chunk_info **chunks,
                                           size_t *count, fvv_diagnostic *diagnostic) {
  return fvv_file_configuration(stream->file, group, chunks, count, diagnostic);
}

fvv_status fvv_stream_read_chunk(fvv_stream *stream, const fvv_chunk_info *info, const uint8_t **payload,
                                 fvv_diagnostic *diagnostic) {
  return fvv_file_read_chunk(stream->file, info, payload, diagnostic);
}
