/* Joins chunks into configurations and frames (fvv/frames.h). Only here is it decided when a configuration
 * block is complete and when a frame is whole. */
#include "stream/frames.h"

#include <string.h>

#include "base/bytes.h"
#include "base/checked.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "container/chunk_order.h"
#include "container/header.h"
#include "container/reader.h"
#include "stream/configuration.h"

/* A frame as its chunks arrive. Payloads lie one after the other, each from a multiple of 8 bytes on. */
typedef struct open_frame {
  int64_t time;
  uint64_t offset;
  fvv_bytes chunks, payloads; /* fvv_frame_chunk, whose payload is set when the frame is over */
  int is_open, is_over;       /* neither: no frame of the group has begun */
  int makes_frame;            /* it has or had a chunk that makes its time a frame */
} open_frame;

/* Digests of blocks that groups lacked: the first ones. */
enum { LACKED_BLOCKS = 64 };

/* An intact configuration block. Groups name blocks by digest, so that any repetition serves. */
typedef struct known_block {
  int used;
  uint32_t digest;
  fvv_configuration_builder builder;
} known_block;

struct fvv_frames {
  fvv_allocator allocator;
  fvv_limits limits;
  fvv_frames_options options;
  int analyses; /* fvv_frames_analyse */
  fvv_reader *reader;
  fvv_event_source source; /* NULL: the reader */
  void *source_user;
  fvv_configuration_builder building; /* the block that arrives */
  known_block known[FVV_KNOWN_BLOCKS];
  size_t next_known;                      /* that is replaced next */
  const fvv_configuration *configuration; /* that holds; NULL: none yet */
  uint64_t block_offset;
  uint32_t block_digest, digest; /* of the block that arrives, and of the configuration that holds */
  uint32_t lacked[LACKED_BLOCKS];
  size_t lacked_count;
  int block_open, block_bad, has_digest;
  int in_block;     /* no chunk of a group has come since SCEN */
  int block_hurt;   /* something was lost or wrong in the block that arrives */
  int block_silent; /* it was reported that an audio track has no configuration */
  open_frame frame;
  int in_group, lost; /* lost: frames up to the next group are not whole */
  fvv_bytes left_out; /* uint16_t: tracks that the caller does not use */
  fvv_bytes hurt;     /* uint16_t: tracks that lost a chunk of the group, which frames do not need */
  int spared;         /* damage of the group was reported that costs no frame */
  fvv_event event;    /* that was read, and is not processed yet */
  fvv_place place;    /* of its chunk; FVV_PLACE_UNKNOWN for events of other kinds as well */
  int is_foreign;     /* its chunk is of an unknown type and makes a frame all the same */
  int is_listed;      /* all chunks of the open group up to it are known by their headers */
  int has_event, is_reported, is_finished;
  fvv_status failed; /* out of memory */
};

void fvv_frames_options_default(fvv_frames_options *options) {
  memset(options, 0, sizeof *options);
  options->struct_size = sizeof *options;
  options->eager = 1;
}

fvv_status fvv_frames_seek(fvv_frames *frames, uint64_t offset, const fvv_configuration *configuration) {
  fvv_frames *f = frames;
  f->source = NULL;
  f->configuration = configuration;
  f->lost = 1;
  f->block_open = f->in_block = f->block_bad = f->has_digest = f->in_group = f->has_event = f->is_finished =
      0;
  f->failed = FVV_OK;
  f->frame.is_open = f->frame.is_over = f->spared = 0;
  f->lacked_count = f->hurt.size = 0;
  fvv_reader *former = f->reader;
  const fvv_status status = fvv_reader_create(&f->limits, &f->allocator, offset, &f->reader);
  if (status == FVV_OK && former) fvv_reader_inherit(f->reader, former);
  fvv_reader_destroy(former);
  return status;
}

