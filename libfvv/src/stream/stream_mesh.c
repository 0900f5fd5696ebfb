/* Meshes of frames by number. A delta frame is decoded from the key mesh of its group on; where each track
 * stands is kept, so that frames in order cost one step each. */
#include <string.h>

#include "base/diagnostic.h"
#include "base/layout.h"
#include "mesh/storage.h"
#include "stream/mesh_frames.h"
#include "stream/stream.h"

typedef struct followed_track {
  uint16_t track;
  uint64_t key, last; /* offsets of the chunks of the key mesh and of the current frame */
  fvv_mesh_frames frames;
} followed_track;

void fvv_stream_release_meshes(fvv_stream *stream) {
  followed_track *tracks = (followed_track *)stream->meshes.data;
  for (size_t i = 0; i < stream->meshes.size / sizeof *tracks; i++) fvv_mesh_frames_reset(&tracks[i].frames);
  fvv_bytes_free(&stream->meshes);
}

/* Decodes the track's next chunk. */
static fvv_status step(fvv_stream *s, followed_track *track, const fvv_chunk_info *chunk,
                       fvv_diagnostic *diagnostic) {
  const uint8_t *payload;
  const int key = (chunk->flags & FVV_FLAG_KEY) != 0;
  fvv_status status = fvv_file_read_chunk(s->file, chunk, &payload, diagnostic);
  if (status != FVV_OK) {
    fvv_mesh_frames_reset(&track->frames);
    return status;
  }
  status = fvv_mesh_frames_add(&track->frames, payload, (size_t)chunk->size, key, &s->limits, &s->allocator,
                               diagnostic);
  if (status != FVV_OK)
    fvv_diagnostic_rebase(diagnostic, chunk->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_MESH);
  if (key) track->key = chunk->offset;
  track->last = chunk->offset;
  return status;
}

static int is_mesh(const fvv_chunk_info *chunk, uint16_t track) {
  return chunk->type == FVV_CHUNK_MESH && chunk->track == track;
}

/* first: the group's list, in which wanted stands. */
static fvv_status follow(fvv_stream *s, followed_track *track, const fvv_chunk_info *first,
                         const fvv_chunk_info *wanted, fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *key = wanted;
  while (key > first && !(is_mesh(key, track->track) && key->flags & FVV_FLAG_KEY)) key--;
  const fvv_chunk_info *next = key;
  if (fvv_mesh_frames_current(&track->frames) && track->key == key->offset && track->last <= wanted->offset)
    while (next <= wanted && next->offset <= track->last) next++;
  else
    fvv_mesh_frames_reset(&track->frames);
  for (; next <= wanted; next++) {
    if (!is_mesh(next, track->track)) continue;
    const fvv_status status = step(s, track, next, diagnostic);
    if (status != FVV_OK) return status;
  }
  return FVV_OK;
}

static fvv_status decode_delta(fvv_stream *s, const fvv_frame_chunks *found, const fvv_chunk_info *wanted,
                               fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  void *kept;
  fvv_status status = fvv_stream_kept_of(s, &s->meshes, sizeof(followed_track), wanted->track, &kept);
  if (status != FVV_OK)
    return fvv_fail(diagnostic, status, status == FVV_ERROR_LIMIT ? FVV_ISSUE_LIMIT : 0, FVV_CHUNK_MESH,
                    wanted->offset, "no room for the delta frames of track %u", wanted->track);
  followed_track *track = kept;
  status = follow(s, track, found->first, wanted, diagnostic);
  if (status != FVV_OK) return status;
  status = fvv_mesh_copy(fvv_mesh_frames_current(&track->frames), &s->allocator, mesh);
  return status == FVV_OK ? status : fvv_fail(diagnostic, status, 0, 0, 0, "no memory for a mesh");
}

static fvv_status decode_key(fvv_stream *s, const fvv_chunk_info *wanted, fvv_mesh *mesh,
                             fvv_diagnostic *diagnostic) {
  const uint8_t *payload;
  fvv_status status = fvv_file_read_chunk(s->file, wanted, &payload, diagnostic);
  if (status != FVV_OK) return status;
  fvv_mesh_header header;
  status = fvv_mesh_peek(payload, (size_t)wanted->size, &s->limits, &header, diagnostic);
  if (status == FVV_OK) status = fvv_mesh_frames_check_flag(&header, 1, diagnostic);
  if (status == FVV_OK)
    status = fvv_mesh_decode(payload, (size_t)wanted->size, &s->limits, &s->allocator, mesh, diagnostic);
  if (status != FVV_OK)
    fvv_diagnostic_rebase(diagnostic, wanted->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_MESH);
  return status;
}

fvv_status fvv_stream_mesh(fvv_stream *stream, size_t frame, uint16_t track, fvv_mesh *mesh,
                           fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  memset(mesh, 0, sizeof *mesh);
  fvv_frame_chunks found;
  const fvv_status status = fvv_stream_find(stream, frame, &found, diagnostic);
  if (status < 0) return status;
  const fvv_chunk_info *chunk = fvv_stream_chunk_of(&found, FVV_CHUNK_MESH, track);
  if (!chunk) return FVV_END;
  return chunk->flags & FVV_FLAG_KEY ? decode_key(stream, chunk, mesh, diagnostic)
                                     : decode_delta(stream, &found, chunk, mesh, diagnostic);
}
