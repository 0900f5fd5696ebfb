/* The checker: pulls every event of a stream, checks each chunk against those before it, and counts. */
#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "container/header.h"
#include "fvv/stream.h"
#include "stream/frames.h"
#include "stream/tracks.h"

/* Zero-initialise. */
typedef struct checked_environment {
  uint64_t size; /* of the last intact chunk; 0: none */
  uint32_t crc, digest;
} checked_environment;

/* Zero-initialise; reset in the end. */
typedef struct checked_calibration {
  uint64_t block, group;    /* that are being read, both counted from 1 */
  int64_t time;             /* of the last chunk */
  int lost;                 /* a chunk of the group was wrong: those up to the next key cannot be checked */
  fvv_calibration *cameras; /* of the block */
} checked_calibration;

/* Zero-initialise; reset frames in the end. */
typedef struct checked_mesh {
  uint64_t group; /* that is being read, counted from 1 */
  int has_first;  /* the first mesh of the group was seen: texture_bits and normal_bits are its own */
  uint8_t texture_bits, normal_bits;
  int64_t time; /* of the mesh that frames holds */
  int lost;     /* a frame of the group was wrong: delta frames after it cannot be checked */
  fvv_mesh_frames frames;
} checked_mesh;

/* Zero-initialise; reset frames in the end. */
typedef struct checked_visibility {
  uint64_t group; /* that is being read, counted from 1 */
  int lost;       /* a chunk of the group was wrong or could not be checked: those after it cannot be */
  fvv_visibility_frames frames;
} checked_visibility;

/* Zero-initialise. */
typedef struct checked_audio {
  uint64_t group; /* that is being read, counted from 1 */
  int lost;       /* something of the group is missing or wrong: times cannot be compared */
  fvv_audio_place place;
} checked_audio;

/* What the checker knows of the layouts of a track. Zero-initialise. */
typedef struct checked_tiles {
  uint64_t lost_in; /* the group, counted from 1, whose layout is wrong: its samples cannot be used */
} checked_tiles;

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

/* Checks an intact BACK chunk; with decode, its meshes too. digest: of the configuration, from GRUP. *counts
 * gets what it holds. Offsets of diagnostics are relative to the payload. */
static fvv_status judge_environment(checked_environment *environment, const fvv_event *event, uint32_t digest,
                                    int decode, const fvv_limits *limits, const fvv_allocator *allocator,
                                    fvv_track_summary *counts, fvv_diagnostic *diagnostic) {
  const fvv_chunk_header *chunk = &event->chunk;
  if (!(chunk->flags & FVV_FLAG_KEY))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_ENVIRONMENT_KEY, FVV_CHUNK_ENVIRONMENT, 0,
                    "the chunk does not have the key flag");
  const int repeats = environment->size && environment->digest == digest;
  const int same = environment->size == chunk->size && environment->crc == chunk->payload_crc;
  if (repeats && same) return FVV_OK;
  environment->size = chunk->size;
  environment->crc = chunk->payload_crc;
  environment->digest = digest;
  if (repeats)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_ENVIRONMENT_SAME, FVV_CHUNK_ENVIRONMENT, 0,
                    "track %u has another environment than before under the same configuration",
                    chunk->track);
  fvv_environment decoded;
  fvv_status status =
      fvv_environment_decode(event->payload, (size_t)chunk->size, limits, allocator, &decoded, diagnostic);
  if (status != FVV_OK) return status;
  count_environment(&decoded, counts);
  if (decode) status = judge_meshes(&decoded, limits, allocator, diagnostic);
  fvv_environment_free(&decoded);
  return status;
}

/* Checks an intact AUDI chunk. Offsets of diagnostics are relative to the payload. */
static fvv_status judge_audio(checked_audio *audio, const fvv_event *event, uint64_t group, int64_t group_end,
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
  status = fvv_audio_follow(&audio->place, config, configuration->scene.time_base, &chunk, event->chunk.time,
                            group_end, diagnostic);
  audio->lost = status < 0;
  return status;
}

