/* Frames by number: their chunks, meshes, samples, cameras, tiles, visibility and colours. */
#include "stream/stream.h"

#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "mesh/mesh.h"
#include "stream/tracks.h"

/* The chunks of a frame: a run within its group's list, which begins with first. */
typedef struct frame_chunks {
  const fvv_chunk_info *chunks;
  size_t count;
  size_t group;
  const fvv_chunk_info *first;
} frame_chunks;

size_t fvv_stream_frame_count(const fvv_stream *stream) {
  return stream->frame_count;
}

/* The element of list that is kept for a track between calls. Elements have size bytes and begin with the
 * track as uint16_t. A missing one is added, with zeros after the track. Valid until the next is added.
 * FVV_ERROR_LIMIT: there are as many as a stream may have tracks. */
static fvv_status kept_of(const fvv_stream *stream, fvv_bytes *list, size_t size, uint16_t track,
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

static fvv_status number_frames(fvv_stream *s, fvv_diagnostic *diagnostic) {
  const size_t groups = fvv_file_group_count(s->file);
  if (s->firsts.size || !groups) return FVV_OK;
  if (fvv_bytes_reserve(&s->firsts, groups * sizeof(uint64_t)) < 0)
    return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory for %zu groups", groups);
  uint64_t *firsts = (uint64_t *)s->firsts.data, first = 0;
  for (size_t g = 0; g < groups; g++) {
    firsts[g] = first;
    first += fvv_file_group(s->file, g)->frame_count;
  }
  s->firsts.size = groups * sizeof *firsts;
  return FVV_OK;
}

static fvv_status find_frame(fvv_stream *s, size_t frame, frame_chunks *found, fvv_diagnostic *diagnostic) {
  if (frame >= s->frame_count)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "frame %zu of %zu", frame, s->frame_count);
  const fvv_status numbered = number_frames(s, diagnostic);
  if (numbered < 0) return numbered;
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
  found->count = 0;
  fvv_frame_rule rule = {s->file, group, 0, NULL};
  for (size_t i = 0, end; i < count && !found->count; i = end) {
    int is_frame = 0;
    for (end = i; end < count && chunks[end].time == chunks[i].time; end++)
      is_frame |= fvv_file_makes_frame(&rule, &chunks[end]);
    if (!is_frame || left--) continue;
    found->chunks = chunks + i;
    found->count = end - i;
  }
  if (!found->count)
    return fvv_fail(diagnostic, FVV_ERROR_DAMAGED, FVV_ISSUE_GROUP_END, 0,
                    fvv_file_group(s->file, group)->offset,
                    "frame %zu is lost: group %u has fewer intact frames than the index states", frame,
                    fvv_file_group(s->file, group)->sequence);
  return FVV_OK;
}

fvv_status fvv_stream_frame(fvv_stream *stream, size_t frame, fvv_frame *out, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  frame_chunks found;
  const fvv_status status = find_frame(stream, frame, &found, diagnostic);
  if (status < 0) return status;
  out->time = found.chunks[0].time;
  out->group = found.group;
  return FVV_OK;
}

static void release_cameras(fvv_stream *stream) {
  fvv_calibration_destroy(stream->calibration);
  stream->calibration = NULL;
  stream->calibration_chunk = 0;
}

fvv_status fvv_stream_configuration(fvv_stream *stream, size_t group, const fvv_configuration **configuration,
                                    fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_group_info *info = fvv_file_group(stream->file, group);
  if (!info)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "group %zu of %zu", group,
                    fvv_file_group_count(stream->file));
  /* A group whose block is lost names none: a repetition may replace it, another for each group. */
  const uint64_t offset = info->configuration_offset ? info->configuration_offset : ~(uint64_t)group;
  if (offset != stream->configuration_offset) {
    stream->configuration_offset = 0;
    release_cameras(stream); /* names are borrowed */
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
      if (fvv_configuration_survives(&header, status)) status = FVV_OK;
    }
    if (status >= 0)
      status = fvv_configuration_complete(&stream->configuration, info->configuration_offset, diagnostic);
    if (status < 0) return status;
    stream->configuration_offset = offset;
  }
  *configuration = &stream->configuration.view;
  return FVV_OK;
}