fvv_status fvv_frames_create(const fvv_frames_options *options, const fvv_limits *limits,
                             const fvv_allocator *allocator, fvv_frames **frames) {
  const fvv_allocator chosen = fvv_allocator_or_default(allocator);
  *frames = fvv_allocate_zeroed(&chosen, sizeof **frames);
  if (!*frames) return FVV_ERROR_MEMORY;
  fvv_frames *f = *frames;
  f->allocator = f->frame.chunks.allocator = f->frame.payloads.allocator = chosen;
  f->left_out.allocator = f->hurt.allocator = chosen;
  fvv_frames_options_default(&f->options);
  if (options) {
    const size_t size = options->struct_size < sizeof f->options ? options->struct_size : sizeof f->options;
    memcpy(&f->options, options, size);
  }
  fvv_configuration_init(&f->building, limits, &chosen);
  for (size_t i = 0; i < FVV_KNOWN_BLOCKS; i++) fvv_configuration_init(&f->known[i].builder, limits, &chosen);
  f->limits = f->building.limits;
  const fvv_status status = fvv_frames_seek(f, 0, NULL);
  if (status < 0) {
    fvv_frames_destroy(f);
    *frames = NULL;
  }
  return status;
}

void fvv_frames_destroy(fvv_frames *frames) {
  if (!frames) return;
  const fvv_allocator allocator = frames->allocator;
  fvv_reader_destroy(frames->reader);
  fvv_configuration_free(&frames->building);
  for (size_t i = 0; i < FVV_KNOWN_BLOCKS; i++) fvv_configuration_free(&frames->known[i].builder);
  fvv_bytes_free(&frames->frame.chunks);
  fvv_bytes_free(&frames->frame.payloads);
  fvv_bytes_free(&frames->left_out);
  fvv_bytes_free(&frames->hurt);
  fvv_release(&allocator, frames, sizeof *frames);
}

fvv_status fvv_frames_push(fvv_frames *frames, const void *bytes, size_t size) {
  return fvv_reader_push(frames->reader, bytes, size);
}

void fvv_frames_finish(fvv_frames *frames) {
  frames->is_finished = 1;
  fvv_reader_finish(frames->reader);
}

const fvv_configuration *fvv_frames_configuration(const fvv_frames *frames) {
  return frames->block_bad ? NULL : frames->configuration;
}

fvv_status fvv_frames_join(fvv_frames *frames) {
  return fvv_reader_join(frames->reader);
}

void fvv_frames_read_from(fvv_frames *frames, fvv_event_source source, void *user) {
  frames->source = source;
  frames->source_user = user;
}

void fvv_frames_drop_group(fvv_frames *frames) {
  frames->lost = 1;
}

fvv_status fvv_frames_leave_out(fvv_frames *frames, const uint16_t *tracks, size_t count) {
  frames->left_out.size = 0;
  return fvv_bytes_append(&frames->left_out, tracks, count * sizeof *tracks);
}

static void report_damage(fvv_frames *f, const fvv_diagnostic *diagnostic, uint64_t offset, uint64_t skipped,
                          fvv_frames_event *out) {
  out->kind = FVV_FRAMES_DAMAGE;
  out->offset = offset;
  out->diagnostic = *diagnostic;
  out->skipped = skipped;
  f->lost = f->block_hurt = 1;
}

/* Something is wrong that costs no more than an ancillary chunk, or a track. */
static void report_stop(const fvv_diagnostic *diagnostic, uint64_t offset, fvv_frames_event *out) {
  out->kind = FVV_FRAMES_DAMAGE;
  out->offset = offset;
  out->diagnostic = *diagnostic;
  out->whole = 1;
}

/* ---- configuration ---------------------------------------------------------------------------------- */

static fvv_status add_configuration(fvv_frames *f, fvv_frames_event *out) {
  const fvv_event *event = &f->event;
  if (event->chunk.type == FVV_CHUNK_SCENE) {
    f->block_open = f->in_block = 1;
    f->block_bad = f->block_hurt = f->block_silent = 0;
    f->block_offset = event->offset;
    f->block_digest = 0;
  }
  if (!f->block_open || f->block_bad) return FVV_OK;
  f->block_digest = fvv_header_chain(f->block_digest, &event->chunk);
  fvv_diagnostic why = {0};
  const fvv_status status =
      fvv_configuration_add(&f->building, &event->chunk, event->payload, event->offset, &why);
  if (status >= 0 || status == FVV_ERROR_MEMORY) return status;
  if (fvv_configuration_survives(&event->chunk, status)) {
    report_stop(&why, event->offset, out);
    return FVV_OK;
  }
  f->block_bad = 1;
  /* What is wrong because something before it was lost is no damage of its own. */
  if (!f->block_hurt) report_damage(f, &why, event->offset, 0, out);
  return FVV_OK;
}

