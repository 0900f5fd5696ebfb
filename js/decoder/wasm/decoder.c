/* The stream as events: configuration, groups, whole frames, damage. */
#include "decoder.h"

#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "container/header.h"

FVVJS_EXPORT void *fvvjs_alloc(size_t size) {
  return malloc(size);
}
FVVJS_EXPORT void fvvjs_free(void *pointer) {
  free(pointer);
}

static void adopt(fvv_bytes *bytes, const fvv_allocator *allocator) {
  bytes->allocator = *allocator;
}

FVVJS_EXPORT fvvjs_decoder *fvvjs_create(void) {
  const fvv_allocator allocator = fvv_allocator_or_default(NULL);
  fvvjs_decoder *d = fvv_allocate_zeroed(&allocator, sizeof *d);
  if (!d) return NULL;
  d->allocator = allocator;
  fvv_limits_default(&d->limits);
  fvv_configuration_init(&d->building, &d->limits, &allocator);
  fvv_configuration_init(&d->complete, &d->limits, &allocator);
  fvv_bytes *const all[] = {&d->incoming.chunks, &d->incoming.payloads, &d->ready.chunks, &d->ready.payloads,
                            &d->tracks,          &d->pick.left_out,     &d->pick.payload};
  for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) adopt(all[i], &allocator);
  for (int i = 0; i < FVVJS_LISTS; i++) adopt(&d->lists[i], &allocator);
  return d;
}

static void free_frame(fvvjs_frame *frame) {
  fvv_bytes_free(&frame->chunks);
  fvv_bytes_free(&frame->payloads);
}

FVVJS_EXPORT void fvvjs_destroy(fvvjs_decoder *d) {
  if (!d) return;
  fvv_reader_destroy(d->reader);
  fvvjs_release_tracks(d);
  fvv_stream_close(d->index);
  fvv_configuration_free(&d->building);
  fvv_configuration_free(&d->complete);
  free_frame(&d->incoming);
  free_frame(&d->ready);
  fvv_bytes_free(&d->pick.left_out);
  fvv_bytes_free(&d->pick.payload);
  fvvjs_free_flat(d);
  const fvv_allocator allocator = d->allocator;
  fvv_release(&allocator, d, sizeof *d);
}

/* Before start and open. Numbers as in fvv_limits; 0 keeps the default. */
FVVJS_EXPORT void fvvjs_limits(fvvjs_decoder *d, uint32_t max_payload, uint32_t max_vertices,
                               uint32_t max_faces, uint32_t max_cameras, uint32_t max_tracks,
                               uint32_t max_dimension) {
  if (max_payload) d->limits.max_payload = max_payload;
  if (max_vertices) d->limits.max_vertices = max_vertices;
  if (max_faces) d->limits.max_faces = max_faces;
  if (max_cameras) d->limits.max_cameras = max_cameras;
  if (max_tracks) d->limits.max_tracks = max_tracks;
  if (max_dimension) d->limits.max_dimension = max_dimension;
  d->building.limits = d->complete.limits = d->limits;
}

FVVJS_EXPORT const fvv_diagnostic *fvvjs_diagnostic(const fvvjs_decoder *d) {
  return &d->diagnostic;
}
FVVJS_EXPORT const flat_event *fvvjs_event(const fvvjs_decoder *d) {
  return &d->about;
}

/* Bytes that are pushed from now on begin at offset. What was known of tracks is forgotten; a configuration
 * is kept when keep is not 0. */
FVVJS_EXPORT int32_t fvvjs_start(fvvjs_decoder *d, double offset, int keep) {
  fvv_reader_destroy(d->reader);
  d->reader = NULL;
  fvvjs_release_tracks(d);
  d->incoming.is_open = d->ready.is_open = d->has_event = d->lost = d->block_open = d->pick.on = 0;
  if (!keep) d->configuration = NULL;
  return fvv_reader_create(&d->limits, &d->allocator, (uint64_t)offset, &d->reader);
}

/* The same for who joins a stream: what is pushed is its file header, a configuration block and any group. */
FVVJS_EXPORT int32_t fvvjs_join(fvvjs_decoder *d) {
  const fvv_status status = fvvjs_start(d, 0, 0);
  return status < 0 ? status : fvv_reader_join(d->reader);
}