/* The frame's chunk of a type on a track; NULL: it has none. */
static const fvv_chunk_info *chunk_of(const frame_chunks *found, uint32_t type, uint16_t track) {
  for (size_t i = 0; i < found->count; i++)
    if (found->chunks[i].type == type && found->chunks[i].track == track) return &found->chunks[i];
  return NULL;
}

/* A frame and the configuration that holds for it. */
static fvv_status find_configured(fvv_stream *s, size_t frame, frame_chunks *found,
                                  const fvv_configuration **configuration, fvv_diagnostic *diagnostic) {
  const fvv_status status = find_frame(s, frame, found, diagnostic);
  return status < 0 ? status : fvv_stream_configuration(s, found->group, configuration, diagnostic);
}

fvv_status fvv_stream_sample(fvv_stream *stream, size_t frame, uint16_t track, const uint8_t **sample,
                             size_t *size, int *key, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *sample = NULL;
  *size = 0;
  /* The configuration first: reading it uses the buffer that the sample will be in. */
  frame_chunks found;
  const fvv_configuration *configuration;
  fvv_status status = find_configured(stream, frame, &found, &configuration, diagnostic);
  if (status < 0) return status;
  const fvv_video_layout *video = fvv_configuration_video(configuration, track);
  if (!video) return FVV_END;
  const fvv_chunk_info *info = chunk_of(&found, FVV_CHUNK_VIDEO_PACKET, track);
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

/* Errors of the stream stay; others may be gone in the next call. */
static fvv_status remember(fvv_known_failure *known, uint64_t chunk, fvv_status status,
                           const fvv_diagnostic *found, fvv_diagnostic *diagnostic) {
  const fvv_known_failure failure = {chunk, status, *found};
  if (status <= FVV_ERROR_DAMAGED && status > FVV_ERROR_BUG) *known = failure;
  if (diagnostic) *diagnostic = *found;
  return status;
}
static fvv_status fail_again(const fvv_known_failure *known, fvv_diagnostic *diagnostic) {
  if (diagnostic) *diagnostic = known->diagnostic;
  return known->status;
}

/* Cameras of frames by number. A CALB chunk is decoded from the key of its group on; the position of the
 * track is kept, so that frames in order cost one step each. */

static int is_calibration(const fvv_chunk_info *chunk) {
  return chunk->type == FVV_CHUNK_CALIBRATION;
}

/* Decodes all from the key to wanted that was not decoded yet. first: the group's list, in which wanted
 * is. */
static fvv_status follow_cameras(fvv_stream *s, const fvv_chunk_info *first, const fvv_chunk_info *wanted,
                                 fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *next = wanted;
  while (next > first && next->offset != s->calibration_chunk &&
         next->offset != s->calibration_failure.chunk &&
         !(is_calibration(next) && next->flags & FVV_FLAG_KEY))
    next--;
  if (next->offset == s->calibration_failure.chunk) return fail_again(&s->calibration_failure, diagnostic);
  if (next->offset == s->calibration_chunk) next++;
  s->calibration_chunk = 0;
  for (; next <= wanted; next++) {
    if (!is_calibration(next)) continue;
    const uint8_t *payload;
    fvv_diagnostic found = {0};
    fvv_status status = fvv_file_read_chunk(s->file, next, &payload, &found);
    if (status == FVV_OK) {
      status = fvv_calibration_decode(s->calibration, payload, (size_t)next->size, next->flags & FVV_FLAG_KEY,
                                      &found);
      if (status != FVV_OK)
        fvv_diagnostic_rebase(&found, next->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_CALIBRATION);
    }
    if (status != FVV_OK) return remember(&s->calibration_failure, next->offset, status, &found, diagnostic);
  }
  s->calibration_chunk = wanted->offset;
  return FVV_OK;
}

/* Every configuration has a calibration of its own; loading another configuration releases it. */
static fvv_status prepare(fvv_stream *s, const fvv_configuration *configuration, fvv_diagnostic *diagnostic) {
  if (s->calibration) return FVV_OK;
  const fvv_status status = fvv_calibration_create(configuration->cameras, configuration->camera_count,
                                                   &s->allocator, &s->calibration);
  return status == FVV_OK ? status : fvv_fail(diagnostic, status, 0, 0, 0, "out of memory");
}

/* Where the cameras of a frame that move are, decoded; belongs to the stream, valid until the next call on
 * it. FVV_END: there is no calibration at its time. */
static fvv_status calibration_of(fvv_stream *stream, const frame_chunks *found,
                                 const fvv_configuration *configuration, const fvv_calibration **calibration,
                                 fvv_diagnostic *diagnostic) {
  for (size_t i = 0; i < found->count; i++) {
    if (!is_calibration(&found->chunks[i])) continue;
    fvv_status status = prepare(stream, configuration, diagnostic);
    if (status == FVV_OK) status = follow_cameras(stream, found->first, &found->chunks[i], diagnostic);
    if (status == FVV_OK) *calibration = stream->calibration;
    return status;
  }
  return FVV_END;
}

fvv_status fvv_stream_camera(fvv_stream *stream, size_t frame, uint16_t id, fvv_camera *camera,
                             fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  frame_chunks found;
  const fvv_configuration *configuration;
  fvv_status status = find_configured(stream, frame, &found, &configuration, diagnostic);
  if (status < 0) return status;
  const fvv_camera *constant = fvv_configuration_camera(configuration, id);
  if (!constant) return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "camera %u is not described", id);
  if (!(constant->flags & FVV_CAMERA_MOVES)) {
    *camera = *constant;
    return FVV_OK;
  }
  const fvv_calibration *calibration;
  status = calibration_of(stream, &found, configuration, &calibration, diagnostic);
  return status == FVV_OK ? fvv_calibration_camera(calibration, id, camera) : status;
}