static const known_block *find_known(const fvv_frames *f, uint32_t digest) {
  for (size_t i = 0; i < FVV_KNOWN_BLOCKS; i++)
    if (f->known[i].used && f->known[i].digest == digest) return &f->known[i];
  return NULL;
}

/* A known block holds from here on. */
static void use_block(fvv_frames *f, const known_block *block, uint64_t offset, fvv_frames_event *out) {
  f->configuration = &block->builder.view;
  f->block_bad = 0;
  out->kind = FVV_FRAMES_CONFIGURATION;
  out->offset = offset;
  out->configuration = f->configuration;
  out->repeated = f->has_digest && f->digest == block->digest;
  f->digest = block->digest;
  f->has_digest = 1;
}

/* Exchanges the block that arrived for the one that has been known longest. */
static known_block *keep_block(fvv_frames *f) {
  known_block *block = &f->known[f->next_known];
  f->next_known = (f->next_known + 1) % FVV_KNOWN_BLOCKS;
  const fvv_configuration_builder former = block->builder;
  block->builder = f->building;
  f->building = former;
  block->digest = f->block_digest;
  block->used = 1;
  return block;
}

static int is_group(const fvv_frames *f) {
  return f->place != FVV_PLACE_UNKNOWN && f->event.chunk.type == FVV_CHUNK_GROUP &&
         f->event.chunk.size == FVV_GRUP_SIZE;
}

/* Digest of the configuration of the group whose GRUP chunk is the current event. */
static uint32_t wanted_digest(const fvv_frames *f) {
  return fvv_get_u32(f->event.payload + FVV_GRUP_CONFIGURATION_CRC);
}

/* A block is checked when something other than configuration follows it, or at the end of the stream. Where
 * damage was reported, the digest of the next group shows whether the block is whole nevertheless; what is
 * wrong with the rest of it is no damage of its own. */
static fvv_status close_block(fvv_frames *f, int stream_ended, fvv_frames_event *out) {
  f->block_open = 0;
  const int is_whole_block = !stream_ended && is_group(f) && wanted_digest(f) == f->block_digest;
  if (f->block_hurt && !stream_ended && !is_whole_block) f->block_bad = 1;
  if (f->block_bad) return FVV_OK;
  fvv_diagnostic why = {0};
  const fvv_status status = fvv_configuration_complete(&f->building, f->block_offset, &why);
  if (status == FVV_ERROR_MEMORY) return status;
  if (status < 0) {
    f->block_bad = 1;
    if (is_whole_block) report_damage(f, &why, f->block_offset, 0, out);
    return FVV_OK;
  }
  if (is_whole_block && !f->block_silent &&
      fvv_configuration_check_silent(&f->building, f->block_offset, &why) < 0) {
    f->block_open = f->block_silent = 1; /* the block itself is reported by the next call */
    report_stop(&why, f->block_offset, out);
    return FVV_OK;
  }
  const known_block *known = find_known(f, f->block_digest);
  use_block(f, known ? known : keep_block(f), f->block_offset, out);
  return FVV_OK;
}

/* Whether the configuration that holds is that of the group. Where playback began in the middle of a stream,
 * the caller has chosen it. */
static int is_configured(const fvv_frames *f) {
  return fvv_frames_configuration(f) && (!is_group(f) || !f->has_digest || f->digest == wanted_digest(f));
}

/* The block of the group that begins is damaged or lost: a repetition of it that came earlier is used. */
static void recall_block(fvv_frames *f, fvv_frames_event *out) {
  if (!is_group(f) || is_configured(f)) return;
  const known_block *block = find_known(f, wanted_digest(f));
  if (block) use_block(f, block, f->event.offset, out);
}

