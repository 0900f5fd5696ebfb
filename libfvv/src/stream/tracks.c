/* The state of a track from chunk to chunk. */
#include "stream/tracks.h"

#include <string.h>

#include "base/checked.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "mesh/mesh.h"
#include "stream/configuration.h"

void fvv_mesh_frames_reset(fvv_mesh_frames *frames) {
  fvv_mesh_sequence_close(frames->sequence);
  fvv_mesh_free(&frames->key);
  memset(frames, 0, sizeof *frames);
}

fvv_status fvv_mesh_frames_check_flag(const fvv_mesh_header *header, int key, fvv_diagnostic *diagnostic) {
  if (fvv_mesh_follows(header->profile) != (key != 0)) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_KEY, FVV_CHUNK_MESH, FVV_MESH_PROFILE,
                  "mesh of profile %u, %s, in a chunk %s the key flag", header->profile,
                  fvv_mesh_profile_name(header->profile), key ? "with" : "without");
}

static fvv_status add_mesh(fvv_mesh_frames *frames, const uint8_t *payload, size_t size, int key,
                           const fvv_limits *limits, const fvv_allocator *allocator,
                           fvv_diagnostic *diagnostic) {
  fvv_mesh_header header;
  fvv_status status = fvv_mesh_peek(payload, size, limits, &header, diagnostic);
  if (status == FVV_OK) status = fvv_mesh_frames_check_flag(&header, key, diagnostic);
  if (status != FVV_OK) return status;
  if (key) {
    fvv_mesh_frames_reset(frames);
    return fvv_mesh_decode(payload, size, limits, allocator, &frames->key, diagnostic);
  }
  if (!frames->key.lattice)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_KEY, FVV_CHUNK_MESH, FVV_MESH_PROFILE,
                    "%s frame without a key mesh of its track before it in the group",
                    fvv_mesh_profile_name(header.profile));
  if (!frames->sequence)
    status = fvv_mesh_sequence_open(&frames->key, allocator, &frames->sequence, diagnostic);
  if (status != FVV_OK) return status;
  return fvv_mesh_sequence_decode(frames->sequence, payload, size, diagnostic);
}

fvv_status fvv_mesh_frames_add(fvv_mesh_frames *frames, const uint8_t *payload, size_t size, int key,
                               const fvv_limits *limits, const fvv_allocator *allocator,
                               fvv_diagnostic *diagnostic) {
  const fvv_status status = add_mesh(frames, payload, size, key, limits, allocator, diagnostic);
  if (status != FVV_OK) fvv_mesh_frames_reset(frames);
  return status;
}

const fvv_mesh *fvv_mesh_frames_current(const fvv_mesh_frames *frames) {
  if (frames->sequence) return fvv_mesh_sequence_mesh(frames->sequence);
  return frames->key.lattice ? &frames->key : NULL;
}

const fvv_mesh *fvv_mesh_frames_new(const fvv_mesh_frames *frames) {
  if (frames->sequence) return fvv_mesh_sequence_patch(frames->sequence);
  return frames->key.lattice ? &frames->key : NULL;
}

fvv_status fvv_mesh_frames_carry(const fvv_mesh_frames *frames, size_t width, const uint8_t *fresh,
                                 fvv_bytes *values) {
  uint32_t count;
  const uint32_t *kept = fvv_mesh_sequence_kept(frames->sequence, &count);
  const fvv_mesh *patch = fvv_mesh_sequence_patch(frames->sequence);
  if (!kept) return FVV_OK;
  /* Never to the right: kept[i] >= i. */
  for (size_t i = 0; i < count; i++) memmove(values->data + i * width, values->data + kept[i] * width, width);
  values->size = count * width;
  fvv_status status = FVV_OK;
  for (uint32_t v = 0; patch && v < patch->vertex_count && status == FVV_OK; v++)
    status = fvv_bytes_append(values, fresh, width);
  return status;
}

static fvv_status no_memory(fvv_diagnostic *diagnostic) {
  return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory for visibility");
}

static void free_current(const fvv_allocator *allocator, fvv_visibility *v) {
  const size_t cameras = v->header.camera_count;
  fvv_release(allocator, v->cameras, cameras * sizeof *v->cameras);
  fvv_release(allocator, v->states, cameras * v->header.vertex_count);
  memset(v, 0, sizeof *v);
}

