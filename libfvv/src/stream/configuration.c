#include "stream/configuration.h"

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "base/text.h"
#include "container/header.h"

typedef struct payload_copy {
  void *data;
  size_t size;
} payload_copy;

typedef struct tile_layout {
  uint16_t track;
  fvv_tile *tiles;
  size_t count;
  uint64_t offset; /* of its payload in the stream */
} tile_layout;

#define COUNT(bytes, type) ((bytes).size / sizeof(type))

void fvv_configuration_init(fvv_configuration_builder *builder, const fvv_limits *limits,
                            const fvv_allocator *allocator) {
  memset(builder, 0, sizeof *builder);
  builder->allocator = fvv_allocator_or_default(allocator);
  builder->limits = fvv_limits_or_default(limits);
  fvv_bytes *const all[] = {&builder->tracks,  &builder->cameras, &builder->videos,
                            &builder->sounds,  &builder->datas,   &builder->metadata,
                            &builder->layouts, &builder->stopped, &builder->copies};
  for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) all[i]->allocator = builder->allocator;
}

static void clear(fvv_configuration_builder *b) {
  const payload_copy *copies = (const payload_copy *)b->copies.data;
  for (size_t i = 0; i < COUNT(b->copies, payload_copy); i++)
    fvv_release(&b->allocator, copies[i].data, copies[i].size);
  memset(&b->view, 0, sizeof b->view);
  b->tracks.size = b->cameras.size = b->videos.size = b->sounds.size = b->datas.size = 0;
  b->metadata.size = b->layouts.size = b->stopped.size = b->copies.size = 0;
  b->textured = b->has_more = 0;
}

void fvv_configuration_free(fvv_configuration_builder *builder) {
  clear(builder);
  fvv_bytes *const all[] = {&builder->tracks,  &builder->cameras, &builder->videos,
                            &builder->sounds,  &builder->datas,   &builder->metadata,
                            &builder->layouts, &builder->stopped, &builder->copies};
  for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) fvv_bytes_free(all[i]);
}

/* Memory that lives as long as the block. */
static void *keep(fvv_configuration_builder *b, size_t size) {
  payload_copy copy = {fvv_allocate(&b->allocator, size ? size : 1), size ? size : 1};
  if (!copy.data) return NULL;
  if (fvv_bytes_append(&b->copies, &copy, sizeof copy) < 0) {
    fvv_release(&b->allocator, copy.data, copy.size);
    return NULL;
  }
  return copy.data;
}

static fvv_status add_camera(fvv_configuration_builder *b, const uint8_t *payload, size_t size,
                             fvv_diagnostic *diagnostic) {
  fvv_camera camera;
  const fvv_status status = fvv_camera_decode(&camera, payload, size, &b->limits, diagnostic);
  if (status < 0) return status;
  if (COUNT(b->cameras, fvv_camera) >= b->limits.max_cameras)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_CAMERA, 0, "more than %u cameras",
                    b->limits.max_cameras);
  const fvv_camera *cameras = (const fvv_camera *)b->cameras.data;
  for (size_t i = 0; i < COUNT(b->cameras, fvv_camera); i++)
    if (cameras[i].id == camera.id)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CONFIGURATION_CAMERA, FVV_CHUNK_CAMERA,
                      FVV_CAMR_ID, "camera %u is described twice", camera.id);
  return fvv_bytes_append(&b->cameras, &camera, sizeof camera);
}

static int is_track(const fvv_configuration_builder *b, uint16_t track, uint8_t kind) {
  const fvv_track *tracks = (const fvv_track *)b->tracks.data;
  for (size_t i = 0; i < COUNT(b->tracks, fvv_track); i++)
    if (tracks[i].id == track && tracks[i].kind == kind) return 1;
  return 0;
}

static int is_stopped(const fvv_configuration_builder *b, uint16_t track) {
  const uint16_t *ids = (const uint16_t *)b->stopped.data;
  for (size_t i = 0; i < COUNT(b->stopped, uint16_t); i++)
    if (ids[i] == track) return 1;
  return 0;
}

