#include "stream/track_checks.h"

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"

static fvv_status judge_meshes(const fvv_environment *environment, const fvv_limits *limits,
                               const fvv_allocator *allocator, fvv_diagnostic *diagnostic) {
  fvv_status status = FVV_OK;
  for (size_t i = 0; i < environment->part_count && status == FVV_OK; i++) {
    fvv_mesh mesh;
    status = fvv_environment_mesh(environment, i, limits, allocator, &mesh, diagnostic);
    fvv_mesh_free(&mesh);
  }
  return status;
}

static void count_environment(const fvv_environment *environment, fvv_track_summary *counts) {
  counts->parts = (uint32_t)environment->part_count;
  counts->pictures = (uint32_t)environment->picture_count;
  counts->lights = (uint32_t)environment->light_count;
  counts->vertices = counts->faces = 0;
  for (size_t i = 0; i < environment->part_count; i++) {
    const fvv_environment_part *part = &environment->parts[i];
    fvv_mesh_header header;
    if (fvv_mesh_peek(part->mesh, part->mesh_size, NULL, &header, NULL) != FVV_OK) continue;
    counts->vertices += header.vertex_count;
    counts->faces += header.face_count;
  }
}

fvv_status fvv_judge_environment(checked_environment *environment, const fvv_event *event, uint32_t digest,
                                 int decode, const fvv_limits *limits, const fvv_allocator *allocator,
                                 fvv_track_summary *counts, fvv_diagnostic *diagnostic) {
  const fvv_chunk_header *chunk = &event->chunk;
  if (!(chunk->flags & FVV_FLAG_KEY))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_ENVIRONMENT_KEY, FVV_CHUNK_ENVIRONMENT, 0,
                    "the chunk does not have the key flag");
  const int repeats = environment->size && environment->digest == digest;
  const int same = environment->size == chunk->size && environment->crc == chunk->payload_crc;
  if (repeats && same) return FVV_OK;
  fvv_environment decoded;
  fvv_status status =
      fvv_environment_decode(event->payload, (size_t)chunk->size, limits, allocator, &decoded, diagnostic);
  if (status != FVV_OK) return status;
  if (decode) status = judge_meshes(&decoded, limits, allocator, diagnostic);
  if (status == FVV_OK && repeats)
    status =
        fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_ENVIRONMENT_SAME, FVV_CHUNK_ENVIRONMENT, 0,
                 "track %u has another environment than before under the same configuration", chunk->track);
  if (status == FVV_OK) {
    count_environment(&decoded, counts);
    environment->size = chunk->size;
    environment->crc = chunk->payload_crc;
    environment->digest = digest;
  }
  fvv_environment_free(&decoded);
  return status;
}

fvv_status fvv_judge_audio(checked_audio *audio, const fvv_event *event, uint64_t group, int64_t group_end,
                           const fvv_configuration *configuration, fvv_track_summary *counts,
                           fvv_diagnostic *diagnostic) {
  const fvv_audio_config *config = fvv_configuration_audio(configuration, event->chunk.track);
  if (!config || !fvv_audio_codec_known(config->codec)) return FVV_OK;
  if (audio->group != group) {
    memset(audio, 0, sizeof *audio);
    audio->group = group;
  }
  fvv_audio_chunk chunk;
  fvv_status status =
      fvv_audio_decode(config, event->payload, (size_t)event->chunk.size, &chunk, NULL, 0, diagnostic);
  audio->lost |= !event->group_intact || status != FVV_ERROR_BUFFER_TOO_SMALL;
  if (status != FVV_ERROR_BUFFER_TOO_SMALL) return status;
  counts->packets += chunk.packet_count - chunk.preroll_count;
  if (audio->lost) return FVV_OK;
  status = fvv_audio_follow(&audio->place, config, configuration->scene.time_base, &chunk,
                            event->chunk.flags & FVV_FLAG_KEY, event->chunk.time, group_end, diagnostic);
  audio->lost = status < 0;
  return status;
}

void fvv_reset_calibration(checked_calibration *calibration) {
  fvv_calibration_destroy(calibration->cameras);
  calibration->cameras = NULL;
}

/* Where cameras are at a time, by the chunk of the group that came last; NULL: it was of another time, or is
 * not known. */
static const fvv_calibration *calibration_at(const checked_calibration *calibration, uint64_t group,
                                             int64_t time) {
  return calibration->cameras && !calibration->lost && calibration->group == group &&
                 calibration->time == time
             ? calibration->cameras
             : NULL;
}

void fvv_count_calibrations(fvv_track_summary *summary, const fvv_event *event,
                            const fvv_configuration *configuration) {
  if (event->chunk.size < FVV_CALB_SIZE) return;
  const uint8_t *count = event->payload + FVV_CALB_COUNT;
  const uint64_t entries = count[0] | (uint64_t)count[1] << 8;
  uint64_t moving = 0;
  for (size_t i = 0; i < configuration->camera_count; i++)
    moving += (configuration->cameras[i].flags & FVV_CAMERA_MOVES) != 0;
  summary->calibrations += entries;
  summary->lost_calibrations += entries < moving ? moving - entries : 0;
}

