/* Visibility of frames by number. A chunk that is no key is decoded from the key chunk of its group on, each
 * with its mesh; where each track stands is kept. */
#include "base/diagnostic.h"
#include "base/layout.h"
#include "stream/stream.h"
#include "stream/visibility_frames.h"

typedef struct followed_visibility {
  uint16_t track;
  uint64_t last; /* offset of the chunk that was decoded last; 0: none */
  fvv_visibility_frames frames;
} followed_visibility;

void fvv_stream_release_visibility(fvv_stream *stream) {
  followed_visibility *tracks = (followed_visibility *)stream->visibility.data;
  for (size_t i = 0; i < stream->visibility.size / sizeof *tracks; i++)
    fvv_visibility_frames_reset(&tracks[i].frames);
  fvv_bytes_free(&stream->visibility);
}

static fvv_status find_chunk(fvv_stream *s, size_t frame, uint16_t track, const fvv_chunk_info **chunk,
                             fvv_frame_chunks *found, fvv_diagnostic *diagnostic) {
  const fvv_status status = fvv_stream_find(s, frame, found, diagnostic);
  if (status < 0) return status;
  *chunk = fvv_stream_chunk_of(found, FVV_CHUNK_VISIBILITY, track);
  return *chunk ? FVV_OK : FVV_END;
}

/* Decodes the chunk of a frame, which is the track's next one or a key. found: of the frame. */
static fvv_status step(fvv_stream *s, followed_visibility *track, size_t frame, const fvv_chunk_info *chunk,
                       const fvv_frame_chunks *found, fvv_diagnostic *diagnostic) {
  const int key = (chunk->flags & FVV_FLAG_KEY) != 0;
  const uint8_t *payload;
  const fvv_configuration *configuration;
  fvv_visibility_header header;
  fvv_mesh mesh = {0};
  if (key) fvv_visibility_frames_reset(&track->frames);
  track->last = 0;
  fvv_status status = fvv_stream_configuration(s, found->group, &configuration, diagnostic);
  if (status == FVV_OK) status = fvv_file_read_chunk(s->file, chunk, &payload, diagnostic);
  if (status != FVV_OK) return status;
  status = fvv_visibility_frames_check(&track->frames, payload, (size_t)chunk->size, key, configuration,
                                       &s->limits, &header, diagnostic);
  if (status == FVV_OK) {
    const fvv_calibration *calibration = NULL;
    status = fvv_stream_mesh(s, frame, header.mesh_track, &mesh, diagnostic);
    /* Reading mesh and calibration used the buffer in which the payload stood. */
    const int has_mesh = status == FVV_OK;
    if (status >= 0) status = fvv_stream_calibration(s, found, configuration, &calibration, diagnostic);
    if (status >= 0) status = fvv_file_read_chunk(s->file, chunk, &payload, diagnostic);
    if (status != FVV_OK) {
      fvv_mesh_free(&mesh);
      return status;
    }
    status =
        fvv_visibility_frames_add(&track->frames, payload, (size_t)chunk->size, key, has_mesh ? &mesh : NULL,
                                  calibration, configuration, &s->limits, &s->allocator, diagnostic);
    fvv_mesh_free(&mesh);
  }
  if (status == FVV_OK)
    track->last = chunk->offset;
  else
    fvv_diagnostic_rebase(diagnostic, chunk->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_VISIBILITY);
  return status;
}

/* From the last chunk that is decoded, or a key, to that of the frame. */
static fvv_status follow(fvv_stream *s, followed_visibility *track, size_t frame,
                         fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *chunk;
  fvv_frame_chunks found;
  size_t from = frame;
  for (;; from--) {
    const fvv_status status = find_chunk(s, from, track->track, &chunk, &found, diagnostic);
    if (status < 0) return status;
    if (status == FVV_OK && chunk->offset == track->last) {
      if (from++ == frame) return FVV_OK;
      break;
    }
    if (!from || (status == FVV_OK && chunk->flags & FVV_FLAG_KEY)) break;
  }
  for (; from <= frame; from++) {
    fvv_status status = find_chunk(s, from, track->track, &chunk, &found, diagnostic);
    if (status == FVV_OK) status = step(s, track, from, chunk, &found, diagnostic);
    if (status < 0) return status;
  }
  return FVV_OK;
}

fvv_status fvv_stream_visibility(fvv_stream *stream, size_t frame, uint16_t track,
                                 const fvv_visibility **visibility, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *visibility = NULL;
  const fvv_chunk_info *chunk;
  fvv_frame_chunks found;
  fvv_status status = find_chunk(stream, frame, track, &chunk, &found, diagnostic);
  if (status != FVV_OK) return status;
  void *kept;
  status = fvv_stream_kept_of(stream, &stream->visibility, sizeof(followed_visibility), track, &kept);
  if (status != FVV_OK)
    return fvv_fail(diagnostic, status, status == FVV_ERROR_LIMIT ? FVV_ISSUE_LIMIT : 0, FVV_CHUNK_VISIBILITY,
                    chunk->offset, "no room for the visibility of track %u", track);
  followed_visibility *followed = kept;
  status = follow(stream, followed, frame, diagnostic);
  if (status == FVV_OK) *visibility = &followed->frames.current;
  return status;
}