/* Returns failure, which says why the track is left out. */
static fvv_status stop(fvv_configuration_builder *b, uint16_t track, fvv_status failure) {
  const fvv_status status = fvv_bytes_append(&b->stopped, &track, sizeof track);
  return status < 0 ? status : failure;
}

static fvv_status check_video_track(const fvv_configuration_builder *b, uint16_t track, uint32_t type,
                                    fvv_diagnostic *diagnostic) {
  if (is_track(b, track, FVV_TRACK_VIDEO)) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CONFIGURATION_TRACK, type, 0,
                  "track %u is not declared as a video track", track);
}

static fvv_status add_video(fvv_configuration_builder *b, uint16_t track, const uint8_t *payload, size_t size,
                            fvv_diagnostic *diagnostic) {
  fvv_status status = check_video_track(b, track, FVV_CHUNK_VIDEO_CONFIG, diagnostic);
  if (status < 0) return status;
  const fvv_video_layout *videos = (const fvv_video_layout *)b->videos.data;
  int again = is_stopped(b, track);
  for (size_t i = 0; i < COUNT(b->videos, fvv_video_layout); i++) again |= videos[i].track == track;
  if (again)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CONFIGURATION_TRACK, FVV_CHUNK_VIDEO_CONFIG, 0,
                    "track %u has a second VCFG", track);
  fvv_video_layout video;
  memset(&video, 0, sizeof video);
  video.track = track;
  status = fvv_video_config_decode(&video.config, payload, size, &b->limits, diagnostic);
  if (status == FVV_ERROR_UNSUPPORTED) return stop(b, track, status);
  return status < 0 ? status : fvv_bytes_append(&b->videos, &video, sizeof video);
}

static fvv_status add_tiles(fvv_configuration_builder *b, uint16_t track, const uint8_t *payload, size_t size,
                            fvv_diagnostic *diagnostic) {
  fvv_status status = check_video_track(b, track, FVV_CHUNK_TILES, diagnostic);
  if (status < 0) return status;
  const tile_layout *layouts = (const tile_layout *)b->layouts.data;
  for (size_t i = 0; i < COUNT(b->layouts, tile_layout); i++)
    if (layouts[i].track == track)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CONFIGURATION_TRACK, FVV_CHUNK_TILES, 0,
                      "track %u has a second TILE", track);
  /* No more tiles than the payload has bytes for. */
  const size_t most = size / FVV_TILE_ENTRY_SIZE;
  tile_layout layout = {track, keep(b, most * sizeof(fvv_tile)), 0, 0};
  if (!layout.tiles) return FVV_ERROR_MEMORY;
  status = fvv_tiles_decode(layout.tiles, most, &layout.count, payload, size, &b->limits, diagnostic);
  return status < 0 ? status : fvv_bytes_append(&b->layouts, &layout, sizeof layout);
}

/* A tick of an audio track is a sample. */
static fvv_status check_time_base(const fvv_configuration_builder *b, const fvv_audio_layout *sound,
                                  fvv_diagnostic *diagnostic) {
  const fvv_track *tracks = (const fvv_track *)b->tracks.data;
  const uint32_t rate = fvv_audio_sample_rate(&sound->config);
  for (size_t i = 0; i < COUNT(b->tracks, fvv_track); i++) {
    const fvv_rational base = tracks[i].time_base;
    if (tracks[i].id == sound->track && (base.numerator != 1 || base.denominator != rate))
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_AUDIO_RECORD, FVV_CHUNK_AUDIO_CONFIG,
                      FVV_ACFG_SIZE, "time base of audio track %u is %u/%u, expected 1/%u", sound->track,
                      base.numerator, base.denominator, rate);
  }
  return FVV_OK;
}

