/* One whole frame, decoded track by track into the structs of wasm_structs.h. */
#include <string.h>

#include "base/checked.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "decoder.h"
#include "mesh/patched.h"
#include "stream/tracks.h"

static size_t track_count(const fvvjs_decoder *d) {
  return d->tracks.size / sizeof(fvvjs_track);
}
static fvvjs_track *track_at(const fvvjs_decoder *d, size_t i) {
  return (fvvjs_track *)d->tracks.data + i;
}

void fvvjs_begin_group(fvvjs_decoder *d) {
  for (size_t i = 0; i < track_count(d); i++) {
    fvv_mesh_frames_reset(&track_at(d, i)->meshes);
    fvv_visibility_frames_reset(&track_at(d, i)->visibility);
    track_at(d, i)->tiles.size = track_at(d, i)->colours.size = 0;
    memset(&track_at(d, i)->place, 0, sizeof track_at(d, i)->place);
  }
  if (d->calibration) fvv_calibration_reset(d->calibration);
}

void fvvjs_release_tracks(fvvjs_decoder *d) {
  for (size_t i = 0; i < track_count(d); i++) {
    fvvjs_track *track = track_at(d, i);
    fvv_mesh_frames_reset(&track->meshes);
    fvv_visibility_frames_reset(&track->visibility);
    fvv_bytes_free(&track->positions);
    fvv_bytes_free(&track->normals);
    fvv_bytes_free(&track->texture);
    fvv_bytes_free(&track->tiles);
    fvv_bytes_free(&track->weights);
    fvv_bytes_free(&track->colours);
    fvv_bytes_free(&track->sizes);
  }
  fvv_bytes_free(&d->tracks);
  fvv_calibration_destroy(d->calibration);
  d->calibration = NULL;
}

static fvv_status find_track(fvvjs_decoder *d, uint16_t id, fvvjs_track **track) {
  for (size_t i = 0; i < track_count(d); i++)
    if (track_at(d, i)->id == id) {
      *track = track_at(d, i);
      return FVV_OK;
    }
  if (track_count(d) >= d->limits.max_tracks) return FVV_ERROR_LIMIT;
  fvvjs_track fresh;
  memset(&fresh, 0, sizeof fresh);
  fresh.id = id;
  fvv_bytes *const lists[] = {&fresh.positions, &fresh.normals, &fresh.texture, &fresh.tiles,
                              &fresh.weights,   &fresh.colours, &fresh.sizes};
  for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) lists[i]->allocator = d->allocator;
  const fvv_status status = fvv_bytes_append(&d->tracks, &fresh, sizeof fresh);
  if (status == FVV_OK) *track = track_at(d, track_count(d) - 1);
  return status;
}

/* Room for count floats, which replace what was there. */
static float *floats(fvv_bytes *bytes, uint32_t count, uint32_t components) {
  uint64_t size;
  if (!fvv_multiply_u64(count, components * sizeof(float), &size) || size > SIZE_MAX) return NULL;
  bytes->size = 0;
  if (fvv_bytes_reserve(bytes, (size_t)size) != FVV_OK) return NULL;
  return (float *)bytes->data;
}