fvv_status fvv_judge_calibration(checked_calibration *calibration, const fvv_event *event, uint64_t block,
                                 uint64_t group, const fvv_configuration *configuration,
                                 const fvv_allocator *allocator, int *whole, fvv_diagnostic *diagnostic) {
  if (calibration->block != block || !calibration->cameras) {
    fvv_reset_calibration(calibration);
    const fvv_status created = fvv_calibration_create(configuration->cameras, configuration->camera_count,
                                                      allocator, &calibration->cameras);
    if (created != FVV_OK) return created;
    calibration->block = block;
    calibration->lost = 0;
  }
  if (calibration->group != group) {
    fvv_calibration_reset(calibration->cameras);
    calibration->group = group;
    calibration->lost = 0;
  }
  calibration->time = event->chunk.time;
  const int key = (event->chunk.flags & FVV_FLAG_KEY) != 0;
  /* Errors of the chunks after a wrong one are not reported; after damage it is not known what is missing. */
  if (!key && calibration->lost) {
    *whole = 0;
    return FVV_OK;
  }
  fvv_diagnostic why = {0};
  const fvv_status status =
      fvv_calibration_decode(calibration->cameras, event->payload, (size_t)event->chunk.size, key, &why);
  calibration->lost = status != FVV_OK;
  if (status == FVV_OK) return FVV_OK;
  if (!key && why.issue == FVV_ISSUE_CALIBRATION_NUMBER && !event->group_intact) {
    *whole = 0;
    return FVV_OK;
  }
  *diagnostic = why;
  return status;
}

static void count_tiles(fvv_track_summary *summary, const fvv_bytes *decoded) {
  const fvv_tile *tiles = (const fvv_tile *)decoded->data;
  uint64_t pixels = 0;
  for (size_t i = 0; i < decoded->size / sizeof *tiles; i++)
    pixels += (uint64_t)tiles[i].destination.width * tiles[i].destination.height;
  if (!summary->layouts || pixels < summary->least_tile_pixels) summary->least_tile_pixels = pixels;
  if (pixels > summary->most_tile_pixels) summary->most_tile_pixels = pixels;
  summary->layouts++;
}

fvv_status fvv_judge_group_tiles(checked_tiles *checked, const fvv_event *event, uint64_t group,
                                 const fvv_configuration *configuration, const fvv_limits *limits,
                                 const fvv_allocator *allocator, fvv_track_summary *summary,
                                 fvv_diagnostic *diagnostic) {
  fvv_bytes tiles = {NULL, 0, 0, *allocator};
  const fvv_status status = fvv_group_tiles_decode(configuration, event->chunk.track, event->payload,
                                                   (size_t)event->chunk.size, limits, &tiles, diagnostic);
  if (status == FVV_OK)
    count_tiles(summary, &tiles);
  else
    checked->lost_in = group;
  fvv_bytes_free(&tiles);
  return status;
}

/* Where the beginning of a group was lost, there is no first mesh to compare with. */
static fvv_status compare_attributes(checked_mesh *mesh, const fvv_event *event,
                                     const fvv_mesh_header *header, fvv_diagnostic *diagnostic) {
  if (!event->group_intact) return FVV_OK;
  if (!mesh->has_first) {
    mesh->has_first = 1;
    mesh->texture_bits = header->texture_bits;
    mesh->normal_bits = header->normal_bits;
  }
  if (mesh->texture_bits != header->texture_bits)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_TEXTURE_GROUP, FVV_CHUNK_MESH,
                    FVV_MESH_TEXTURE_BITS,
                    "%u texture bits, the first mesh of the track in this group has %u", header->texture_bits,
                    mesh->texture_bits);
  if (mesh->normal_bits == header->normal_bits) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_NORMAL_GROUP, FVV_CHUNK_MESH,
                  FVV_MESH_NORMAL_BITS, "%u normal bits, the first mesh of the track in this group has %u",
                  header->normal_bits, mesh->normal_bits);
}

static fvv_status judge_mesh(checked_mesh *mesh, const fvv_event *event, const fvv_limits *limits,
                             const fvv_allocator *allocator, int *whole, fvv_diagnostic *diagnostic) {
  const int key = (event->chunk.flags & FVV_FLAG_KEY) != 0;
  /* After damage it is not known what is missing; a delta frame that cannot be decoded is no further
   * problem. */
  const int has_key = fvv_mesh_frames_current(&mesh->frames) != NULL;
  if (!key && (mesh->lost || (!has_key && !event->group_intact))) {
    *whole = 0;
    return FVV_OK;
  }
  fvv_diagnostic why = {0};
  const fvv_status status = fvv_mesh_frames_add(&mesh->frames, event->payload, (size_t)event->chunk.size, key,
                                                limits, allocator, &why);
  mesh->lost = status != FVV_OK;
  mesh->time = event->chunk.time;
  if (status == FVV_OK) return FVV_OK;
  if (why.issue == FVV_ISSUE_DELTA_NUMBER && !event->group_intact) {
    *whole = 0;
    return FVV_OK;
  }
  *diagnostic = why;
  return status;
}