static void reset_calibration(checked_calibration *calibration) {
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

/* Adds what an intact CALB chunk declares. */
static void count_calibrations(fvv_track_summary *summary, const fvv_event *event,
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

/* Checks an intact CALB chunk. *whole becomes 0 when one before it is missing, which is no problem of its
 * own. Offsets of diagnostics are relative to the payload. */
static fvv_status judge_calibration(checked_calibration *calibration, const fvv_event *event, uint64_t block,
                                    uint64_t group, const fvv_configuration *configuration,
                                    const fvv_allocator *allocator, int *whole, fvv_diagnostic *diagnostic) {
  if (calibration->block != block || !calibration->cameras) {
    reset_calibration(calibration);
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

/* Checks the intact TILE of a group, and counts it in summary. */
static fvv_status judge_group_tiles(checked_tiles *checked, const fvv_event *event, uint64_t group,
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

/* Checks an intact MESH chunk; with decode, its content too. header is filled as far as it is good. *whole
 * becomes 0 when a frame before this one is missing, which is no problem of its own. Offsets of diagnostics
 * are relative to the payload. */
static fvv_status judge_mesh_chunk(checked_mesh *mesh, const fvv_event *event, uint64_t group, int decode,
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

/* Checks an intact VISI chunk; with decode, its content too. mesh: what is known in this group of the mesh
 * track that it names, NULL: nothing. calibration: of the track of cameras that move, NULL: there was none.
 * *whole becomes 0 when something before this chunk is missing, which is no problem of its own. Offsets of
 * diagnostics are relative to the payload. */
static fvv_status judge_visibility_chunk(checked_visibility *visibility, const fvv_event *event,
                                         uint64_t group, int decode, const checked_mesh *mesh,
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

/* Checks an intact COLR chunk; with decode, its content too. mesh: what is known in this group of the mesh
 * track that it names, NULL: nothing. *whole and offsets: as above. */
static fvv_status judge_colours_chunk(const fvv_event *event, uint64_t group, int decode,
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

/* Reads a whole stream and checks it: the push reader its structure, the layers of tracks its content. */

enum { KEPT_PROBLEMS = 1000 };

typedef struct checked_track {
  fvv_track_summary summary;
  checked_mesh mesh;
  checked_calibration calibration;
  checked_visibility visibility;
  checked_tiles tiles;
  checked_audio audio;
  checked_environment environment;
} checked_track;

struct fvv_checker {
  fvv_allocator allocator;
  fvv_limits limits;
  fvv_check_options options;
  fvv_frames *frames;
  int reads_again;                        /* finish found groups that a second reading gives */
  const fvv_configuration *configuration; /* the last one that was good, NULL: none yet */
  uint64_t block;                         /* number of the configuration that holds, from 1 */
  fvv_check_summary summary;
  fvv_bytes problems, tracks, runs;
  int frame_counted; /* the current time is a frame, and counted */
  int frame_good;    /* no chunk of the current frame was found wrong */
  fvv_status failed; /* the final error */
  uint64_t end;      /* has_footer: of the stream */
  int trailing;      /* bytes after it are reported */
  uint32_t digest;   /* of the configuration, from the last GRUP */
  int64_t group_end; /* from the last GRUP */
};

void fvv_check_options_default(fvv_check_options *options) {
  memset(options, 0, sizeof *options);
  options->struct_size = sizeof *options;
  options->decode = 1;
}

fvv_status fvv_checker_create(const fvv_check_options *options, const fvv_limits *limits,
                              const fvv_allocator *allocator, fvv_checker **checker) {
  const fvv_allocator chosen = fvv_allocator_or_default(allocator);
  *checker = fvv_allocate_zeroed(&chosen, sizeof **checker);
  if (!*checker) return FVV_ERROR_MEMORY;
  fvv_checker *c = *checker;
  c->allocator = c->problems.allocator = c->tracks.allocator = c->runs.allocator = chosen;
  fvv_check_options_default(&c->options);
  if (options) {
    const size_t size = options->struct_size < sizeof c->options ? options->struct_size : sizeof c->options;
    memcpy(&c->options, options, size);
  }
  c->limits = fvv_limits_or_default(limits);
  fvv_frames_options frames;
  fvv_frames_options_default(&frames);
  frames.eager = 0;
  const fvv_status status = fvv_frames_create(&frames, limits, &chosen, &c->frames);
  if (status < 0) {
    fvv_checker_destroy(c);
    *checker = NULL;
    return status;
  }
  fvv_frames_analyse(c->frames);
  return status;
}

static void reset_tracks(fvv_checker *c) {
  checked_track *tracks = (checked_track *)c->tracks.data;
  for (size_t i = 0; i < fvv_checker_track_count(c); i++) {
    fvv_mesh_frames_reset(&tracks[i].mesh.frames);
    reset_calibration(&tracks[i].calibration);
    fvv_visibility_frames_reset(&tracks[i].visibility.frames);
  }
  c->tracks.size = 0;
}

/* Everything but the configuration blocks, which fvv_frames remembers. */
static fvv_status restart(fvv_checker *c) {
  c->reads_again = 0;
  reset_tracks(c);
  c->problems.size = c->runs.size = 0;
  memset(&c->summary, 0, sizeof c->summary);
  c->end = 0;
  c->trailing = 0;
  c->configuration = NULL;
  c->frame_good = 0;
  c->block = 0;
  c->failed = fvv_frames_seek(c->frames, 0, NULL);
  return c->failed;
}

void fvv_checker_destroy(fvv_checker *checker) {
  if (!checker) return;
  const fvv_allocator allocator = checker->allocator;
  fvv_frames_destroy(checker->frames);
  reset_tracks(checker);
  fvv_bytes_free(&checker->problems);
  fvv_bytes_free(&checker->tracks);
  fvv_bytes_free(&checker->runs);
  fvv_release(&allocator, checker, sizeof *checker);
}

static fvv_status problem(fvv_checker *c, const fvv_diagnostic *diagnostic) {
  if (c->summary.problems++ >= KEPT_PROBLEMS) return FVV_OK;
  return fvv_bytes_append(&c->problems, diagnostic, sizeof *diagnostic);
}

static fvv_status find_track(fvv_checker *c, uint16_t id, checked_track **track) {
  checked_track *tracks = (checked_track *)c->tracks.data;
  const size_t count = c->tracks.size / sizeof *tracks;
  for (size_t i = 0; i < count; i++)
    if (tracks[i].summary.track == id) {
      *track = &tracks[i];
      return FVV_OK;
    }
  checked_track fresh;
  memset(&fresh, 0, sizeof fresh);
  fresh.summary.track = id;
  fresh.summary.smallest = UINT64_MAX;
  fresh.summary.min_vertices = fresh.summary.min_faces = UINT32_MAX;
  if (count >= c->limits.max_tracks) return FVV_ERROR_LIMIT;
  const fvv_status status = fvv_bytes_append(&c->tracks, &fresh, sizeof fresh);
  if (status < 0) return status;
  *track = (checked_track *)(c->tracks.data + c->tracks.size) - 1;
  return FVV_OK;
}

static void widen(uint8_t bits, int first, uint8_t *least, uint8_t *most) {
  if (first || bits < *least) *least = bits;
  if (bits > *most) *most = bits;
}

static void count_mesh(fvv_track_summary *t, const fvv_mesh_header *header) {
  t->vertices += header->vertex_count;
  t->faces += header->face_count;
  t->profile_chunks[header->profile]++;
  t->profile_bytes[header->profile] += FVV_MESH_SIZE + header->data_size;
  if (header->vertex_count < t->min_vertices) t->min_vertices = header->vertex_count;
  if (header->vertex_count > t->max_vertices) t->max_vertices = header->vertex_count;
  if (header->face_count < t->min_faces) t->min_faces = header->face_count;
  if (header->face_count > t->max_faces) t->max_faces = header->face_count;
  if (header->texture_bits)
    widen(header->texture_bits, !t->textured++, &t->min_texture_bits, &t->max_texture_bits);
  if (header->normal_bits)
    widen(header->normal_bits, !t->with_normals++, &t->min_normal_bits, &t->max_normal_bits);
}

static void count_visibility(fvv_track_summary *t, const fvv_visibility_header *header) {
  t->pairs += (uint64_t)header->camera_count * header->vertex_count;
  if (!t->max_cameras || header->camera_count < t->min_cameras) t->min_cameras = header->camera_count;
  if (header->camera_count > t->max_cameras) t->max_cameras = header->camera_count;
}

/* Where this group has the mesh that the chunk names, the chunk is checked against it and the calibration. */
static fvv_status judge_visibility(fvv_checker *c, const fvv_event *event, checked_track *track,
                                   fvv_diagnostic *diagnostic) {
  fvv_visibility_header header;
  const fvv_configuration *configuration = fvv_frames_configuration(c->frames);
  const checked_track *tracks = (const checked_track *)c->tracks.data;
  const checked_mesh *mesh = NULL;
  const checked_calibration *calibration = NULL;
  const fvv_status status = fvv_visibility_peek(event->payload, (size_t)event->chunk.size, &c->limits,
                                                &header, NULL, 0, diagnostic);
  if (status != FVV_OK) {
    track->visibility.lost = 1;
    return status;
  }
  count_visibility(&track->summary, &header);
  for (size_t i = 0; i < fvv_checker_track_count(c); i++) {
    if (tracks[i].summary.track == header.mesh_track && tracks[i].mesh.group == c->summary.groups)
      mesh = &tracks[i].mesh;
    if (tracks[i].summary.kind == FVV_TRACK_CALIBRATION) calibration = &tracks[i].calibration;
  }
  return judge_visibility_chunk(&track->visibility, event, c->summary.groups, c->options.decode, mesh,
                                calibration, configuration, &c->limits, &c->allocator, &c->frame_good,
                                diagnostic);
}

static fvv_status judge_colours(fvv_checker *c, const fvv_event *event, fvv_track_summary *summary,
                                fvv_diagnostic *diagnostic) {
  fvv_colours_header header;
  const checked_track *tracks = (const checked_track *)c->tracks.data;
  const checked_mesh *mesh = NULL;
  const fvv_status status =
      fvv_colours_peek(event->payload, (size_t)event->chunk.size, &c->limits, &header, diagnostic);
  if (status != FVV_OK) return status;
  if (!summary->cells || header.cell_size < summary->min_cell_size) summary->min_cell_size = header.cell_size;
  if (header.cell_size > summary->max_cell_size) summary->max_cell_size = header.cell_size;
  summary->cells += header.cell_count;
  for (size_t i = 0; i < fvv_checker_track_count(c); i++)
    if (tracks[i].summary.track == header.mesh_track) mesh = &tracks[i].mesh;
  return judge_colours_chunk(event, c->summary.groups, c->options.decode, mesh,
                             fvv_frames_configuration(c->frames), &c->limits, &c->allocator, &c->frame_good,
                             diagnostic);
}

/* Checks the payload by the rules of its type. */
static fvv_status judge(fvv_checker *c, const fvv_event *event, checked_track *track,
                        fvv_diagnostic *diagnostic) {
  const size_t size = (size_t)event->chunk.size;
  const fvv_configuration *configuration = fvv_frames_configuration(c->frames);
  if (event->chunk.type == FVV_CHUNK_MESH) {
    fvv_mesh_header header = {0};
    const fvv_status status =
        judge_mesh_chunk(&track->mesh, event, c->summary.groups, c->options.decode, &c->limits, &c->allocator,
                         &header, &c->frame_good, diagnostic);
    if (header.vertex_count) count_mesh(&track->summary, &header);
    return status;
  }
  if (event->chunk.type == FVV_CHUNK_VISIBILITY && configuration)
    return judge_visibility(c, event, track, diagnostic);
  if (event->chunk.type == FVV_CHUNK_COLOURS && configuration)
    return judge_colours(c, event, &track->summary, diagnostic);
  if (event->chunk.type == FVV_CHUNK_CALIBRATION && configuration)
    count_calibrations(&track->summary, event, configuration);
  if (event->chunk.type == FVV_CHUNK_TILES && configuration)
    return judge_group_tiles(&track->tiles, event, c->summary.groups, configuration, &c->limits,
                             &c->allocator, &track->summary, diagnostic);
  if (event->chunk.type == FVV_CHUNK_VIDEO_PACKET && track->tiles.lost_in == c->summary.groups)
    c->frame_good = 0;
  if (event->chunk.type == FVV_CHUNK_AUDIO && configuration)
    return judge_audio(&track->audio, event, c->summary.groups, c->group_end, configuration, &track->summary,
                       diagnostic);
  if (event->chunk.type == FVV_CHUNK_ENVIRONMENT)
    return judge_environment(&track->environment, event, c->digest, c->options.decode, &c->limits,
                             &c->allocator, &track->summary, diagnostic);
  if (!c->options.decode || !configuration) return FVV_OK;
  if (event->chunk.type == FVV_CHUNK_CALIBRATION)
    return judge_calibration(&track->calibration, event, c->block, c->summary.groups, configuration,
                             &c->allocator, &c->frame_good, diagnostic);
  if (event->chunk.type == FVV_CHUNK_VIDEO_PACKET) {
    const fvv_video_layout *video = fvv_configuration_video(configuration, event->chunk.track);
    if (video)
      return fvv_video_sample_check(&video->config, event->chunk.flags & FVV_FLAG_KEY, event->payload, size,
                                    diagnostic);
  }
  return FVV_OK;
}

static void count_chunk(fvv_track_summary *summary, const fvv_chunk_header *header) {
  summary->chunks++;
  summary->key_chunks += (header->flags & FVV_FLAG_KEY) != 0;
  if (header->size < summary->smallest) summary->smallest = header->size;
  if (header->size > summary->largest) summary->largest = header->size;
}

/* The end of a stream that is cut within a group is that of its last frame. */
static void reach(fvv_check_summary *summary, int64_t time, int64_t frame_duration) {
  const int64_t end = time > INT64_MAX - frame_duration ? INT64_MAX : time + frame_duration;
  if (summary->groups && end > summary->end) summary->end = end;
}

/* A chunk of a track; begins: it is the first at its time. */
static fvv_status take_frame_chunk(fvv_checker *c, const fvv_event *event, int begins) {
  const fvv_chunk_header *header = &event->chunk;
  if (!header->track) return FVV_OK;
  if (begins) {
    c->frame_good = 1;
    c->frame_counted = 0;
  }
  if (fvv_makes_frame(header->type) && !c->frame_counted) {
    c->frame_counted = 1;
    c->summary.frames++;
    reach(&c->summary, header->time, c->configuration ? c->configuration->scene.frame_duration : 0);
  }
  c->summary.payload_bytes += header->size;
  checked_track *track;
  const fvv_status found = find_track(c, header->track, &track);
  if (found < 0) return found;
  fvv_track_summary *summary = &track->summary;
  summary->kind = fvv_chunk_track_kind(header->type);
  summary->bytes += header->size;
  if (header->type != FVV_CHUNK_TILES) count_chunk(summary, header);
  fvv_diagnostic diagnostic = {0};
  const fvv_status status = judge(c, event, track, &diagnostic);
  if (status >= 0) return FVV_OK;
  if (status == FVV_ERROR_MEMORY) return status;
  c->frame_good = 0;
  fvv_diagnostic_rebase(&diagnostic, event->offset + FVV_CHUNK_HEADER_SIZE, header->type);
  return problem(c, &diagnostic);
}

/* The block is good without the sound, so that nothing else reports a codec that is not known. */
static fvv_status judge_audio_codec(fvv_checker *c, const fvv_event *event) {
  fvv_audio_config config;
  fvv_diagnostic diagnostic = {0};
  const fvv_status status =
      fvv_audio_config_decode(&config, event->payload, (size_t)event->chunk.size, &c->limits, &diagnostic);
  if (status != FVV_ERROR_UNSUPPORTED) return FVV_OK;
  fvv_diagnostic_rebase(&diagnostic, event->offset + FVV_CHUNK_HEADER_SIZE, event->chunk.type);
  return problem(c, &diagnostic);
}

static fvv_status take_chunk(fvv_checker *c, const fvv_event *event, int begins_time) {
  c->summary.chunks++;
  if (event->chunk.type == FVV_CHUNK_AUDIO_CONFIG) return judge_audio_codec(c, event);
  if (fvv_chunk_place(event->chunk.type, event->chunk.flags) == FVV_PLACE_FRAME)
    return take_frame_chunk(c, event, begins_time);
  if (event->chunk.type == FVV_CHUNK_SCENE) c->summary.configurations++;
  if (event->chunk.type == FVV_CHUNK_GROUP && !c->summary.groups++)
    c->summary.start = c->summary.end = event->chunk.time;
  if (event->chunk.type == FVV_CHUNK_GROUP_END) c->summary.end = event->chunk.time;
  return FVV_OK;
}

static fvv_status take_read(fvv_checker *c, const fvv_event *event, int begins_time) {
  if (c->options.event) c->options.event(c->options.user, event);
  if (event->kind == FVV_EVENT_CHUNK) return take_chunk(c, event, begins_time);
  if (event->kind == FVV_EVENT_HEADER) {
    c->summary.written_major = event->written_major;
    c->summary.written_minor = event->written_minor;
  }
  if (event->kind == FVV_EVENT_DAMAGE && event->diagnostic.status == FVV_ERROR_TRUNCATED)
    c->summary.truncated = 1;
  return FVV_OK;
}

static fvv_status count_frame(fvv_checker *c, int64_t time) {
  const uint64_t number = c->summary.frames - 1;
  c->summary.whole_frames++;
  fvv_frame_run *last = c->runs.size ? (fvv_frame_run *)(c->runs.data + c->runs.size) - 1 : NULL;
  if (last && last->first + last->count == number) {
    last->count++;
    last->last_time = time;
    return FVV_OK;
  }
  const fvv_frame_run run = {number, 1, time, time};
  return fvv_bytes_append(&c->runs, &run, sizeof run);
}

static fvv_status take_event(fvv_checker *c, const fvv_frames_event *event) {
  if (event->kind == FVV_FRAMES_READ)
    return take_read(c, fvv_frames_read(c->frames), fvv_frames_begins_time(c->frames));
  switch (event->kind) {
  case FVV_FRAMES_CONFIGURATION:
    c->configuration = event->configuration;
    c->block++;
    return FVV_OK;
  case FVV_FRAMES_GROUP:
    c->digest = event->configuration_crc;
    c->group_end = event->end;
    return FVV_OK;
  case FVV_FRAMES_FRAME:
    return event->whole && c->frame_good ? count_frame(c, event->time) : FVV_OK;
  case FVV_FRAMES_DAMAGE:
    return problem(c, &event->diagnostic);
  case FVV_FRAMES_END:
    c->summary.has_footer = 1;
    c->end = event->offset;
    return FVV_OK;
  default:
    return FVV_OK;
  }
}

/* What follows the footer is no part of the stream, and not looked at. */
static fvv_status report_trailing(fvv_checker *c) {
  fvv_diagnostic trailing = {0};
  if (c->trailing || c->summary.bytes <= c->end) return FVV_OK;
  c->trailing = 1;
  fvv_fail(&trailing, FVV_ERROR_DAMAGED, FVV_ISSUE_TRAILING, 0, c->end, "bytes follow the footer");
  return problem(c, &trailing);
}

static fvv_status pull(fvv_checker *c) {
  fvv_frames_event event;
  fvv_diagnostic diagnostic = {0};
  fvv_status status;
  while ((status = fvv_frames_next(c->frames, &event, &diagnostic)) == FVV_OK) {
    status = take_event(c, &event);
    if (status < 0) {
      fvv_fail(&diagnostic, status, status == FVV_ERROR_LIMIT ? FVV_ISSUE_LIMIT : 0,
               event.kind == FVV_FRAMES_READ ? fvv_frames_read(c->frames)->chunk.type : 0, event.offset, "%s",
               fvv_status_text(status));
      break;
    }
    if (c->summary.has_footer) return report_trailing(c);
  }
  if (status >= 0) return FVV_OK;
  c->failed = status;
  if (status == FVV_ERROR_TRUNCATED) c->summary.truncated = 1;
  const fvv_status kept = problem(c, &diagnostic);
  return kept < 0 ? kept : status;
}

fvv_status fvv_checker_push(fvv_checker *checker, const void *bytes, size_t size) {
  if (checker->reads_again) (void)restart(checker);
  checker->summary.bytes += size;
  if (checker->failed) return checker->failed;
  if (checker->summary.has_footer) return report_trailing(checker);
  const fvv_status status = fvv_frames_push(checker->frames, bytes, size);
  return status < 0 ? (checker->failed = status) : pull(checker);
}

fvv_status fvv_checker_finish(fvv_checker *checker) {
  if (!checker->failed) {
    fvv_frames_finish(checker->frames);
    if (!checker->summary.has_footer) checker->failed = pull(checker);
  }
  if (checker->failed) return checker->failed;
  if (!checker->summary.has_footer) checker->summary.truncated = 1;
  checker->reads_again = fvv_frames_missed_groups(checker->frames);
  return checker->reads_again ? FVV_NEED_DATA : FVV_OK;
}

size_t fvv_checker_problem_count(const fvv_checker *checker) {
  return checker->problems.size / sizeof(fvv_diagnostic);
}
const fvv_diagnostic *fvv_checker_problem(const fvv_checker *checker, size_t i) {
  return i < fvv_checker_problem_count(checker) ? (const fvv_diagnostic *)checker->problems.data + i : NULL;
}
const fvv_check_summary *fvv_checker_summary(const fvv_checker *checker) {
  return &checker->summary;
}
size_t fvv_checker_track_count(const fvv_checker *checker) {
  return checker->tracks.size / sizeof(checked_track);
}
const fvv_track_summary *fvv_checker_track(const fvv_checker *checker, size_t i) {
  if (i >= fvv_checker_track_count(checker)) return NULL;
  return &((const checked_track *)checker->tracks.data)[i].summary;
}
size_t fvv_checker_run_count(const fvv_checker *checker) {
  return checker->runs.size / sizeof(fvv_frame_run);
}
const fvv_frame_run *fvv_checker_run(const fvv_checker *checker, size_t i) {
  return i < fvv_checker_run_count(checker) ? (const fvv_frame_run *)checker->runs.data + i : NULL;
}
const fvv_configuration *fvv_checker_configuration(const fvv_checker *checker) {
  return checker->configuration;
}