static fvv_status add_audio(fvv_configuration_builder *b, uint16_t track, const uint8_t *payload, size_t size,
                            fvv_diagnostic *diagnostic) {
  const fvv_audio_layout *sounds = (const fvv_audio_layout *)b->sounds.data;
  int again = is_stopped(b, track);
  for (size_t i = 0; i < COUNT(b->sounds, fvv_audio_layout); i++) again |= sounds[i].track == track;
  if (again || !is_track(b, track, FVV_TRACK_AUDIO))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CONFIGURATION_AUDIO, FVV_CHUNK_AUDIO_CONFIG, 0,
                    again ? "track %u has a second ACFG" : "track %u is not declared as an audio track",
                    track);
  fvv_audio_layout sound;
  memset(&sound, 0, sizeof sound);
  sound.track = track;
  fvv_status status = fvv_audio_config_decode(&sound.config, payload, size, &b->limits, diagnostic);
  /* The rest of the stream can be shown without the sound. */
  const int known = status == FVV_OK;
  if (status == FVV_ERROR_UNSUPPORTED) status = FVV_OK;
  if (known) status = check_time_base(b, &sound, diagnostic);
  return status < 0 ? stop(b, track, status) : fvv_bytes_append(&b->sounds, &sound, sizeof sound);
}

static fvv_status add_data(fvv_configuration_builder *b, uint16_t track, const uint8_t *payload, size_t size,
                           fvv_diagnostic *diagnostic) {
  const fvv_data_layout *datas = (const fvv_data_layout *)b->datas.data;
  int again = is_stopped(b, track);
  for (size_t i = 0; i < COUNT(b->datas, fvv_data_layout); i++) again |= datas[i].track == track;
  if (again || !is_track(b, track, FVV_TRACK_DATA))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CONFIGURATION_DATA, FVV_CHUNK_DATA_CONFIG, 0,
                    again ? "track %u has a second DCFG" : "track %u is not declared as a data track", track);
  fvv_data_layout data;
  memset(&data, 0, sizeof data);
  data.track = track;
  const fvv_status status = fvv_data_config_decode(&data.config, payload, size, &b->limits, diagnostic);
  return status < 0 ? stop(b, track, status) : fvv_bytes_append(&b->datas, &data, sizeof data);
}

static fvv_status add_metadata(fvv_configuration_builder *b, const uint8_t *payload, size_t size,
                               fvv_diagnostic *diagnostic) {
  if (size > b->limits.max_text)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_METADATA, 0,
                    "metadata of %zu bytes, limit %u", size, b->limits.max_text);
  const fvv_text text = {(const char *)payload, size};
  const fvv_status status =
      fvv_text_check(text.text, text.size, "metadata", FVV_ERROR_INVALID, FVV_CHUNK_METADATA, 0, diagnostic);
  if (status != FVV_OK) return status;
  return fvv_bytes_append(&b->metadata, &text, sizeof text);
}

static fvv_status add_texturing(fvv_configuration_builder *b, const uint8_t *payload, size_t size,
                                fvv_diagnostic *diagnostic) {
  if (b->textured)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TEXTURING_PAYLOAD, FVV_CHUNK_TEXTURING, 0,
                    "the block has a second TEXR");
  b->textured = 1;
  const fvv_status status = fvv_texturing_decode(&b->view.texturing, payload, size, diagnostic);
  b->view.has_texturing = status == FVV_OK;
  return status;
}

/* Where a block is read alone, nothing else compares its tracks. */
static fvv_status add_track(fvv_configuration_builder *b, const fvv_chunk_header *header,
                            const uint8_t *payload, fvv_diagnostic *diagnostic) {
  fvv_track track;
  const fvv_status status = fvv_track_decode(&track, payload, (size_t)header->size, &b->limits, diagnostic);
  if (status < 0) return status;
  const fvv_track *tracks = (const fvv_track *)b->tracks.data;
  for (size_t i = 0; i < COUNT(b->tracks, fvv_track); i++)
    if (tracks[i].id == header->track)
      return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TRACK_ID, FVV_CHUNK_TRACK, 0,
                      "track %u is declared twice", header->track);
  if (COUNT(b->tracks, fvv_track) >= b->limits.max_tracks)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_TRACK, 0, "more than %u tracks",
                    b->limits.max_tracks);
  if (b->has_more)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CHUNK_PLACE, FVV_CHUNK_TRACK, 0,
                    "track %u is declared after other chunks than SCEN", header->track);
  track.id = header->track;
  return fvv_bytes_append(&b->tracks, &track, sizeof track);
}

