/* The checker: pulls every event of a stream, checks each chunk against those before it, and counts. */
#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "container/header.h"
#include "fvv/stream.h"
#include "stream/frames.h"
#include "stream/track_checks.h"

enum { KEPT_PROBLEMS = 1000 };

typedef struct checked_track {
  fvv_track_summary summary;
  checked_mesh mesh;
  checked_calibration calibration;
  checked_visibility visibility;
  checked_tiles tiles;
  checked_audio audio;
  checked_environment environment;
  uint64_t invalid_in; /* the group, counted from 1, in which a chunk was wrong: those after it, up to the
                          next key, are not intact (FVV-9009); 0: none */
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
    fvv_reset_calibration(&tracks[i].calibration);
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
  return fvv_judge_visibility_chunk(&track->visibility, event, c->summary.groups, c->options.decode, mesh,
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
  return fvv_judge_colours_chunk(event, c->summary.groups, c->options.decode, mesh,
                                 fvv_frames_configuration(c->frames), &c->limits, &c->allocator,
                                 &c->frame_good, diagnostic);
}

/* Checks a video sample; its layout, if the group has one, was good. */
static fvv_status judge_sample(fvv_checker *c, const fvv_event *event, const checked_track *track,
                               const fvv_configuration *configuration, fvv_diagnostic *diagnostic) {
  const fvv_video_layout *video =
      configuration ? fvv_configuration_video(configuration, event->chunk.track) : NULL;
  if (track->tiles.lost_in == c->summary.groups) c->frame_good = 0;
  if (!c->options.decode || !video) return FVV_OK;
  return fvv_video_sample_check(&video->config, event->chunk.flags & FVV_FLAG_KEY, event->payload,
                                (size_t)event->chunk.size, diagnostic);
}

/* Checks the payload by the rules of its type. */
static fvv_status judge(fvv_checker *c, const fvv_event *event, checked_track *track,
                        fvv_diagnostic *diagnostic) {
  const fvv_configuration *configuration = fvv_frames_configuration(c->frames);
  const uint64_t group = c->summary.groups;
  fvv_mesh_header header = {0};
  fvv_status status;
  switch (event->chunk.type) {
  case FVV_CHUNK_MESH:
    status = fvv_judge_mesh_chunk(&track->mesh, event, group, c->options.decode, &c->limits, &c->allocator,
                                  &header, &c->frame_good, diagnostic);
    if (header.vertex_count) count_mesh(&track->summary, &header);
    return status;
  case FVV_CHUNK_ENVIRONMENT:
    return fvv_judge_environment(&track->environment, event, c->digest, c->options.decode, &c->limits,
                                 &c->allocator, &track->summary, diagnostic);
  case FVV_CHUNK_VIDEO_PACKET:
    return judge_sample(c, event, track, configuration, diagnostic);
  default:
    break;
  }
  if (!configuration) return FVV_OK;
  switch (event->chunk.type) {
  case FVV_CHUNK_VISIBILITY:
    return judge_visibility(c, event, track, diagnostic);
  case FVV_CHUNK_COLOURS:
    return judge_colours(c, event, &track->summary, diagnostic);
  case FVV_CHUNK_TILES:
    if (!fvv_configuration_video(configuration, event->chunk.track)) return FVV_OK;
    return fvv_judge_group_tiles(&track->tiles, event, group, configuration, &c->limits, &c->allocator,
                                 &track->summary, diagnostic);
  case FVV_CHUNK_AUDIO:
    return fvv_judge_audio(&track->audio, event, group, c->group_end, configuration, &track->summary,
                           diagnostic);
  case FVV_CHUNK_CALIBRATION:
    fvv_count_calibrations(&track->summary, event, configuration);
    if (!c->options.decode) return FVV_OK;
    return fvv_judge_calibration(&track->calibration, event, c->block, group, configuration, &c->allocator,
                                 &c->frame_good, diagnostic);
  default:
    return FVV_OK;
  }
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

/* begins: the chunk is the first at its time. */
static void count_time(fvv_checker *c, const fvv_chunk_header *header, int begins) {
  if (begins) {
    c->frame_good = 1;
    c->frame_counted = 0;
  }
  if (c->frame_counted || !fvv_configuration_makes_frame(c->configuration, header->type, header->track))
    return;
  c->frame_counted = 1;
  c->summary.frames++;
  reach(&c->summary, header->time, c->configuration ? c->configuration->scene.frame_duration : 0);
}

/* A chunk of a track; begins: it is the first at its time. */
static fvv_status take_frame_chunk(fvv_checker *c, const fvv_event *event, int begins) {
  const fvv_chunk_header *header = &event->chunk;
  if (!header->track) return FVV_OK;
  count_time(c, header, begins);
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
  if (status == FVV_ERROR_MEMORY) return status;
  if (status < 0)
    track->invalid_in = c->summary.groups;
  else if (header->flags & FVV_FLAG_KEY && header->type != FVV_CHUNK_TILES)
    track->invalid_in = 0;
  const int is_lost = track->invalid_in && track->invalid_in == c->summary.groups;
  if (is_lost && header->type != FVV_CHUNK_AUDIO && header->type != FVV_CHUNK_ENVIRONMENT) c->frame_good = 0;
  if (status >= 0) return FVV_OK;
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
  const fvv_place place = fvv_chunk_place(event->chunk.type, event->chunk.flags);
  if (place == FVV_PLACE_FRAME) return take_frame_chunk(c, event, begins_time);
  if (place == FVV_PLACE_UNKNOWN && event->chunk.track) count_time(c, &event->chunk, begins_time);
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