FVVJS_EXPORT int32_t fvvjs_push(fvvjs_decoder *d, const void *bytes, size_t size) {
  return d->reader ? fvv_reader_push(d->reader, bytes, size) : FVV_ERROR_STATE;
}
FVVJS_EXPORT void fvvjs_finish(fvvjs_decoder *d) {
  if (d->reader) fvv_reader_finish(d->reader);
}

static fvv_status append(fvvjs_frame *frame, const fvv_event *event) {
  if (!frame->is_open) {
    frame->is_open = frame->whole = 1;
    frame->time = event->chunk.time;
    frame->chunks.size = frame->payloads.size = 0;
  }
  /* Payloads stay aligned, as decoders of samples and meshes want them. */
  static const uint8_t padding[8] = {0};
  const fvvjs_chunk chunk = {event->chunk, frame->payloads.size, event->offset};
  const size_t size = (size_t)event->chunk.size;
  fvv_status status = fvv_bytes_append(&frame->chunks, &chunk, sizeof chunk);
  if (status == FVV_OK) status = fvv_bytes_append(&frame->payloads, event->payload, size);
  if (status == FVV_OK) status = fvv_bytes_append(&frame->payloads, padding, (8 - size % 8) % 8);
  return status;
}

/* 1: the frame that came in is whole, and is the ready one now. */
static int close_frame(fvvjs_decoder *d) {
  if (!d->incoming.is_open) return 0;
  const fvvjs_frame former = d->ready;
  const int whole = d->incoming.whole && !d->lost;
  d->incoming.is_open = 0;
  d->ready = d->incoming;
  d->incoming = former;
  d->incoming.is_open = 0;
  return whole;
}

static int has_chunk_of(const fvvjs_frame *frame, uint16_t track) {
  const fvvjs_chunk *chunks = (const fvvjs_chunk *)frame->chunks.data;
  for (size_t i = 0; i < frame->chunks.size / sizeof *chunks; i++)
    if (chunks[i].header.track == track && chunks[i].header.type != FVV_CHUNK_GROUP_TILES) return 1;
  return 0;
}

/* Whether nothing more can belong to the frame that comes in: a chunk of every track is there, and no track
 * has two at one time (clause 6.2). So it need not wait for the first chunk of the next frame. Environments
 * come at few times: with them it waits. */
static int is_complete(const fvvjs_decoder *d) {
  const fvv_configuration *c = d->configuration;
  const size_t chunks = d->incoming.chunks.size / sizeof(fvvjs_chunk);
  if (!c || chunks < c->track_count) return 0;
  for (size_t i = 0; i < c->track_count; i++)
    if (c->tracks[i].kind > FVV_TRACK_VISIBILITY || !has_chunk_of(&d->incoming, c->tracks[i].id)) return 0;
  return 1;
}

static int damage(fvvjs_decoder *d, const fvv_diagnostic *diagnostic, uint64_t offset, uint64_t skipped) {
  d->diagnostic = *diagnostic;
  d->about.offset = offset;
  d->about.skipped = skipped;
  d->incoming.whole = 0;
  d->lost = 1;
  return FVVJS_DAMAGE;
}

static int take_configuration(fvvjs_decoder *d, const fvv_event *event) {
  if (event->chunk.type == FVV_CHUNK_SCENE) {
    d->block_open = 1;
    d->block_bad = 0;
    d->block_offset = event->offset;
  }
  if (!d->block_open || d->block_bad) return FVVJS_NEED_DATA;
  fvv_diagnostic why = {0};
  const fvv_status status =
      fvv_configuration_add(&d->building, &event->chunk, event->payload, event->offset, &why);
  if (status >= 0) return FVVJS_NEED_DATA;
  d->block_bad = 1;
  return damage(d, &why, event->offset, 0);
}

