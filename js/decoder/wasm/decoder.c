/* The stream as events: what fvv_frames reports, for JavaScript. */
#include "decoder.h"

#include <stdlib.h>
#include <string.h>

FVVJS_EXPORT void *fvvjs_alloc(size_t size) {
  return malloc(size);
}
FVVJS_EXPORT void fvvjs_free(void *pointer) {
  free(pointer);
}

FVVJS_EXPORT fvvjs_decoder *fvvjs_create(void) {
  const fvv_allocator allocator = fvv_allocator_or_default(NULL);
  fvvjs_decoder *d = fvv_allocate_zeroed(&allocator, sizeof *d);
  if (!d) return NULL;
  d->allocator = allocator;
  fvv_limits_default(&d->limits);
  d->tracks.allocator = d->left_out.allocator = d->pick.payload.allocator = allocator;
  for (int i = 0; i < FVVJS_LISTS; i++) d->lists[i].allocator = allocator;
  return d;
}

FVVJS_EXPORT void fvvjs_destroy(fvvjs_decoder *d) {
  if (!d) return;
  fvv_frames_destroy(d->frames);
  fvvjs_release_tracks(d);
  fvv_stream_close(d->index);
  fvv_bytes_free(&d->left_out);
  fvv_bytes_free(&d->pick.payload);
  for (int i = 0; i < FVVJS_LISTS; i++) fvv_bytes_free(&d->lists[i]);
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
}

FVVJS_EXPORT const fvv_diagnostic *fvvjs_diagnostic(const fvvjs_decoder *d) {
  return &d->diagnostic;
}
/* NULL: there is none yet. Valid until the next call of fvvjs_next or fvvjs_play. */
FVVJS_EXPORT const fvv_configuration *fvvjs_configuration(const fvvjs_decoder *d) {
  return d->configuration;
}
/* What fvvjs_next reported last. */
FVVJS_EXPORT const fvv_frames_event *fvvjs_event(const fvvjs_decoder *d) {
  return &d->event;
}

fvv_status fvvjs_start_at(fvvjs_decoder *d, uint64_t offset, const fvv_configuration *configuration) {
  fvvjs_release_tracks(d);
  d->configuration = configuration;
  d->event.chunk_count = 0;
  d->pick.on = 0;
  if (!d->frames) {
    const fvv_status status = fvv_frames_create(NULL, &d->limits, &d->allocator, &d->frames);
    if (status < 0) return status;
  }
  return fvv_frames_seek(d->frames, offset, configuration);
}

/* Bytes that are pushed from now on begin at offset. What was known of tracks is forgotten; a configuration
 * is kept when keep is not 0. */
FVVJS_EXPORT int32_t fvvjs_start(fvvjs_decoder *d, double offset, int keep) {
  return fvvjs_start_at(d, (uint64_t)offset, keep ? d->configuration : NULL);
}

/* The same for a stream that is joined late: what is pushed is its file header, a configuration block and any
 * group. */
FVVJS_EXPORT int32_t fvvjs_join(fvvjs_decoder *d) {
  const fvv_status status = fvvjs_start_at(d, 0, NULL);
  return status < 0 ? status : fvv_frames_join(d->frames);
}

FVVJS_EXPORT int32_t fvvjs_push(fvvjs_decoder *d, const void *bytes, size_t size) {
  return d->frames ? fvv_frames_push(d->frames, bytes, size) : FVV_ERROR_STATE;
}
FVVJS_EXPORT void fvvjs_finish(fvvjs_decoder *d) {
  if (d->frames) fvv_frames_finish(d->frames);
}

/* Tracks are left out as by fvv_frames_leave_out, one by one, also of a group of the index. */
FVVJS_EXPORT int32_t fvvjs_leave_out_none(fvvjs_decoder *d) {
  d->left_out.size = 0;
  return d->frames ? fvv_frames_leave_out(d->frames, NULL, 0) : FVV_ERROR_STATE;
}
FVVJS_EXPORT int32_t fvvjs_leave_out(fvvjs_decoder *d, uint32_t track) {
  const uint16_t id = (uint16_t)track;
  if (!d->frames) return FVV_ERROR_STATE;
  const fvv_status status = fvv_bytes_append(&d->left_out, &id, sizeof id);
  if (status < 0) return status;
  return fvv_frames_leave_out(d->frames, (const uint16_t *)d->left_out.data, d->left_out.size / sizeof id);
}

/* Call until FVVJS_NEED_DATA or an error, which is final. */
FVVJS_EXPORT int32_t fvvjs_next(fvvjs_decoder *d) {
  if (!d->frames) return FVV_ERROR_STATE;
  fvv_frames_event *event = &d->event;
  fvv_status status;
  do status = fvv_frames_next(d->frames, event, &d->diagnostic);
  while (status == FVV_OK && event->kind > FVV_FRAMES_END && event->kind != FVV_FRAMES_BETWEEN);
  if (status != FVV_OK)
    return status == FVV_NEED_DATA ? FVVJS_NEED_DATA : status == FVV_END ? FVVJS_DONE : status;
  if (event->kind == FVV_FRAMES_CONFIGURATION) {
    d->configuration = event->configuration;
    fvvjs_release_tracks(d);
  }
  if (event->kind == FVV_FRAMES_GROUP) {
    fvvjs_begin_group(d);
    d->group_end = event->end;
  }
  if (event->kind == FVV_FRAMES_DAMAGE) d->diagnostic = event->diagnostic;
  return event->kind == FVV_FRAMES_BETWEEN ? FVVJS_BETWEEN : (int32_t)event->kind;
}