static fvv_status add_chunk(fvv_configuration_builder *b, const fvv_chunk_header *header,
                            const uint8_t *payload, fvv_diagnostic *diagnostic) {
  const size_t size = (size_t)header->size;
  b->has_more |= header->type != FVV_CHUNK_SCENE && header->type != FVV_CHUNK_TRACK &&
                 fvv_chunk_place(header->type, header->flags) != FVV_PLACE_UNKNOWN;
  switch (header->type) {
  case FVV_CHUNK_SCENE:
    return fvv_scene_decode(&b->view.scene, payload, size, diagnostic);
  case FVV_CHUNK_TRACK:
    return add_track(b, header, payload, diagnostic);
  case FVV_CHUNK_CAMERA:
    return add_camera(b, payload, size, diagnostic);
  case FVV_CHUNK_VIDEO_CONFIG:
    return add_video(b, header->track, payload, size, diagnostic);
  case FVV_CHUNK_TILES:
    return add_tiles(b, header->track, payload, size, diagnostic);
  case FVV_CHUNK_TEXTURING:
    return add_texturing(b, payload, size, diagnostic);
  case FVV_CHUNK_AUDIO_CONFIG:
    return add_audio(b, header->track, payload, size, diagnostic);
  case FVV_CHUNK_DATA_CONFIG:
    return add_data(b, header->track, payload, size, diagnostic);
  case FVV_CHUNK_METADATA:
    return add_metadata(b, payload, size, diagnostic);
  default:
    return FVV_OK;
  }
}

fvv_status fvv_configuration_add(fvv_configuration_builder *builder, const fvv_chunk_header *header,
                                 const uint8_t *payload, uint64_t offset, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (header->type == FVV_CHUNK_SCENE) clear(builder);
  uint8_t *copy = keep(builder, (size_t)header->size);
  if (!copy) return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, header->type, offset, "out of memory");
  if (header->size) memcpy(copy, payload, (size_t)header->size);
  const fvv_status status = add_chunk(builder, header, copy, diagnostic);
  if (status >= 0 && header->type == FVV_CHUNK_TILES)
    ((tile_layout *)(builder->layouts.data + builder->layouts.size) - 1)->offset =
        offset + FVV_CHUNK_HEADER_SIZE;
  if (status < 0) {
    fvv_fail(diagnostic, status, 0, header->type, 0, "%s", fvv_status_text(status));
    fvv_diagnostic_rebase(diagnostic, offset + FVV_CHUNK_HEADER_SIZE, header->type);
  }
  return status;
}

int fvv_configuration_survives(const fvv_chunk_header *header, fvv_status status) {
  if (status >= 0 || status == FVV_ERROR_MEMORY) return 0;
  return !(header->flags & FVV_FLAG_CRITICAL) ||
         (header->type == FVV_CHUNK_VIDEO_CONFIG && status == FVV_ERROR_UNSUPPORTED);
}

#define WRONG(issue, type, ...)                                                                              \
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_##issue, type, offset, __VA_ARGS__)

fvv_status fvv_configuration_check_tiles(const fvv_configuration *configuration,
                                         const fvv_video_layout *video, const fvv_tile *tiles, size_t count,
                                         fvv_diagnostic *diagnostic) {
  for (size_t i = 0; i < count; i++) {
    const uint64_t offset = FVV_TILE_SIZE + i * FVV_TILE_ENTRY_SIZE;
    const fvv_tile *tile = &tiles[i];
    const fvv_camera *camera = fvv_configuration_camera(configuration, tile->camera_id);
    if (!camera)
      WRONG(CONFIGURATION_CAMERA, FVV_CHUNK_TILES,
            "tile %zu of track %u shows camera %u, which is not described", i, video->track, tile->camera_id);
  }
  for (size_t i = 0; i < count; i++) {
    const uint64_t offset = FVV_TILE_SIZE + i * FVV_TILE_ENTRY_SIZE;
    const fvv_tile *tile = &tiles[i];
    const fvv_camera *camera = fvv_configuration_camera(configuration, tile->camera_id);
    if ((uint32_t)tile->source.x + tile->source.width > camera->width ||
        (uint32_t)tile->source.y + tile->source.height > camera->height)
      WRONG(TILE_RECT, FVV_CHUNK_TILES,
            "tile %zu of track %u exceeds the picture of camera %u of %ux%u pixels", i, video->track,
            camera->id, camera->width, camera->height);
  }
  return fvv_tiles_validate(tiles, count, video->config.width, video->config.height, diagnostic);
}