/* A configuration block is judged when the first group behind it begins. */
static int close_block(fvvjs_decoder *d) {
  d->block_open = 0;
  if (d->block_bad) return FVVJS_NEED_DATA;
  fvv_diagnostic why = {0};
  if (fvv_configuration_complete(&d->building, d->block_offset, &why) < 0) {
    d->block_bad = 1;
    return damage(d, &why, d->block_offset, 0);
  }
  const fvv_configuration_builder former = d->complete;
  d->complete = d->building;
  d->building = former;
  d->configuration = &d->complete.view;
  fvvjs_release_tracks(d);
  return FVVJS_CONFIGURATION;
}

static int begin_group(fvvjs_decoder *d, const fvv_event *event) {
  d->incoming.is_open = 0;
  d->lost = d->block_bad || !d->configuration;
  d->about.offset = event->offset;
  d->about.start = event->chunk.time;
  if (event->chunk.size == FVV_GRUP_SIZE) {
    d->about.end = fvv_get_i64(event->payload + FVV_GRUP_END);
    d->about.sequence = fvv_get_u32(event->payload + FVV_GRUP_SEQUENCE);
    d->about.configuration = fvv_get_u32(event->payload + FVV_GRUP_CONFIGURATION_CRC);
  }
  fvvjs_begin_group(d);
  return FVVJS_GROUP;
}

/* Works on the event that was read. Leaves it in place when something has to be told first. */
static int take(fvvjs_decoder *d) {
  const fvv_event *event = &d->event;
  const int32_t place = fvv_chunk_place(event->chunk.type);
  if (event->kind == FVV_EVENT_CHUNK && place == FVV_PLACE_GROUP && d->block_open) return close_block(d);
  /* Chunks that this version does not know stand in the middle of frames, too. */
  if (event->kind == FVV_EVENT_CHUNK && place == FVV_PLACE_UNKNOWN) {
    if (!event->group_intact) d->incoming.whole = 0;
    d->has_event = 0;
    return FVVJS_NEED_DATA;
  }
  const int same = place == FVV_PLACE_FRAME && event->chunk.track && d->incoming.is_open &&
                   d->incoming.time == event->chunk.time;
  if (event->kind == FVV_EVENT_CHUNK && d->incoming.is_open && !same) {
    if (!event->group_intact) d->incoming.whole = 0;
    if (close_frame(d)) return FVVJS_FRAME;
  }
  d->has_event = 0;
  switch (event->kind) {
  case FVV_EVENT_DAMAGE:
    return damage(d, &event->diagnostic, event->offset, event->skipped);
  case FVV_EVENT_END:
    return FVVJS_END;
  case FVV_EVENT_CHUNK:
    break;
  default:
    return FVVJS_NEED_DATA;
  }
  if (place == FVV_PLACE_CONFIGURATION) return take_configuration(d, event);
  if (event->chunk.type == FVV_CHUNK_GROUP) return begin_group(d, event);
  if (place != FVV_PLACE_FRAME || !event->chunk.track || d->lost) return FVVJS_NEED_DATA;
  const fvv_status status = append(&d->incoming, event);
  if (!event->group_intact) d->incoming.whole = 0;
  if (status < 0) return status;
  return is_complete(d) && close_frame(d) ? FVVJS_FRAME : FVVJS_NEED_DATA;
}

/* Call until FVVJS_NEED_DATA or an error, which is final. */
FVVJS_EXPORT int32_t fvvjs_next(fvvjs_decoder *d) {
  if (!d->reader) return FVV_ERROR_STATE;
  for (;;) {
    if (!d->has_event) {
      fvv_diagnostic why = {0};
      const fvv_status status =
          d->pick.on ? fvvjs_next_picked(d, &d->event, &why) : fvv_reader_next(d->reader, &d->event, &why);
      if (status == FVV_NEED_DATA) return FVVJS_NEED_DATA;
      if (status == FVV_END) return FVVJS_DONE;
      if (status < 0) {
        d->diagnostic = why;
        return status;
      }
      d->has_event = 1;
    }
    const int answer = take(d);
    if (answer < 0) {
      memset(&d->diagnostic, 0, sizeof d->diagnostic);
      return fvv_fail(&d->diagnostic, answer, 0, d->event.chunk.type, d->event.offset, "%s",
                      fvv_status_text(answer));
    }
    if (answer != FVVJS_NEED_DATA) return answer;
  }
}