/* The layout of a video track in a group: that of its TILE, else that of the configuration. What was decoded
 * last is kept for each track. */

typedef struct followed_tiles {
  uint16_t track;
  uint64_t chunk;  /* offset of the TILE that was decoded last; 0: none */
  fvv_bytes tiles; /* fvv_tile */
} followed_tiles;

static void release_tiles(fvv_stream *stream) {
  followed_tiles *tracks = (followed_tiles *)stream->layouts.data;
  for (size_t i = 0; i < stream->layouts.size / sizeof *tracks; i++) fvv_bytes_free(&tracks[i].tiles);
  fvv_bytes_free(&stream->layouts);
}

/* Of the chunks between GRUP and a sample that the group's table does not list: those that are known not to
 * be a layout of the sample's track. */
static size_t count_others(const fvv_stream *s, size_t group, const fvv_chunk_info *sample) {
  const fvv_chunk_info *chunks;
  size_t count, others = 0;
  fvv_file_unlisted_chunks(s->file, group, &chunks, &count);
  for (size_t i = 0; i < count && chunks[i].offset < sample->offset; i++)
    others += chunks[i].type != FVV_CHUNK_TILES || chunks[i].track != sample->track;
  return others;
}

/* If both a layout and the table of its group are lost, the layout of the configuration would be used without
 * notice. The continuity counter of a sample shows how many chunks of the group precede it. listed: of them.
 */
static fvv_status check_complete(fvv_stream *s, size_t group, size_t listed, const fvv_chunk_info *sample,
                                 fvv_diagnostic *diagnostic) {
  fvv_chunk_header header;
  const fvv_status status = fvv_file_load(s->file, sample->offset, &header, diagnostic);
  if (status < 0) return status;
  if (header.counter == (uint8_t)(listed + count_others(s, group, sample) + 1)) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_DAMAGED, FVV_ISSUE_CONTINUITY, FVV_CHUNK_VIDEO_PACKET, sample->offset,
                  "chunks before the first sample of track %u are missing: its layout may be among them",
                  sample->track);
}