static fvv_status no_memory(fvvjs_decoder *d) {
  return fvv_fail(&d->diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory for a frame");
}

static fvv_status fill_floats(fvvjs_decoder *d, fvvjs_track *track, const fvv_mesh *mesh, uint32_t want,
                              wasm_mesh *record) {
  const fvv_scene *scene = &d->configuration->scene;
  if (want & FVVJS_WANT_FLOATS) {
    float *positions = floats(&track->positions, mesh->vertex_count, 3);
    if (!positions) return no_memory(d);
    fvv_lattice_to_floats(scene->lattice_origin, scene->lattice_step, mesh->lattice, mesh->vertex_count,
                          positions);
    record->positions = positions;
    if (mesh->texture) {
      float *texture = floats(&track->texture, mesh->vertex_count, 2);
      if (!texture) return no_memory(d);
      fvv_texture_to_floats(mesh->texture_bits, mesh->texture, mesh->vertex_count, texture);
      record->texture = texture;
    }
  }
  if (want & FVVJS_WANT_NORMALS) {
    float *normals = floats(&track->normals, mesh->vertex_count, 3);
    if (!normals) return no_memory(d);
    record->normals = normals;
    return fvv_mesh_normals(mesh, &d->allocator, normals, &d->diagnostic);
  }
  return FVV_OK;
}

/* Those of a key mesh follow it, and hold for the frames after it. A patch has the colour of what no camera
 * shows until its own follow. */
static fvv_status begin_colours(const fvvjs_decoder *d, fvvjs_track *track, int key) {
  const uint8_t *rgb = d->configuration->texturing.unseen, rgba[4] = {rgb[0], rgb[1], rgb[2], 255};
  if (key) track->colours.size = 0;
  return track->colours.size ? fvv_mesh_frames_carry(&track->meshes, sizeof rgba, rgba, &track->colours)
                             : FVV_OK;
}

static fvv_status decode_mesh(fvvjs_decoder *d, const fvv_frame_chunk *chunk, const uint8_t *payload,
                              uint32_t want) {
  fvvjs_track *track;
  fvv_mesh_header header;
  const int key = (chunk->header.flags & FVV_FLAG_KEY) != 0;
  const size_t size = (size_t)chunk->header.size;
  fvv_status status = find_track(d, chunk->header.track, &track);
  if (status == FVV_OK) status = fvv_mesh_peek(payload, size, &d->limits, &header, &d->diagnostic);
  if (status == FVV_OK)
    status =
        fvv_mesh_frames_add(&track->meshes, payload, size, key, &d->limits, &d->allocator, &d->diagnostic);
  if (status != FVV_OK) return status;
  track->mesh_time = chunk->header.time;
  if (begin_colours(d, track, key) != FVV_OK) return no_memory(d);
  const fvv_mesh *mesh = fvv_mesh_frames_current(&track->meshes);
  wasm_mesh record = {track->id,
                      header.profile,
                      (uint32_t)key,
                      mesh->vertex_count,
                      mesh->face_count,
                      mesh->lattice,
                      mesh->faces,
                      NULL,
                      NULL,
                      NULL,
                      track->colours.size ? track->colours.data : NULL};
  status = fill_floats(d, track, mesh, want, &record);
  if (status != FVV_OK) return status;
  return fvv_bytes_append(&d->lists[FVVJS_MESHES], &record, sizeof record);
}

static fvv_status decode_visibility(fvvjs_decoder *d, const fvv_frame_chunk *chunk, const uint8_t *payload,
                                    uint32_t want) {
  fvvjs_track *track;
  fvv_visibility_header header;
  const size_t size = (size_t)chunk->header.size;
  if (!(want & FVVJS_WANT_VISIBILITY)) return FVV_OK;
  fvv_status status = find_track(d, chunk->header.track, &track);
  if (status == FVV_OK)
    status = fvv_visibility_peek(payload, size, &d->limits, &header, NULL, 0, &d->diagnostic);
  if (status != FVV_OK) return status;
  const fvv_mesh *mesh = NULL;
  for (size_t i = 0; i < track_count(d); i++)
    if (track_at(d, i)->id == header.mesh_track && track_at(d, i)->mesh_time == chunk->header.time)
      mesh = fvv_mesh_frames_current(&track_at(d, i)->meshes);
  const fvv_calibration *calibration = d->calibration_time == chunk->header.time ? d->calibration : NULL;
  status =
      fvv_visibility_frames_add(&track->visibility, payload, size, chunk->header.flags & FVV_FLAG_KEY, mesh,
                                calibration, d->configuration, &d->limits, &d->allocator, &d->diagnostic);
  if (status != FVV_OK) return status;
  const fvv_visibility *seen = &track->visibility.current;
  const size_t count = (size_t)seen->header.camera_count * seen->header.vertex_count;
  /* One byte more, so that an empty mesh has an address. */
  if (fvv_bytes_reserve(&track->weights, count + 1) != FVV_OK) return no_memory(d);
  fvv_visibility_weights(seen->states, count, track->weights.data);
  const wasm_visibility record = {track->id,
                                  seen->header.mesh_track,
                                  seen->header.threshold,
                                  seen->header.camera_count,
                                  seen->header.vertex_count,
                                  seen->cameras,
                                  track->weights.data};
  return fvv_bytes_append(&d->lists[FVVJS_VISIBILITY], &record, sizeof record);
}

/* Three bytes a vertex become four, as graphics hardware reads them, from the last one on. */
static fvv_status fill_alpha(fvv_bytes *colours) {
  const size_t count = colours->size / 3;
  if (fvv_bytes_reserve(colours, count) != FVV_OK) return FVV_ERROR_MEMORY;
  for (size_t i = count; i-- > 0;) {
    uint8_t *const rgba = colours->data + 4 * i;
    memmove(rgba, colours->data + 3 * i, 3);
    rgba[3] = 255;
  }
  colours->size = 4 * count;
  return FVV_OK;
}

/* Colours of a key mesh, or of the last vertices those of a patch. */
static fvv_status put_colours(fvvjs_track *track, const fvv_bytes *colours) {
  if (fvv_mesh_frames_new(&track->meshes) == fvv_mesh_frames_current(&track->meshes))
    track->colours.size = 0;
  else if (track->colours.size)
    track->colours.size -= colours->size;
  else
    return FVV_OK;
  return fvv_bytes_append(&track->colours, colours->data, colours->size);
}

static fvv_status decode_colours(fvvjs_decoder *d, const fvv_frame_chunk *chunk, const uint8_t *payload) {
  fvv_colours_header header;
  const size_t size = (size_t)chunk->header.size;
  fvv_status status = fvv_colours_peek(payload, size, &d->limits, &header, &d->diagnostic);
  fvvjs_track *of = NULL;
  for (size_t i = 0; i < track_count(d) && status == FVV_OK; i++)
    if (track_at(d, i)->id == header.mesh_track && track_at(d, i)->mesh_time == chunk->header.time)
      of = track_at(d, i);
  fvv_bytes colours = {NULL, 0, 0, d->allocator};
  if (status == FVV_OK)
    status = fvv_colours_add(payload, size, chunk->header.flags & FVV_FLAG_KEY,
                             of ? fvv_mesh_frames_new(&of->meshes) : NULL, d->configuration, &d->limits,
                             &colours, &d->diagnostic);
  if (status == FVV_OK) status = fill_alpha(&colours);
  if (status == FVV_OK) status = put_colours(of, &colours);
  fvv_bytes_free(&colours);
  wasm_mesh *meshes = (wasm_mesh *)d->lists[FVVJS_MESHES].data;
  for (size_t i = 0; status == FVV_OK && i < d->lists[FVVJS_MESHES].size / sizeof *meshes; i++)
    if (meshes[i].track == header.mesh_track) meshes[i].colours = of->colours.size ? of->colours.data : NULL;
  return status;
}

static fvv_status decode_calibration(fvvjs_decoder *d, const fvv_frame_chunk *chunk, const uint8_t *payload) {
  const fvv_configuration *c = d->configuration;
  if (!d->calibration) {
    const fvv_status created =
        fvv_calibration_create(c->cameras, c->camera_count, &d->allocator, &d->calibration);
    if (created != FVV_OK) return no_memory(d);
  }
  const fvv_status status = fvv_calibration_decode(d->calibration, payload, (size_t)chunk->header.size,
                                                   chunk->header.flags & FVV_FLAG_KEY, &d->diagnostic);
  if (status != FVV_OK) return status;
  d->calibration_time = chunk->header.time;
  for (size_t i = 0; i < c->camera_count; i++) {
    fvv_camera camera;
    if (!(c->cameras[i].flags & FVV_CAMERA_MOVES)) continue;
    if (fvv_calibration_camera(d->calibration, c->cameras[i].id, &camera) != FVV_OK) continue;
    if (fvv_bytes_append(&d->lists[FVVJS_MOVING], &camera, sizeof camera) != FVV_OK) return no_memory(d);
  }
  return FVV_OK;
}

static fvv_status take_sample(fvvjs_decoder *d, const fvv_frame_chunk *chunk, const uint8_t *payload) {
  const fvv_video_layout *video = fvv_configuration_video(d->configuration, chunk->header.track);
  if (!video) return FVV_OK;
  const int key = (chunk->header.flags & FVV_FLAG_KEY) != 0;
  const fvv_status status =
      fvv_video_sample_check(&video->config, key, payload, (size_t)chunk->header.size, &d->diagnostic);
  if (status != FVV_OK) return status;
  const wasm_sample record = {chunk->header.track, (uint32_t)key, payload, (uint32_t)chunk->header.size};
  return fvv_bytes_append(&d->lists[FVVJS_SAMPLES], &record, sizeof record);
}

/* Holds for the frames of the group. */
static fvv_status decode_layout(fvvjs_decoder *d, const fvv_frame_chunk *chunk, const uint8_t *payload) {
  fvvjs_track *track;
  const fvv_status status = find_track(d, chunk->header.track, &track);
  if (status != FVV_OK) return status;
  return fvv_group_tiles_decode(d->configuration, chunk->header.track, payload, (size_t)chunk->header.size,
                                &d->limits, &track->tiles, &d->diagnostic);
}

static fvv_status put_layouts(fvvjs_decoder *d) {
  for (size_t i = 0; i < track_count(d); i++) {
    const fvv_bytes *tiles = &track_at(d, i)->tiles;
    const wasm_layout record = {track_at(d, i)->id,
                                {tiles->data, (uint32_t)(tiles->size / sizeof(fvv_tile))}};
    if (!record.tiles.count) continue;
    if (fvv_bytes_append(&d->lists[FVVJS_LAYOUTS], &record, sizeof record) != FVV_OK) return no_memory(d);
  }
  return FVV_OK;
}

static fvv_status take_environment(fvvjs_decoder *d, const fvv_frame_chunk *chunk, const uint8_t *payload) {
  const wasm_sample record = {chunk->header.track, 1, payload, (uint32_t)chunk->header.size};
  return fvv_bytes_append(&d->lists[FVVJS_ENVIRONMENTS], &record, sizeof record);
}

/* The packets stay where they are; JavaScript takes them apart. */
static fvv_status take_sound(fvvjs_decoder *d, const fvv_frame_chunk *chunk, const uint8_t *payload) {
  const fvv_audio_config *config = fvv_configuration_audio(d->configuration, chunk->header.track);
  if (!config || !fvv_audio_codec_known(config->codec)) return FVV_OK;
  const size_t size = (size_t)chunk->header.size, most = size / 3;
  fvvjs_track *track;
  fvv_audio_chunk sound;
  fvv_status status = find_track(d, chunk->header.track, &track);
  if (status != FVV_OK) return status;
  uint64_t bytes;
  if (!fvv_multiply_u64(most, sizeof(fvv_audio_packet), &bytes) || bytes > SIZE_MAX) return no_memory(d);
  track->sizes.size = 0;
  if (fvv_bytes_reserve(&track->sizes, (size_t)bytes) != FVV_OK) return no_memory(d);
  fvv_audio_packet *packets = (fvv_audio_packet *)track->sizes.data;
  status = fvv_audio_decode(config, payload, size, &sound, packets, most, &d->diagnostic);
  if (status == FVV_OK)
    status = fvv_audio_follow(&track->place, config, d->configuration->scene.time_base, &sound,
                              chunk->header.flags & FVV_FLAG_KEY, chunk->header.time, d->group_end,
                              &d->diagnostic);
  if (status != FVV_OK) return status;
  const uint8_t *data = packets[0].data;
  uint8_t *sizes = track->sizes.data; /* in place of the packets, each of which is larger */
  size_t data_size = 0;               /* what follows the packets is of a later version */
  for (uint32_t i = 0; i < sound.packet_count; i++) {
    data_size += packets[i].size;
    const uint16_t bytes_of_packet = (uint16_t)packets[i].size;
    memcpy(sizes + 2 * (size_t)i, &bytes_of_packet, sizeof bytes_of_packet);
  }
  const wasm_sound record = {track->id,
                             sound.start,
                             sound.packet_count,
                             sound.preroll_count,
                             {sound.position[0], sound.position[1], sound.position[2]},
                             (const uint16_t *)sizes,
                             data,
                             (uint32_t)data_size};
  return fvv_bytes_append(&d->lists[FVVJS_SOUNDS], &record, sizeof record);
}

static fvv_status decode_chunk(fvvjs_decoder *d, const fvv_frame_chunk *chunk, const uint8_t *payload,
                               uint32_t want) {
  switch (chunk->header.type) {
  case FVV_CHUNK_MESH:
    return decode_mesh(d, chunk, payload, want);
  case FVV_CHUNK_VISIBILITY:
    return decode_visibility(d, chunk, payload, want);
  case FVV_CHUNK_COLOURS:
    return decode_colours(d, chunk, payload);
  case FVV_CHUNK_CALIBRATION:
    return decode_calibration(d, chunk, payload);
  case FVV_CHUNK_TILES:
    return decode_layout(d, chunk, payload);
  case FVV_CHUNK_ENVIRONMENT:
    return take_environment(d, chunk, payload);
  case FVV_CHUNK_AUDIO:
    return take_sound(d, chunk, payload);
  case FVV_CHUNK_VIDEO_PACKET:
    return take_sample(d, chunk, payload);
  default:
    return FVV_OK;
  }
}

/* That of its patch, for a patched frame. */
static uint32_t mesh_codec_of(const fvvjs_decoder *d, const uint8_t *payload, size_t size) {
  fvv_mesh_header header;
  fvv_patched_parts parts;
  if (payload[FVV_MESH_PROFILE] != FVV_MESH_PATCHED) return fvvjs_mesh_codec(payload[FVV_MESH_PROFILE]);
  if (fvv_mesh_peek(payload, size, &d->limits, &header, NULL) != FVV_OK ||
      fvv_patched_split(payload + FVV_MESH_SIZE, &header, &d->limits, &parts, NULL) != FVV_OK)
    return 0;
  return parts.patch_size ? fvvjs_mesh_codec(parts.header.profile) : 0;
}

static uint32_t codec_of(const fvvjs_decoder *d, const fvv_frame_chunk *chunk) {
  if (chunk->header.type == FVV_CHUNK_MESH && chunk->header.size)
    return mesh_codec_of(d, chunk->payload, (size_t)chunk->header.size);
  if (chunk->header.type == FVV_CHUNK_VIDEO_PACKET && d->configuration) {
    const fvv_video_layout *video = fvv_configuration_video(d->configuration, chunk->header.track);
    if (video && video->config.codec == FVV_CODEC_OEXR) return FVVJS_CODEC_OPENEXR;
  }
  return 0;
}

/* Which codecs the ready frame needs, FVVJS_CODEC_..., so that they can be fetched before. */
FVVJS_EXPORT uint32_t fvvjs_codecs(const fvvjs_decoder *d) {
  uint32_t codecs = 0;
  for (size_t i = 0; i < d->event.chunk_count; i++) codecs |= codec_of(d, &d->event.chunks[i]);
  return codecs;
}

/* The same for the mesh of the frame that is still arriving. */
FVVJS_EXPORT uint32_t fvvjs_codecs_ahead(const fvvjs_decoder *d) {
  fvv_frame_chunk chunk;
  return d->frames && fvv_frames_peek(d->frames, FVV_CHUNK_MESH, &chunk) ? codec_of(d, &chunk) : 0;
}

static wasm_list list_of(const fvvjs_decoder *d, int list, size_t size) {
  const wasm_list all = {d->lists[list].data, (uint32_t)(d->lists[list].size / size)};
  return all;
}

/* Decodes the ready frame. want: 0 when only frames after it are wanted. On error the diagnostic says why,
 * and the rest of the group is dropped. */
FVVJS_EXPORT int32_t fvvjs_decode(fvvjs_decoder *d, uint32_t want) {
  const fvv_frame_chunk *chunks = d->event.chunks;
  for (int i = 0; i < FVVJS_LISTS; i++) d->lists[i].size = 0;
  memset(&d->diagnostic, 0, sizeof d->diagnostic);
  memset(&d->frame, 0, sizeof d->frame);
  for (size_t i = 0; i < d->event.chunk_count; i++) {
    const fvv_status status = decode_chunk(d, &chunks[i], chunks[i].payload, want);
    if (status == FVV_OK) continue;
    fvv_fail(&d->diagnostic, status, 0, 0, 0, "%s", fvv_status_text(status));
    fvv_diagnostic_rebase(&d->diagnostic, chunks[i].offset + FVV_CHUNK_HEADER_SIZE, chunks[i].header.type);
    fvv_frames_drop_group(d->frames);
    return status;
  }
  if (put_layouts(d) != FVV_OK) return FVV_ERROR_MEMORY;
  d->frame.time = d->event.time;
  d->frame.meshes = list_of(d, FVVJS_MESHES, sizeof(wasm_mesh));
  d->frame.visibility = list_of(d, FVVJS_VISIBILITY, sizeof(wasm_visibility));
  d->frame.cameras = list_of(d, FVVJS_MOVING, sizeof(fvv_camera));
  d->frame.samples = list_of(d, FVVJS_SAMPLES, sizeof(wasm_sample));
  d->frame.layouts = list_of(d, FVVJS_LAYOUTS, sizeof(wasm_layout));
  d->frame.environments = list_of(d, FVVJS_ENVIRONMENTS, sizeof(wasm_sample));
  d->frame.sounds = list_of(d, FVVJS_SOUNDS, sizeof(wasm_sound));
  return FVV_OK;
}

FVVJS_EXPORT const wasm_frame *fvvjs_frame_data(const fvvjs_decoder *d) {
  return &d->frame;
}