static const tile_layout *layout_of(const fvv_configuration_builder *b, uint16_t track) {
  const tile_layout *layouts = (const tile_layout *)b->layouts.data;
  for (size_t i = 0; i < COUNT(b->layouts, tile_layout); i++)
    if (layouts[i].track == track) return &layouts[i];
  return NULL;
}

static fvv_status complete_video(const fvv_configuration_builder *b, fvv_video_layout *video, uint64_t offset,
                                 fvv_diagnostic *diagnostic) {
  const tile_layout *layout = layout_of(b, video->track);
  if (layout) {
    video->tiles = layout->tiles;
    video->tile_count = layout->count;
  }
  if ((video->config.shows == FVV_SHOWS_TILES) != (video->tile_count > 0))
    WRONG(CONFIGURATION_VIDEO, FVV_CHUNK_VIDEO_CONFIG, "track %u %s", video->track,
          video->tile_count ? "has a TILE but does not show tiles" : "shows tiles but has no TILE");
  return FVV_OK;
}

static fvv_status check_layout(const fvv_configuration_builder *b, const fvv_video_layout *video,
                               fvv_diagnostic *diagnostic) {
  const tile_layout *layout = layout_of(b, video->track);
  if (!layout) return FVV_OK;
  const fvv_status status =
      fvv_configuration_check_tiles(&b->view, video, layout->tiles, layout->count, diagnostic);
  if (status < 0) fvv_diagnostic_rebase(diagnostic, layout->offset, FVV_CHUNK_TILES);
  return status;
}

/* Alternatives are of one kind and ranked from 0. */
static fvv_status check_alternates(const fvv_configuration *view, uint64_t offset,
                                   fvv_diagnostic *diagnostic) {
  for (size_t i = 0; i < view->track_count; i++) {
    for (size_t k = 0; k < i && view->tracks[i].alternate_group; k++) {
      const fvv_track *a = &view->tracks[k], *b = &view->tracks[i];
      if (a->alternate_group != b->alternate_group) continue;
      if (a->kind != b->kind || a->rank == b->rank)
        WRONG(TRACK_ALTERNATE, FVV_CHUNK_TRACK,
              "tracks %u and %u of alternate group %u have kinds %u and %u and ranks %u and %u, expected one "
              "kind and different ranks",
              a->id, b->id, b->alternate_group, a->kind, b->kind, a->rank, b->rank);
    }
  }
  for (size_t i = 0; i < view->track_count; i++) {
    const uint16_t group = view->tracks[i].alternate_group;
    int best = !group;
    for (size_t k = 0; k < view->track_count; k++)
      best |= view->tracks[k].alternate_group == group && !view->tracks[k].rank;
    if (!best)
      WRONG(TRACK_ALTERNATE, FVV_CHUNK_TRACK, "alternate group %u has no track of rank 0, expected one",
            group);
  }
  return FVV_OK;
}

fvv_status fvv_configuration_check_silent(const fvv_configuration_builder *builder, uint64_t offset,
                                          fvv_diagnostic *diagnostic) {
  const fvv_configuration *view = &builder->view;
  fvv_diagnostic_clear(diagnostic);
  for (size_t i = 0; i < view->track_count; i++)
    if (view->tracks[i].kind == FVV_TRACK_AUDIO && !fvv_configuration_audio(view, view->tracks[i].id) &&
        !is_stopped(builder, view->tracks[i].id))
      WRONG(CONFIGURATION_AUDIO, FVV_CHUNK_TRACK, "audio track %u has no ACFG", view->tracks[i].id);
  for (size_t i = 0; i < view->track_count; i++)
    if (view->tracks[i].kind == FVV_TRACK_DATA && !fvv_configuration_data(view, view->tracks[i].id) &&
        !is_stopped(builder, view->tracks[i].id))
      WRONG(CONFIGURATION_DATA, FVV_CHUNK_TRACK, "data track %u has no DCFG", view->tracks[i].id);
  return FVV_OK;
}