static void free_order(fvv_visibility_frames *frames) {
  fvv_visibility_order_close(frames->order);
  fvv_release(&frames->allocator, frames->faces, 3 * (size_t)frames->face_count * sizeof *frames->faces);
  frames->order = NULL;
  frames->faces = NULL;
}

void fvv_visibility_frames_reset(fvv_visibility_frames *frames) {
  if (frames->allocator.resize) {
    free_current(&frames->allocator, &frames->current);
    free_order(frames);
  }
  memset(frames, 0, sizeof *frames);
}

static fvv_status check_number(const fvv_visibility_frames *frames, const fvv_visibility_header *header,
                               int key, fvv_diagnostic *diagnostic) {
  const fvv_visibility_header *former = &frames->current.header;
  if (!header->number == !key)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_NUMBER, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_NUMBER, "number %lu in a chunk %s the key flag", (unsigned long)header->number,
                    key ? "with" : "without");
  if (key) return FVV_OK;
  if (!former->camera_count || header->number - 1 != former->number)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_NUMBER, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_NUMBER, "number %lu does not follow the chunk before: chunks are missing",
                    (unsigned long)header->number);
  if (header->mesh_track != former->mesh_track || header->vertex_count != former->vertex_count)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_NUMBER, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_NUMBER, "mesh track or vertex count differs from the chunk before");
  return FVV_OK;
}

/* The calibration gives the position of a moving camera. */
static fvv_status centre_of(const fvv_configuration *configuration, const fvv_calibration *calibration,
                            uint16_t id, int32_t centre[3], fvv_diagnostic *diagnostic) {
  const fvv_camera *camera = fvv_configuration_camera(configuration, id);
  fvv_diagnostic why = {0};
  if (!camera)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_CAMERA, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_SIZE, "camera %u is not described", id);
  fvv_camera now;
  if (camera->flags & FVV_CAMERA_MOVES) {
    if (!calibration || fvv_calibration_camera(calibration, id, &now) != FVV_OK)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_CAMERA, FVV_CHUNK_VISIBILITY,
                      FVV_VISI_SIZE, "moving camera %u has no calibration at this time", id);
    camera = &now;
  }
  if (fvv_visibility_centre(camera, &configuration->scene, centre, &why) == FVV_OK) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_CAMERA, FVV_CHUNK_VISIBILITY,
                  FVV_VISI_SIZE, "%s", why.message);
}

/* Streams of the cameras, camera_count of them, to be released. */
static fvv_status read_streams(const uint8_t *payload, size_t size, const fvv_limits *limits,
                               const fvv_allocator *allocator, const fvv_visibility_header *header,
                               fvv_visibility_stream **streams, fvv_diagnostic *diagnostic) {
  *streams = fvv_allocate_array(allocator, header->camera_count, sizeof **streams);
  if (!*streams) return no_memory(diagnostic);
  fvv_visibility_header again;
  return fvv_visibility_peek(payload, size, limits, &again, *streams, header->camera_count, diagnostic);
}

fvv_status fvv_visibility_frames_check(const fvv_visibility_frames *frames, const uint8_t *payload,
                                       size_t size, int key, const fvv_configuration *configuration,
                                       const fvv_limits *limits, fvv_visibility_header *header,
                                       fvv_diagnostic *diagnostic) {
  fvv_status status = fvv_visibility_peek(payload, size, limits, header, NULL, 0, diagnostic);
  if (status == FVV_OK) status = check_number(frames, header, key, diagnostic);
  if (status != FVV_OK) return status;
  const fvv_track *track = fvv_configuration_track(configuration, header->mesh_track);
  if (track && track->kind == FVV_TRACK_MESH) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_MESH, FVV_CHUNK_VISIBILITY,
                  FVV_VISI_MESH_TRACK, "mesh track %u is not declared as a mesh track", header->mesh_track);
}

/* The order for the faces of mesh: the last one if they are the same. */
static fvv_status keep_order(fvv_visibility_frames *frames, const fvv_mesh *mesh,
                             fvv_diagnostic *diagnostic) {
  const size_t bytes = 3 * (size_t)mesh->face_count * sizeof *mesh->faces;
  if (frames->order && frames->face_count == mesh->face_count && frames->vertex_count == mesh->vertex_count &&
      !memcmp(frames->faces, mesh->faces, bytes))
    return FVV_OK;
  free_order(frames);
  frames->vertex_count = mesh->vertex_count;
  frames->face_count = mesh->face_count;
  frames->faces = fvv_allocate(&frames->allocator, bytes);
  if (!frames->faces) return no_memory(diagnostic);
  memcpy(frames->faces, mesh->faces, bytes);
  return fvv_visibility_order_open(mesh, &frames->allocator, &frames->order, diagnostic);
}