static void note_lacked_block(fvv_frames *f) {
  if (!is_group(f)) return;
  for (size_t i = 0; i < f->lacked_count; i++)
    if (f->lacked[i] == wanted_digest(f)) return;
  if (f->lacked_count < LACKED_BLOCKS) f->lacked[f->lacked_count++] = wanted_digest(f);
}

int fvv_frames_missed_groups(const fvv_frames *frames) {
  for (size_t i = 0; i < frames->lacked_count; i++)
    if (find_known(frames, frames->lacked[i])) return 1;
  return 0;
}

/* ---- frames ----------------------------------------------------------------------------------------- */

static int is_frame_chunk(const fvv_frames *f) {
  return f->place == FVV_PLACE_FRAME && f->event.chunk.track;
}

/* Whether the time of the current event's chunk is a frame because of it. */
static int makes_frame(const fvv_frames *f) {
  return fvv_configuration_makes_frame(f->configuration, f->event.chunk.type, f->event.chunk.track);
}

static int has_track(const fvv_bytes *tracks, uint16_t track) {
  const uint16_t *ids = (const uint16_t *)tracks->data;
  for (size_t i = 0; i < tracks->size / sizeof *ids; i++)
    if (ids[i] == track) return 1;
  return 0;
}

/* Whether chunks of a track are passed over: it is left out, or it lost one of the group. */
static int is_passed_over(const fvv_frames *f, uint16_t track) {
  return has_track(&f->left_out, track) || has_track(&f->hurt, track);
}

/* Whether a frame has chunks of the track. Others have times of their own. */
static int is_of_frames(const fvv_track *track) {
  return track->kind < FVV_TRACK_ENVIRONMENT || track->kind == FVV_TRACK_COLOURS ||
         (track->kind == FVV_TRACK_DATA && track->flags & FVV_TRACK_FLAG_FRAMES);
}

/* The current frame is over. Its bytes stay until the next one begins. */
static void close_frame(fvv_frames *f, fvv_frames_event *out) {
  open_frame *frame = &f->frame;
  frame->is_open = 0;
  frame->is_over = 1;
  fvv_frame_chunk *chunks = (fvv_frame_chunk *)frame->chunks.data;
  const size_t count = frame->chunks.size / sizeof *chunks;
  if ((f->lost && !f->analyses) || (!count && !frame->makes_frame)) return;
  out->kind = frame->makes_frame ? FVV_FRAMES_FRAME : FVV_FRAMES_BETWEEN;
  out->offset = frame->offset;
  out->time = frame->time;
  out->whole = !f->lost;
  out->chunks = chunks;
  out->chunk_count = count;
  const uint8_t *payload = frame->payloads.data;
  for (size_t i = 0; i < count && !f->analyses; i++) {
    chunks[i].payload = payload;
    payload += fvv_padded(chunks[i].header.size);
  }
}

int fvv_frames_peek(const fvv_frames *f, uint32_t type, fvv_frame_chunk *chunk) {
  const open_frame *frame = &f->frame;
  const fvv_frame_chunk *chunks = (const fvv_frame_chunk *)frame->chunks.data;
  const size_t count = frame->is_open ? frame->chunks.size / sizeof *chunks : 0;
  const uint8_t *payload = frame->payloads.data;
  for (size_t i = 0; i < count; i++) {
    if (chunks[i].header.type == type) {
      *chunk = chunks[i];
      chunk->payload = f->analyses ? NULL : payload;
      return 1;
    }
    if (!f->analyses) payload += fvv_padded(chunks[i].header.size);
  }
  return 0;
}

static int has_chunk_of(const fvv_frames *f, uint16_t track) {
  const fvv_frame_chunk *chunks = (const fvv_frame_chunk *)f->frame.chunks.data;
  for (size_t i = 0; i < f->frame.chunks.size / sizeof *chunks; i++)
    if (chunks[i].header.track == track && chunks[i].header.type != FVV_CHUNK_TILES) return 1;
  return 0;
}