/* The TILE of the group; NULL: it has none. */
static fvv_status find_layout(fvv_stream *s, size_t group, uint16_t track, const fvv_chunk_info **layout,
                              fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *chunks, *sample = NULL;
  size_t count;
  *layout = NULL;
  const fvv_status status = fvv_file_group_chunks(s->file, group, &chunks, &count, diagnostic);
  if (status < 0) return status;
  for (size_t i = 0; i < count; i++) {
    if (chunks[i].track != track) continue;
    if (chunks[i].type == FVV_CHUNK_VIDEO_PACKET && !sample) sample = &chunks[i];
    if (chunks[i].type != FVV_CHUNK_TILES) continue;
    if (*layout || sample)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TILE_GROUP, FVV_CHUNK_TILES, chunks[i].offset,
                      "layout of track %u is not the only one, or follows a sample", track);
    *layout = &chunks[i];
  }
  if (*layout || !sample || fvv_file_group(s->file, group)->intact) return FVV_OK;
  return check_complete(s, group, (size_t)(sample - chunks), sample, diagnostic);
}

fvv_status fvv_stream_tiles(fvv_stream *stream, size_t group, uint16_t track, const fvv_tile **tiles,
                            size_t *count, fvv_diagnostic *diagnostic) {
  *tiles = NULL;
  *count = 0;
  const fvv_configuration *configuration;
  fvv_status status = fvv_stream_configuration(stream, group, &configuration, diagnostic);
  if (status < 0) return status;
  const fvv_video_layout *video = fvv_configuration_video(configuration, track);
  if (!video || !video->tile_count) return FVV_END;
  const fvv_chunk_info *layout;
  status = find_layout(stream, group, track, &layout, diagnostic);
  if (status < 0) return status;
  if (!layout) {
    *tiles = video->tiles;
    *count = video->tile_count;
    return FVV_OK;
  }
  void *kept = NULL;
  status = kept_of(stream, &stream->layouts, sizeof(followed_tiles), track, &kept);
  if (status < 0) return fvv_fail(diagnostic, status, 0, 0, 0, "%s", fvv_status_text(status));
  followed_tiles *followed = kept;
  if (followed->chunk != layout->offset) {
    followed->chunk = 0;
    followed->tiles.allocator = stream->allocator;
    const uint8_t *payload;
    status = fvv_file_read_chunk(stream->file, layout, &payload, diagnostic);
    if (status < 0) return status;
    status = fvv_group_tiles_decode(configuration, track, payload, (size_t)layout->size, &stream->limits,
                                    &followed->tiles, diagnostic);
    if (status < 0) {
      fvv_fail(diagnostic, status, 0, FVV_CHUNK_TILES, 0, "%s", fvv_status_text(status));
      fvv_diagnostic_rebase(diagnostic, layout->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_TILES);
      return status;
    }
    followed->chunk = layout->offset;
  }
  *tiles = (const fvv_tile *)followed->tiles.data;
  *count = followed->tiles.size / sizeof(fvv_tile);
  return FVV_OK;
}

/* Meshes of frames by number. A delta frame is decoded from the key mesh of its group on; the position of
 * each track is kept, so that frames in order cost one step each. */

typedef struct followed_track {
  uint16_t track;
  uint64_t key, last; /* offsets of the chunks of the key mesh and of the current frame */
  fvv_mesh_frames frames;
  fvv_known_failure failure;
} followed_track;

static void release_meshes(fvv_stream *stream) {
  followed_track *tracks = (followed_track *)stream->meshes.data;
  for (size_t i = 0; i < stream->meshes.size / sizeof *tracks; i++) fvv_mesh_frames_reset(&tracks[i].frames);
  fvv_bytes_free(&stream->meshes);
}