static const uint8_t *states_of(const fvv_visibility *v, uint16_t camera) {
  for (uint32_t i = 0; i < v->header.camera_count; i++)
    if (v->cameras[i] == camera) return v->states + (size_t)i * v->header.vertex_count;
  return NULL;
}

/* next: header is filled; arrays are allocated here. */
static fvv_status decode_cameras(fvv_visibility_frames *frames, const uint8_t *payload,
                                 const fvv_visibility_stream *streams, const fvv_mesh *mesh,
                                 const fvv_calibration *calibration, const fvv_configuration *configuration,
                                 fvv_visibility *next, fvv_diagnostic *diagnostic) {
  const fvv_visibility_header *header = &next->header;
  int32_t centre[3];
  uint64_t bytes;
  /* A table names a camera in two bytes: it has to exist before memory for its view is allocated. */
  for (uint32_t i = 0; i < header->camera_count; i++) {
    const fvv_status status = centre_of(configuration, calibration, streams[i].camera, centre, diagnostic);
    if (status != FVV_OK) return status;
  }
  const int fits = fvv_multiply_u64(header->camera_count, header->vertex_count, &bytes) && bytes <= SIZE_MAX;
  next->cameras = fvv_allocate_array(&frames->allocator, header->camera_count, sizeof *next->cameras);
  next->states = fits ? fvv_allocate(&frames->allocator, (size_t)bytes) : NULL;
  if (!next->cameras || !next->states) return no_memory(diagnostic);
  for (uint32_t i = 0; i < header->camera_count; i++) {
    next->cameras[i] = streams[i].camera;
    fvv_status status = centre_of(configuration, calibration, streams[i].camera, centre, diagnostic);
    if (status == FVV_OK)
      status = fvv_visibility_decode(frames->order, mesh, header, payload + streams[i].offset,
                                     streams[i].size, centre, states_of(&frames->current, streams[i].camera),
                                     next->states + (size_t)i * header->vertex_count, diagnostic);
    if (status == FVV_OK) continue;
    if (diagnostic && diagnostic->issue == FVV_ISSUE_VISIBILITY_STREAM)
      diagnostic->offset = streams[i].offset;
    return status;
  }
  return FVV_OK;
}

static fvv_status add_visibility(fvv_visibility_frames *frames, const uint8_t *payload, size_t size, int key,
                                 const fvv_mesh *mesh, const fvv_calibration *calibration,
                                 const fvv_configuration *configuration, const fvv_limits *limits,
                                 fvv_diagnostic *diagnostic) {
  fvv_visibility next = {0};
  fvv_status status = fvv_visibility_frames_check(frames, payload, size, key, configuration, limits,
                                                  &next.header, diagnostic);
  if (status != FVV_OK) return status;
  if (!mesh || mesh->vertex_count != next.header.vertex_count)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_VISIBILITY_MESH, FVV_CHUNK_VISIBILITY,
                    FVV_VISI_VERTEX_COUNT,
                    mesh ? "visibility has %lu vertices, the mesh at its time has %lu"
                         : "visibility has %lu vertices, but there is no mesh on its mesh track at its time",
                    (unsigned long)next.header.vertex_count, (unsigned long)(mesh ? mesh->vertex_count : 0));
  fvv_visibility_stream *streams = NULL;
  status = read_streams(payload, size, limits, &frames->allocator, &next.header, &streams, diagnostic);
  if (status == FVV_OK) status = keep_order(frames, mesh, diagnostic);
  if (status == FVV_OK)
    status = decode_cameras(frames, payload, streams, mesh, calibration, configuration, &next, diagnostic);
  fvv_release(&frames->allocator, streams, next.header.camera_count * sizeof *streams);
  if (status != FVV_OK) {
    free_current(&frames->allocator, &next);
    return status;
  }
  free_current(&frames->allocator, &frames->current);
  frames->current = next;
  return FVV_OK;
}

