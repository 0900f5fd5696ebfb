/* Cameras of frames by number. A CALB chunk is decoded from the key of its group on; where the track stands
 * is kept, so that frames in order cost one step each. */
#include "base/diagnostic.h"
#include "base/layout.h"
#include "stream/stream.h"

void fvv_stream_release_cameras(fvv_stream *stream) {
  fvv_calibration_destroy(stream->calibration);
  stream->calibration = NULL;
  stream->calibration_chunk = 0;
}

static int is_calibration(const fvv_chunk_info *chunk) {
  return chunk->type == FVV_CHUNK_CALIBRATION;
}

/* Decodes all from the key to wanted that was not decoded yet. first: the group's list, in which wanted
 * stands. */
static fvv_status follow(fvv_stream *s, const fvv_chunk_info *first, const fvv_chunk_info *wanted,
                         fvv_diagnostic *diagnostic) {
  const fvv_chunk_info *next = wanted;
  while (next > first && next->offset != s->calibration_chunk &&
         !(is_calibration(next) && next->flags & FVV_FLAG_KEY))
    next--;
  if (next->offset == s->calibration_chunk) next++;
  s->calibration_chunk = 0;
  for (; next <= wanted; next++) {
    if (!is_calibration(next)) continue;
    const uint8_t *payload;
    fvv_status status = fvv_file_read_chunk(s->file, next, &payload, diagnostic);
    if (status != FVV_OK) return status;
    status = fvv_calibration_decode(s->calibration, payload, (size_t)next->size, next->flags & FVV_FLAG_KEY,
                                    diagnostic);
    if (status != FVV_OK) {
      fvv_diagnostic_rebase(diagnostic, next->offset + FVV_CHUNK_HEADER_SIZE, FVV_CHUNK_CALIBRATION);
      return status;
    }
  }
  s->calibration_chunk = wanted->offset;
  return FVV_OK;
}

/* The calibration of a configuration begins anew with every one that is loaded, which releases it. */
static fvv_status prepare(fvv_stream *s, const fvv_configuration *configuration, fvv_diagnostic *diagnostic) {
  if (s->calibration) return FVV_OK;
  const fvv_status status = fvv_calibration_create(configuration->cameras, configuration->camera_count,
                                                   &s->allocator, &s->calibration);
  return status == FVV_OK ? status : fvv_fail(diagnostic, status, 0, 0, 0, "out of memory");
}

fvv_status fvv_stream_calibration(fvv_stream *stream, const fvv_frame_chunks *found,
                                  const fvv_configuration *configuration, const fvv_calibration **calibration,
                                  fvv_diagnostic *diagnostic) {
  for (size_t i = 0; i < found->count; i++) {
    if (!is_calibration(&found->chunks[i])) continue;
    fvv_status status = prepare(stream, configuration, diagnostic);
    if (status == FVV_OK) status = follow(stream, found->first, &found->chunks[i], diagnostic);
    if (status == FVV_OK) *calibration = stream->calibration;
    return status;
  }
  return FVV_END;
}

fvv_status fvv_stream_camera(fvv_stream *stream, size_t frame, uint16_t id, fvv_camera *camera,
                             fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_frame_chunks found;
  fvv_status status = fvv_stream_find(stream, frame, &found, diagnostic);
  if (status < 0) return status;
  const fvv_configuration *configuration;
  status = fvv_stream_configuration(stream, found.group, &configuration, diagnostic);
  if (status < 0) return status;
  const fvv_camera *constant = fvv_configuration_camera(configuration, id);
  if (!constant) return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "camera %u is not described", id);
  if (!(constant->flags & FVV_CAMERA_MOVES)) {
    *camera = *constant;
    return FVV_OK;
  }
  const fvv_calibration *calibration;
  status = fvv_stream_calibration(stream, &found, configuration, &calibration, diagnostic);
  return status == FVV_OK ? fvv_calibration_camera(calibration, id, camera) : status;
}