/* A key mesh, or one with a patch. Without payloads every mesh may be one. */
static int has_coloured_mesh(const fvv_frames *f) {
  const fvv_frame_chunk *chunks = (const fvv_frame_chunk *)f->frame.chunks.data;
  const uint8_t *payload = f->frame.payloads.data;
  for (size_t i = 0; i < f->frame.chunks.size / sizeof *chunks; i++) {
    const fvv_chunk_header *header = &chunks[i].header;
    if (header->type == FVV_CHUNK_MESH &&
        (header->flags & FVV_FLAG_KEY || f->analyses ||
         (header->size > FVV_MESH_PROFILE && payload[FVV_MESH_PROFILE] == FVV_MESH_PATCHED)))
      return 1;
    if (!f->analyses) payload += fvv_padded(header->size);
  }
  return 0;
}

/* Whether nothing more can belong to the current frame: it has a chunk of every track, and no track has two
 * at one time (clause 6.2). Only key meshes and patches have colours, and no frame consists of colours alone.
 * Sound comes after the frame. With an environment track it waits, as few frames have a chunk of that. */
static int is_complete(const fvv_frames *f) {
  const fvv_configuration *c = f->configuration;
  size_t present = 0;
  for (size_t i = 0; i < c->track_count; i++) {
    const uint8_t kind = c->tracks[i].kind;
    if (is_passed_over(f, c->tracks[i].id)) continue;
    if (kind == FVV_TRACK_ENVIRONMENT) return 0;
    if (!is_of_frames(&c->tracks[i])) continue;
    const int has = has_chunk_of(f, c->tracks[i].id);
    if (!has && (kind != FVV_TRACK_COLOURS || has_coloured_mesh(f))) return 0;
    present += has && kind != FVV_TRACK_COLOURS;
  }
  return present != 0;
}

void fvv_frames_analyse(fvv_frames *frames) {
  frames->analyses = 1;
}
const fvv_event *fvv_frames_read(const fvv_frames *frames) {
  return &frames->event;
}
int fvv_frames_begins_time(const fvv_frames *frames) {
  return is_frame_chunk(frames) && !frames->frame.is_open;
}

/* A chunk that is passed over belongs to a frame, too: that keeps its number. */
static void open_frame_of(fvv_frames *f) {
  const fvv_event *event = &f->event;
  open_frame *frame = &f->frame;
  if (!frame->is_open) {
    frame->is_open = 1;
    frame->makes_frame = 0;
    frame->time = event->chunk.time;
    frame->offset = event->offset;
    frame->chunks.size = frame->payloads.size = 0;
  }
  frame->makes_frame |= makes_frame(f);
}
static void pass_over_chunk(fvv_frames *f) {
  const open_frame *frame = &f->frame;
  const int follows_its_frame = frame->is_over && !frame->is_open && frame->time == f->event.chunk.time;
  if (!follows_its_frame) open_frame_of(f);
}

static fvv_status add_frame_chunk(fvv_frames *f, fvv_frames_event *out) {
  static const uint8_t padding[8] = {0};
  const fvv_event *event = &f->event;
  open_frame *frame = &f->frame;
  if (f->lost && !f->analyses) return FVV_OK;
  if (f->is_foreign || is_passed_over(f, event->chunk.track)) {
    pass_over_chunk(f);
    return FVV_OK;
  }
  open_frame_of(f);
  const fvv_frame_chunk chunk = {event->chunk, event->offset, NULL};
  const size_t size = (size_t)event->chunk.size;
  fvv_status status = fvv_bytes_append(&frame->chunks, &chunk, sizeof chunk);
  if (status == FVV_OK && !f->analyses) {
    status = fvv_bytes_append(&frame->payloads, event->payload, size);
    if (status == FVV_OK) status = fvv_bytes_append(&frame->payloads, padding, fvv_padded(size) - size);
  }
  if (status == FVV_OK && f->options.eager && !f->lost && is_complete(f)) close_frame(f, out);
  return status;
}

/* ---- damage of a single chunk ------------------------------------------------------------------------ */

/* Whether frames need the damaged chunk of the current event, whose header is intact. Readers pass over
 * chunks of unknown types anyway. */
static int is_needed(const fvv_frames *f) {
  const uint16_t id = f->event.chunk.track;
  if (f->place == FVV_PLACE_UNKNOWN || has_track(&f->left_out, id)) return 0;
  const fvv_track *track = f->configuration ? fvv_configuration_track(f->configuration, id) : NULL;
  return !track || is_of_frames(track);
}