fvv_status fvv_judge_mesh_chunk(checked_mesh *mesh, const fvv_event *event, uint64_t group, int decode,
                                const fvv_limits *limits, const fvv_allocator *allocator,
                                fvv_mesh_header *header, int *whole, fvv_diagnostic *diagnostic) {
  if (mesh->group != group) {
    fvv_mesh_frames_reset(&mesh->frames);
    mesh->group = group;
    mesh->has_first = mesh->lost = 0;
  }
  fvv_status status = fvv_mesh_peek(event->payload, (size_t)event->chunk.size, limits, header, diagnostic);
  if (status == FVV_OK) status = compare_attributes(mesh, event, header, diagnostic);
  if (status == FVV_OK)
    status = fvv_mesh_frames_check_flag(header, event->chunk.flags & FVV_FLAG_KEY, diagnostic);
  if (status == FVV_OK && decode) return judge_mesh(mesh, event, limits, allocator, whole, diagnostic);
  if (status != FVV_OK) mesh->lost = 1;
  return status;
}

/* A chunk that is no key follows one that was not decoded: only its number and key flag can be checked. */
static fvv_status judge_structure(const fvv_event *event, const fvv_configuration *configuration,
                                  const fvv_limits *limits, fvv_diagnostic *diagnostic) {
  const int key = (event->chunk.flags & FVV_FLAG_KEY) != 0;
  fvv_visibility_header header;
  fvv_visibility_frames before = {0};
  const size_t size = (size_t)event->chunk.size;
  const fvv_status status = fvv_visibility_peek(event->payload, size, limits, &header, NULL, 0, diagnostic);
  if (status != FVV_OK) return status;
  before.current.header = header;
  before.current.header.number = header.number - 1;
  return fvv_visibility_frames_check(&before, event->payload, size, key, configuration, limits, &header,
                                     diagnostic);
}

static int any_moves(const fvv_configuration *configuration) {
  for (size_t i = 0; i < configuration->camera_count; i++)
    if (configuration->cameras[i].flags & FVV_CAMERA_MOVES) return 1;
  return 0;
}

fvv_status fvv_judge_visibility_chunk(checked_visibility *visibility, const fvv_event *event, uint64_t group,
                                      int decode, const checked_mesh *mesh,
                                      const checked_calibration *calibration,
                                      const fvv_configuration *configuration, const fvv_limits *limits,
                                      const fvv_allocator *allocator, int *whole,
                                      fvv_diagnostic *diagnostic) {
  const int key = (event->chunk.flags & FVV_FLAG_KEY) != 0;
  const size_t size = (size_t)event->chunk.size;
  if (visibility->group != group) {
    fvv_visibility_frames_reset(&visibility->frames);
    visibility->group = group;
    visibility->lost = 0;
  }
  if (!decode) return judge_structure(event, configuration, limits, diagnostic);
  const fvv_mesh *current =
      mesh && !mesh->lost && mesh->time == event->chunk.time ? fvv_mesh_frames_current(&mesh->frames) : NULL;
  const fvv_calibration *placed = calibration ? calibration_at(calibration, group, event->chunk.time) : NULL;
  const int placed_unknown = calibration && calibration->group == group && calibration->lost;
  /* After damage it is not known what is missing; a wrong mesh or calibration has been reported. */
  const int unknown = (!current && ((mesh && mesh->lost) || !event->group_intact)) ||
                      (!placed && any_moves(configuration) && (placed_unknown || !event->group_intact)) ||
                      (!key && (visibility->lost || !event->group_intact));
  if (unknown) {
    visibility->lost = 1;
    *whole = 0;
    return judge_structure(event, configuration, limits, diagnostic);
  }
  const fvv_status status = fvv_visibility_frames_add(&visibility->frames, event->payload, size, key, current,
                                                      placed, configuration, limits, allocator, diagnostic);
  visibility->lost = status != FVV_OK;
  return status;
}

fvv_status fvv_judge_colours_chunk(const fvv_event *event, uint64_t group, int decode,
                                   const checked_mesh *mesh, const fvv_configuration *configuration,
                                   const fvv_limits *limits, const fvv_allocator *allocator, int *whole,
                                   fvv_diagnostic *diagnostic) {
  const int key = (event->chunk.flags & FVV_FLAG_KEY) != 0;
  const size_t size = (size_t)event->chunk.size;
  fvv_colours_header header;
  const int here = mesh && mesh->group == group;
  const int current = here && !mesh->lost && mesh->time == event->chunk.time;
  const int unknown = !current && ((here && mesh->lost) || !event->group_intact);
  if (unknown) *whole = 0;
  if (unknown || !decode)
    return fvv_colours_check(event->payload, size, key, configuration, limits, &header, diagnostic);
  fvv_bytes colours = {NULL, 0, 0, *allocator};
  const fvv_status status =
      fvv_colours_add(event->payload, size, key, current ? fvv_mesh_frames_new(&mesh->frames) : NULL,
                      configuration, limits, &colours, diagnostic);
  fvv_bytes_free(&colours);
  return status;
}