fvv_status fvv_visibility_frames_add(fvv_visibility_frames *frames, const uint8_t *payload, size_t size,
                                     int key, const fvv_mesh *mesh, const fvv_calibration *calibration,
                                     const fvv_configuration *configuration, const fvv_limits *limits,
                                     const fvv_allocator *allocator, fvv_diagnostic *diagnostic) {
  if (!frames->allocator.resize) frames->allocator = fvv_allocator_or_default(allocator);
  const fvv_status status =
      add_visibility(frames, payload, size, key, mesh, calibration, configuration, limits, diagnostic);
  if (status != FVV_OK) fvv_visibility_frames_reset(frames);
  return status;
}

fvv_status fvv_colours_check(const uint8_t *payload, size_t size, int key,
                             const fvv_configuration *configuration, const fvv_limits *limits,
                             fvv_colours_header *header, fvv_diagnostic *diagnostic) {
  const fvv_status status = fvv_colours_peek(payload, size, limits, header, diagnostic);
  if (status != FVV_OK) return status;
  if (!key)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_COLOURS_PAYLOAD, FVV_CHUNK_COLOURS, 0,
                    "the chunk does not have the key flag");
  const fvv_track *track = fvv_configuration_track(configuration, header->mesh_track);
  if (track && track->kind == FVV_TRACK_MESH) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_COLOURS_MESH, FVV_CHUNK_COLOURS,
                  FVV_COLR_MESH_TRACK, "mesh track %u is not declared as a mesh track", header->mesh_track);
}

fvv_status fvv_colours_add(const uint8_t *payload, size_t size, int key, const fvv_mesh *mesh,
                           const fvv_configuration *configuration, const fvv_limits *limits,
                           fvv_bytes *colours, fvv_diagnostic *diagnostic) {
  fvv_colours_header header;
  colours->size = 0;
  fvv_status status = fvv_colours_check(payload, size, key, configuration, limits, &header, diagnostic);
  if (status != FVV_OK) return status;
  if (!mesh)
    return fvv_fail(
        diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_COLOURS_MESH, FVV_CHUNK_COLOURS, FVV_COLR_MESH_TRACK,
        "there is no key mesh and no patch on track %u at the time of its colours", header.mesh_track);
  uint64_t bytes;
  if (!fvv_multiply_u64(mesh->vertex_count, 3, &bytes) || bytes > SIZE_MAX ||
      fvv_bytes_reserve(colours, (size_t)bytes) != FVV_OK)
    return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "out of memory for colours");
  status = fvv_colours_decode(payload, size, mesh, limits, &colours->allocator, colours->data, diagnostic);
  if (status == FVV_OK) colours->size = (size_t)bytes;
  return status;
}

static int shows(const fvv_video_layout *video, uint16_t camera) {
  for (size_t i = 0; i < video->tile_count; i++)
    if (video->tiles[i].camera_id == camera) return 1;
  return 0;
}

fvv_status fvv_group_tiles_decode(const fvv_configuration *configuration, uint16_t track,
                                  const uint8_t *payload, size_t size, const fvv_limits *limits,
                                  fvv_bytes *tiles, fvv_diagnostic *diagnostic) {
  tiles->size = 0;
  const fvv_video_layout *video = fvv_configuration_video(configuration, track);
  if (!video || video->config.shows != FVV_SHOWS_TILES)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TILE_SHOWN, FVV_CHUNK_TILES, 0,
                    "track %u does not show tiles", track);
  /* No more tiles than the payload has bytes for. */
  const size_t most = size / FVV_TILE_ENTRY_SIZE;
  fvv_status status = fvv_bytes_reserve(tiles, most * sizeof(fvv_tile));
  if (status < 0) return status;
  size_t count = 0;
  status = fvv_tiles_decode((fvv_tile *)tiles->data, most, &count, payload, size, limits, diagnostic);
  const fvv_tile *decoded = (const fvv_tile *)tiles->data;
  for (size_t i = 0; i < count && status == FVV_OK; i++)
    if (!shows(video, decoded[i].camera_id))
      status = fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TILE_SHOWN, FVV_CHUNK_TILES,
                        FVV_TILE_SIZE + i * FVV_TILE_ENTRY_SIZE,
                        "tile %zu shows camera %u, which is not in the configuration's TILE of track %u", i,
                        decoded[i].camera_id, track);
  if (status == FVV_OK)
    status = fvv_configuration_check_tiles(configuration, video, decoded, count, diagnostic);
  if (status == FVV_OK) tiles->size = count * sizeof(fvv_tile);
  return status;
}