static fvv_status take_damage(fvv_frames *f, fvv_frames_event *out) {
  const fvv_event *event = &f->event;
  /* A chunk that is there and breaks a rule of its block. Where one is missing, the digest says of which. */
  const fvv_place of = fvv_chunk_place(event->diagnostic.chunk_type, 0);
  if (f->block_open && (of == FVV_PLACE_CONFIGURATION || of == FVV_PLACE_UNKNOWN) &&
      event->diagnostic.status == FVV_ERROR_INVALID && event->diagnostic.issue != FVV_ISSUE_CONTINUITY)
    f->block_bad = 1;
  const int was_lost = f->lost, is_spared = f->is_listed && f->in_group && !is_needed(f);
  report_damage(f, &event->diagnostic, event->offset, event->skipped, out);
  if (!is_spared) return FVV_OK;
  f->lost = was_lost;
  out->whole = f->spared = 1;
  if (f->place == FVV_PLACE_UNKNOWN) return FVV_OK;
  if (!f->lost) pass_over_chunk(f);
  return has_track(&f->hurt, event->chunk.track)
             ? FVV_OK
             : fvv_bytes_append(&f->hurt, &event->chunk.track, sizeof event->chunk.track);
}

/* After damage that was said to cost no frame the reader found that more is missing, which it does not
 * report: for it the group was damaged already. */
static void report_more_damage(fvv_frames *f, fvv_frames_event *out) {
  fvv_diagnostic why = {0};
  (void)fvv_fail(&why, FVV_ERROR_DAMAGED, FVV_ISSUE_CONTINUITY, f->event.chunk.type, f->event.offset,
                 "after a damaged chunk others are missing or repeated");
  report_damage(f, &why, f->event.offset, 0, out);
}

/* ---- groups ----------------------------------------------------------------------------------------- */

static void begin_group(fvv_frames *f, fvv_frames_event *out) {
  const fvv_event *event = &f->event;
  f->in_group = 1;
  f->lost = !is_configured(f);
  f->spared = f->frame.is_over = 0;
  f->hurt.size = 0;
  if (f->lost) note_lacked_block(f);
  out->kind = FVV_FRAMES_GROUP;
  out->whole = !f->lost;
  out->offset = event->offset;
  out->time = event->chunk.time;
  if (event->chunk.size != FVV_GRUP_SIZE) return;
  out->end = fvv_get_i64(event->payload + FVV_GRUP_END);
  out->sequence = fvv_get_u32(event->payload + FVV_GRUP_SEQUENCE);
  out->configuration_crc = fvv_get_u32(event->payload + FVV_GRUP_CONFIGURATION_CRC);
}

static void end_group(fvv_frames *f, fvv_frames_event *out) {
  if (!f->in_group) return;
  f->in_group = 0;
  out->kind = FVV_FRAMES_GROUP_END;
  out->offset = f->event.offset;
  out->whole = !f->lost;
}

/* ---- events ----------------------------------------------------------------------------------------- */

/* Reports what the event that was read ends, one at a time: a block, a frame, a group without GEND. */
static fvv_status end_former(fvv_frames *f, fvv_frames_event *out) {
  const fvv_chunk_header *chunk = &f->event.chunk;
  if (f->place == FVV_PLACE_UNKNOWN) return FVV_OK;
  if (f->block_open && (f->place == FVV_PLACE_END || chunk->type == FVV_CHUNK_GROUP)) {
    const fvv_status status = close_block(f, 0, out);
    if (status < 0 || out->kind) return status;
  }
  if (f->place == FVV_PLACE_FRAME && (!chunk->track || chunk->time == f->frame.time)) return FVV_OK;
  if (f->frame.is_open) close_frame(f, out);
  if (!out->kind && f->place != FVV_PLACE_FRAME && chunk->type != FVV_CHUNK_GROUP_END) end_group(f, out);
  if (!out->kind) recall_block(f, out);
  return FVV_OK;
}