fvv_status fvv_configuration_complete(fvv_configuration_builder *builder, uint64_t offset,
                                      fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_configuration *view = &builder->view;
  view->tracks = (const fvv_track *)builder->tracks.data;
  view->track_count = COUNT(builder->tracks, fvv_track);
  view->cameras = (const fvv_camera *)builder->cameras.data;
  view->camera_count = COUNT(builder->cameras, fvv_camera);
  view->videos = (const fvv_video_layout *)builder->videos.data;
  view->video_count = COUNT(builder->videos, fvv_video_layout);
  view->sounds = (const fvv_audio_layout *)builder->sounds.data;
  view->sound_count = COUNT(builder->sounds, fvv_audio_layout);
  view->datas = (const fvv_data_layout *)builder->datas.data;
  view->data_count = COUNT(builder->datas, fvv_data_layout);
  view->metadata = (const fvv_text *)builder->metadata.data;
  view->metadata_count = COUNT(builder->metadata, fvv_text);
  if (!view->has_texturing) fvv_texturing_default(&view->texturing);
  fvv_video_layout *videos = (fvv_video_layout *)builder->videos.data;
  fvv_status status = check_alternates(view, offset, diagnostic);
  if (status < 0) return status;
  for (size_t i = 0; i < view->track_count; i++)
    if (view->tracks[i].kind == FVV_TRACK_VIDEO && !fvv_configuration_video(view, view->tracks[i].id) &&
        !is_stopped(builder, view->tracks[i].id))
      WRONG(CONFIGURATION_VIDEO, FVV_CHUNK_TRACK, "video track %u has no VCFG", view->tracks[i].id);
  for (size_t i = 0; i < view->video_count && status == FVV_OK; i++)
    status = complete_video(builder, &videos[i], offset, diagnostic);
  if (status < 0) return status;
  size_t tracks = 0, moving = 0;
  for (size_t i = 0; i < view->track_count; i++) tracks += view->tracks[i].kind == FVV_TRACK_CALIBRATION;
  for (size_t i = 0; i < view->camera_count; i++) moving += (view->cameras[i].flags & FVV_CAMERA_MOVES) != 0;
  if (tracks != (moving > 0))
    WRONG(CONFIGURATION_CALIBRATION, FVV_CHUNK_CAMERA, "%zu calibration tracks for %zu cameras that move",
          tracks, moving);
  for (size_t i = 0; i < view->video_count && status == FVV_OK; i++)
    status = check_layout(builder, &videos[i], diagnostic);
  return status;
}

const fvv_track *fvv_configuration_track(const fvv_configuration *configuration, uint16_t id) {
  for (size_t i = 0; i < configuration->track_count; i++)
    if (configuration->tracks[i].id == id) return &configuration->tracks[i];
  return NULL;
}

int fvv_configuration_makes_frame(const fvv_configuration *configuration, uint32_t type, uint16_t id) {
  const fvv_track *track = configuration && id ? fvv_configuration_track(configuration, id) : NULL;
  return fvv_makes_frame(type, track ? track->kind : 0, track ? track->flags : 0);
}

const fvv_camera *fvv_configuration_camera(const fvv_configuration *configuration, uint16_t id) {
  for (size_t i = 0; i < configuration->camera_count; i++)
    if (configuration->cameras[i].id == id) return &configuration->cameras[i];
  return NULL;
}

const fvv_video_layout *fvv_configuration_video(const fvv_configuration *configuration, uint16_t track) {
  for (size_t i = 0; i < configuration->video_count; i++)
    if (configuration->videos[i].track == track) return &configuration->videos[i];
  return NULL;
}

const fvv_audio_config *fvv_configuration_audio(const fvv_configuration *configuration, uint16_t track) {
  for (size_t i = 0; i < configuration->sound_count; i++)
    if (configuration->sounds[i].track == track) return &configuration->sounds[i].config;
  return NULL;
}

const fvv_data_config *fvv_configuration_data(const fvv_configuration *configuration, uint16_t track) {
  for (size_t i = 0; i < configuration->data_count; i++)
    if (configuration->datas[i].track == track) return &configuration->datas[i].config;
  return NULL;
}