/* Decodes the track's next chunk. */
static fvv_status decode_mesh(fvv_stream *s, followed_track *track, const fvv_chunk_info *chunk,
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

/* first: the group's list, in which wanted is. */
static fvv_status follow_meshes(fvv_stream *s, followed_track *track, const fvv_chunk_info *first,
                                const fvv_chunk_info *wanted, fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *key = wanted;
  while (key > first && !(is_mesh(key, track->track) && key->flags & FVV_FLAG_KEY)) key--;
  if (track->failure.chunk >= key->offset && track->failure.chunk <= wanted->offset)
    return fail_again(&track->failure, diagnostic);
  const fvv_chunk_info *next = key;
  if (fvv_mesh_frames_current(&track->frames) && track->key == key->offset && track->last <= wanted->offset)
    while (next <= wanted && next->offset <= track->last) next++;
  else
    fvv_mesh_frames_reset(&track->frames);
  for (; next <= wanted; next++) {
    if (!is_mesh(next, track->track)) continue;
    fvv_diagnostic found = {0};
    const fvv_status status = decode_mesh(s, track, next, &found);
    if (status != FVV_OK) return remember(&track->failure, next->offset, status, &found, diagnostic);
  }
  return FVV_OK;
}

static fvv_status decode_delta(fvv_stream *s, const frame_chunks *found, const fvv_chunk_info *wanted,
                               fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  void *kept = NULL;
  fvv_status status = kept_of(s, &s->meshes, sizeof(followed_track), wanted->track, &kept);
  if (status != FVV_OK)
    return fvv_fail(diagnostic, status, status == FVV_ERROR_LIMIT ? FVV_ISSUE_LIMIT : 0, FVV_CHUNK_MESH,
                    wanted->offset, "too many tracks with delta frames: no room for track %u", wanted->track);
  followed_track *track = kept;
  status = follow_meshes(s, track, found->first, wanted, diagnostic);
  if (status != FVV_OK) return status;
  status = fvv_mesh_copy(fvv_mesh_frames_current(&track->frames), &s->allocator, mesh);
  return status == FVV_OK ? status : fvv_fail(diagnostic, status, 0, 0, 0, "out of memory for a mesh");
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
  frame_chunks found;
  const fvv_status status = find_frame(stream, frame, &found, diagnostic);
  if (status < 0) return status;
  const fvv_chunk_info *chunk = chunk_of(&found, FVV_CHUNK_MESH, track);
  if (!chunk) return FVV_END;
  return chunk->flags & FVV_FLAG_KEY ? decode_key(stream, chunk, mesh, diagnostic)
                                     : decode_delta(stream, &found, chunk, mesh, diagnostic);
}

/* Visibility of frames by number. A chunk that is no key is decoded from the key chunk of its group on, each
 * with its mesh; the position of each track is kept. */

typedef struct followed_visibility {
  uint16_t track;
  uint64_t last; /* offset of the chunk that was decoded last; 0: none */
  fvv_visibility_frames frames;
  fvv_known_failure failure;
} followed_visibility;

static void release_visibility(fvv_stream *stream) {
  followed_visibility *tracks = (followed_visibility *)stream->visibility.data;
  for (size_t i = 0; i < stream->visibility.size / sizeof *tracks; i++)
    fvv_visibility_frames_reset(&tracks[i].frames);
  fvv_bytes_free(&stream->visibility);
}

static fvv_status find_chunk(fvv_stream *s, size_t frame, uint16_t track, const fvv_chunk_info **chunk,
                             frame_chunks *found, fvv_diagnostic *diagnostic) {
  const fvv_status status = find_frame(s, frame, found, diagnostic);
  if (status < 0) return status;
  *chunk = chunk_of(found, FVV_CHUNK_VISIBILITY, track);
  return *chunk ? FVV_OK : FVV_END;
}

/* Decodes the chunk of a frame, which is the track's next one or a key. found: of the frame. */
static fvv_status decode_visibility(fvv_stream *s, followed_visibility *track, size_t frame,
                                    const fvv_chunk_info *chunk, const frame_chunks *found,
                                    fvv_diagnostic *diagnostic) {
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
    /* Reading mesh and calibration overwrote the buffer with the payload. */
    const int has_mesh = status == FVV_OK;
    if (status >= 0) status = calibration_of(s, found, configuration, &calibration, diagnostic);
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

/* From the chunk after the last decoded one, or from a key, to that of the frame. */
static fvv_status follow_visibility(fvv_stream *s, followed_visibility *track, size_t frame,
                                    fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *chunk;
  frame_chunks found;
  size_t from = frame;
  for (;; from--) {
    const fvv_status status = find_chunk(s, from, track->track, &chunk, &found, diagnostic);
    if (status < 0) return status;
    if (status == FVV_OK && chunk->offset == track->failure.chunk)
      return fail_again(&track->failure, diagnostic);
    if (status == FVV_OK && chunk->offset == track->last) {
      if (from++ == frame) return FVV_OK;
      break;
    }
    if (!from || (status == FVV_OK && chunk->flags & FVV_FLAG_KEY)) break;
  }
  for (; from <= frame; from++) {
    fvv_status status = find_chunk(s, from, track->track, &chunk, &found, diagnostic);
    fvv_diagnostic failure = {0};
    if (status < 0) return status;
    if (status == FVV_END) continue;
    status = decode_visibility(s, track, from, chunk, &found, &failure);
    if (status < 0) return remember(&track->failure, chunk->offset, status, &failure, diagnostic);
  }
  return FVV_OK;
}

fvv_status fvv_stream_visibility(fvv_stream *stream, size_t frame, uint16_t track,
                                 const fvv_visibility **visibility, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *visibility = NULL;
  const fvv_chunk_info *chunk;
  frame_chunks found;
  fvv_status status = find_chunk(stream, frame, track, &chunk, &found, diagnostic);
  if (status != FVV_OK) return status;
  void *kept = NULL;
  status = kept_of(stream, &stream->visibility, sizeof(followed_visibility), track, &kept);
  if (status != FVV_OK)
    return fvv_fail(diagnostic, status, status == FVV_ERROR_LIMIT ? FVV_ISSUE_LIMIT : 0, FVV_CHUNK_VISIBILITY,
                    chunk->offset, "too many tracks with visibility: no room for track %u", track);
  followed_visibility *followed = kept;
  status = follow_visibility(stream, followed, frame, diagnostic);
  if (status == FVV_OK) *visibility = &followed->frames.current;
  return status;
}

/* Colours of frames by number: those of the key mesh on which the frame's mesh depends, and those of the
 * patches since. The place of each track is kept. */

typedef struct followed_colours {
  uint16_t track; /* of the meshes */
  uint64_t key;   /* offset of the chunk with the colours of the key mesh; 0: none was decoded */
  uint64_t last;  /* of the mesh that has the colours */
  fvv_bytes rgb;
} followed_colours;

static void release_colours(fvv_stream *stream) {
  followed_colours *tracks = (followed_colours *)stream->colours.data;
  for (size_t i = 0; i < stream->colours.size / sizeof *tracks; i++) fvv_bytes_free(&tracks[i].rgb);
  fvv_bytes_free(&stream->colours);
}

/* The COLR chunk at the time of a mesh that names its track. end: behind the chunks that may be it.
 * FVV_END: there is none. */
static fvv_status find_colours(fvv_stream *s, const fvv_configuration *configuration,
                               const fvv_chunk_info *key, const fvv_chunk_info *end,
                               const fvv_chunk_info **colours, fvv_diagnostic *diagnostic) {
  for (const fvv_chunk_info *chunk = key; chunk < end; chunk++) {
    const uint8_t *payload;
    fvv_colours_header header;
    if (chunk->type != FVV_CHUNK_COLOURS || chunk->time != key->time) continue;
    fvv_status status = fvv_file_read_chunk(s->file, chunk, &payload, diagnostic);
    if (status != FVV_OK) return status;
    *colours = chunk;
    status = fvv_colours_check(payload, (size_t)chunk->size, chunk->flags & FVV_FLAG_KEY, configuration,
                               &s->limits, &header, diagnostic);
    if (status != FVV_OK)
      fvv_diagnostic_rebase(diagnostic, chunk->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_COLOURS);
    if (status != FVV_OK || header.mesh_track == key->track) return status;
  }
  return FVV_END;
}

/* mesh: what the chunk describes. */
static fvv_status decode_colours(fvv_stream *s, const fvv_configuration *configuration, const fvv_mesh *mesh,
                                 const fvv_chunk_info *chunk, fvv_bytes *rgb, fvv_diagnostic *diagnostic) {
  const uint8_t *payload;
  fvv_status status = fvv_file_read_chunk(s->file, chunk, &payload, diagnostic);
  if (status != FVV_OK) return status;
  status = fvv_colours_add(payload, (size_t)chunk->size, chunk->flags & FVV_FLAG_KEY, mesh, configuration,
                           &s->limits, rgb, diagnostic);
  if (status != FVV_OK)
    fvv_diagnostic_rebase(diagnostic, chunk->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_COLOURS);
  return status;
}

static fvv_status colour_key(fvv_stream *s, const fvv_configuration *configuration, const fvv_chunk_info *key,
                             const fvv_chunk_info *chunk, followed_colours *followed,
                             fvv_diagnostic *diagnostic) {
  followed->key = 0;
  fvv_mesh mesh = {0};
  fvv_status status = decode_key(s, key, &mesh, diagnostic);
  if (status == FVV_OK) status = decode_colours(s, configuration, &mesh, chunk, &followed->rgb, diagnostic);
  fvv_mesh_free(&mesh);
  if (status != FVV_OK) return status;
  followed->key = chunk->offset;
  followed->last = key->offset;
  return FVV_OK;
}

/* Colours of the mesh before become those of a patched frame: a patch has those of its COLR or, without one,
 * the colour of what no camera shows. end: behind the chunks of the frame. */
static fvv_status colour_patch(fvv_stream *s, const fvv_configuration *configuration,
                               const fvv_mesh_frames *frames, const fvv_chunk_info *chunk,
                               const fvv_chunk_info *end, fvv_bytes *rgb, fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *coloured = NULL;
  if (fvv_mesh_frames_carry(frames, 3, configuration->texturing.unseen, rgb) != FVV_OK)
    return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory for colours");
  const fvv_mesh *patch = fvv_mesh_frames_new(frames);
  if (!patch) return FVV_OK;
  fvv_status status = find_colours(s, configuration, chunk, end, &coloured, diagnostic);
  if (status != FVV_OK) return status == FVV_END ? FVV_OK : status;
  fvv_bytes own = {NULL, 0, 0, s->allocator};
  status = decode_colours(s, configuration, patch, coloured, &own, diagnostic);
  if (status == FVV_OK) memcpy(rgb->data + rgb->size - own.size, own.data, own.size);
  fvv_bytes_free(&own);
  return status;
}

static fvv_status is_patched(fvv_stream *s, const fvv_chunk_info *chunk, int *patched,
                             fvv_diagnostic *diagnostic) {
  const uint8_t *payload;
  const fvv_status status = fvv_file_read_chunk(s->file, chunk, &payload, diagnostic);
  *patched =
      status == FVV_OK && chunk->size > FVV_MESH_PROFILE && payload[FVV_MESH_PROFILE] == FVV_MESH_PATCHED;
  return status;
}

/* From the mesh that has the colours to the wanted one. Delta frames change nothing and are passed over. */
static fvv_status follow_colours(fvv_stream *s, const fvv_configuration *configuration,
                                 const frame_chunks *found, const fvv_chunk_info *key,
                                 const fvv_chunk_info *wanted, followed_colours *followed,
                                 fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *const end = found->chunks + found->count;
  for (const fvv_chunk_info *next = key + 1; next <= wanted; next++) {
    int patched = 0;
    if (!is_mesh(next, followed->track) || next->offset <= followed->last) continue;
    fvv_status status = is_patched(s, next, &patched, diagnostic);
    if (status != FVV_OK) return status;
    if (patched) {
      void *kept = NULL;
      status = kept_of(s, &s->meshes, sizeof(followed_track), followed->track, &kept);
      if (status != FVV_OK) return fvv_fail(diagnostic, status, 0, 0, 0, "%s", fvv_status_text(status));
      followed_track *meshes = kept;
      status = follow_meshes(s, meshes, found->first, next, diagnostic);
      if (status != FVV_OK) return status;
      status = colour_patch(s, configuration, &meshes->frames, next, end, &followed->rgb, diagnostic);
      if (status != FVV_OK) {
        followed->key = 0;
        return status;
      }
    }
    followed->last = next->offset;
  }
  return FVV_OK;
}

fvv_status fvv_stream_colours(fvv_stream *stream, size_t frame, uint16_t mesh_track, const uint8_t **colours,
                              uint32_t *vertex_count, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *colours = NULL;
  *vertex_count = 0;
  frame_chunks found;
  const fvv_configuration *configuration;
  fvv_status status = find_configured(stream, frame, &found, &configuration, diagnostic);
  if (status < 0) return status;
  const fvv_chunk_info *const wanted = chunk_of(&found, FVV_CHUNK_MESH, mesh_track);
  const fvv_chunk_info *key = wanted, *chunk = NULL;
  if (!wanted) return FVV_END;
  while (key > found.first && !(is_mesh(key, mesh_track) && key->flags & FVV_FLAG_KEY)) key--;
  if (!is_mesh(key, mesh_track) || !(key->flags & FVV_FLAG_KEY)) return FVV_END;
  status = find_colours(stream, configuration, key, found.chunks + found.count, &chunk, diagnostic);
  if (status != FVV_OK) return status;
  void *kept = NULL;
  status = kept_of(stream, &stream->colours, sizeof(followed_colours), mesh_track, &kept);
  if (status != FVV_OK) return fvv_fail(diagnostic, status, 0, 0, 0, "%s", fvv_status_text(status));
  followed_colours *followed = kept;
  followed->rgb.allocator = stream->allocator;
  if (followed->key != chunk->offset || followed->last > wanted->offset)
    status = colour_key(stream, configuration, key, chunk, followed, diagnostic);
  if (status == FVV_OK)
    status = follow_colours(stream, configuration, &found, key, wanted, followed, diagnostic);
  if (status != FVV_OK) return status;
  *colours = followed->rgb.data;
  *vertex_count = (uint32_t)(followed->rgb.size / 3);
  return FVV_OK;
}

fvv_status fvv_stream_open(const fvv_input *input, const fvv_limits *limits, const fvv_allocator *allocator,
                           fvv_stream **stream, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_allocator chosen = fvv_allocator_or_default(allocator);
  *stream = fvv_allocate_zeroed(&chosen, sizeof **stream);
  if (!*stream) return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory");
  fvv_stream *s = *stream;
  s->allocator = s->firsts.allocator = s->meshes.allocator = s->visibility.allocator = s->layouts.allocator =
      s->colours.allocator = chosen;
  fvv_configuration_init(&s->configuration, limits, &chosen);
  s->limits = s->configuration.limits;
  const fvv_status status = fvv_file_open(input, limits, &chosen, &s->file, diagnostic);
  if (status < 0) {
    fvv_stream_close(s);
    *stream = NULL;
    return status;
  }
  for (size_t g = 0; g < fvv_file_group_count(s->file); g++)
    s->frame_count += fvv_file_group(s->file, g)->frame_count;
  return FVV_OK;
}

void fvv_stream_close(fvv_stream *stream) {
  if (!stream) return;
  const fvv_allocator allocator = stream->allocator;
  fvv_configuration_free(&stream->configuration);
  fvv_bytes_free(&stream->firsts);
  release_cameras(stream);
  release_meshes(stream);
  release_tiles(stream);
  release_visibility(stream);
  release_colours(stream);
  fvv_stream_release_environment(stream);
  fvv_file_close(stream->file);
  fvv_release(&allocator, stream, sizeof *stream);
}