/* Reports the event that was read. */
static fvv_status work_off(fvv_frames *f, fvv_frames_event *out) {
  const fvv_event *event = &f->event;
  if (event->kind == FVV_EVENT_DAMAGE) return take_damage(f, out);
  if (event->kind == FVV_EVENT_END) {
    out->kind = FVV_FRAMES_END;
    out->offset = event->offset;
  }
  if (event->kind != FVV_EVENT_CHUNK) return FVV_OK;
  /* The digest of a block counts chunks of types that this version does not know, too. */
  if (f->place == FVV_PLACE_UNKNOWN && f->in_block)
    f->block_digest = fvv_header_chain(f->block_digest, &event->chunk);
  if (f->place == FVV_PLACE_CONFIGURATION) return add_configuration(f, out);
  if (is_frame_chunk(f)) return add_frame_chunk(f, out);
  if (event->chunk.type == FVV_CHUNK_GROUP) begin_group(f, out);
  if (event->chunk.type == FVV_CHUNK_GROUP_END) end_group(f, out);
  return FVV_OK;
}

static fvv_status step(fvv_frames *f, fvv_frames_event *out) {
  const fvv_status status = end_former(f, out);
  if (status < 0 || out->kind) return status;
  if (f->analyses && !f->is_reported) {
    f->is_reported = 1;
    out->kind = FVV_FRAMES_READ;
    out->offset = f->event.offset;
    return FVV_OK;
  }
  f->has_event = 0;
  return work_off(f, out);
}

/* Reads an event. At the end of the stream a block that is open may be complete: then it is reported first.
 */
static fvv_status read_event(fvv_frames *f, fvv_frames_event *out, fvv_diagnostic *diagnostic) {
  const fvv_status status = f->source ? f->source(f->source_user, &f->event, diagnostic)
                                      : fvv_reader_next(f->reader, &f->event, diagnostic);
  if (status == FVV_OK) {
    f->has_event = 1;
    f->is_reported = 0;
    f->place = FVV_PLACE_UNKNOWN;
    f->is_listed = !f->analyses && (f->source ? f->event.kind == FVV_EVENT_CHUNK || f->event.has_chunk
                                              : fvv_reader_lists_group(f->reader));
    /* A damaged chunk of a group that is listed ends the frame before it as an intact one does. */
    if (f->event.kind == FVV_EVENT_CHUNK || (f->event.kind == FVV_EVENT_DAMAGE && f->is_listed))
      f->place = fvv_chunk_place(f->event.chunk.type, f->event.chunk.flags);
    if (f->place == FVV_PLACE_FRAME || f->place == FVV_PLACE_GROUP) f->in_block = 0;
    f->is_foreign =
        !f->in_block && f->event.kind == FVV_EVENT_CHUNK && f->place == FVV_PLACE_UNKNOWN && makes_frame(f);
    if (f->is_foreign) f->place = FVV_PLACE_FRAME;
    if (f->event.kind != FVV_EVENT_CHUNK || f->event.group_intact || f->is_listed) return FVV_OK;
    if (f->spared && f->in_group && !f->lost && f->place != FVV_PLACE_CONFIGURATION)
      report_more_damage(f, out);
    f->lost = 1;
    return FVV_OK;
  }
  if (status == FVV_NEED_DATA || !f->is_finished || !f->block_open) return status;
  const fvv_status closed = close_block(f, 1, out);
  if (closed < 0 || !out->kind) return closed < 0 ? closed : status;
  fvv_diagnostic_clear(diagnostic);
  return FVV_OK;
}

fvv_status fvv_frames_next(fvv_frames *frames, fvv_frames_event *event, fvv_diagnostic *diagnostic) {
  fvv_frames *f = frames;
  fvv_diagnostic_clear(diagnostic);
  memset(event, 0, sizeof *event);
  fvv_status status = f->failed;
  while (status == FVV_OK && !event->kind)
    status = f->has_event ? step(f, event) : read_event(f, event, diagnostic);
  if (status != FVV_ERROR_MEMORY) return status;
  f->failed = status;
  return fvv_fail(diagnostic, status, 0, f->event.chunk.type, f->event.offset, "out of memory");
}
