/* Levels of delta payloads -> frames of a sequence (clause 8.8, 8.9). Work and memory are bounded by the key
 * mesh, whatever the bytes say. */
#include "base/diagnostic.h"
#include "base/layout.h"
#include "mesh/delta_payload.h"

/* Exp-Golomb: the number of digits behind the leading one, then the digits. A magnitude of 30 digits or more
 * is none: 0. */
static uint32_t decode_magnitude(fvv_range_decoder *d, fvv_delta_model *model, uint32_t around) {
  int digits = 0;
  while (fvv_range_decode(d, &model->more[around][digits]))
    if (++digits == FVV_DELTA_MAGNITUDE_BITS) return 0;
  uint32_t value = 1;
  for (int i = 0; i < digits; i++)
    value =
        value << 1 | (uint32_t)(i ? fvv_range_decode_even(d) : fvv_range_decode(d, &model->first[digits]));
  return value;
}

static inline fvv_status decode_vertex(fvv_mesh_sequence *s, fvv_range_decoder *d, fvv_delta_model *model,
                                       uint32_t i, uint32_t step, int rounding) {
  int32_t to[3];
  fvv_delta_predict(s, i, rounding, to);
  fvv_delta_context context = fvv_delta_look_around(s, i);
  fvv_delta_residuals now = FVV_DELTA_NO_RESIDUALS;
  for (int a = 0; a < 3; a++) {
    const uint32_t around = fvv_delta_around_class(&context, a);
    if (fvv_range_decode(d, fvv_delta_some(model, &context, a, around))) {
      const uint32_t magnitude = decode_magnitude(d, model, around);
      if (!magnitude) return FVV_ERROR_DAMAGED;
      const int negative = fvv_range_decode(d, fvv_delta_negative(model, &context, a));
      const int64_t change = (int64_t)magnitude * step, x = negative ? to[a] - change : to[a] + change;
      if (x > FVV_DELTA_STATE_MAX || x < -FVV_DELTA_STATE_MAX) return FVV_ERROR_INVALID;
      to[a] = (int32_t)x;
      fvv_delta_note(&context, a, magnitude, negative, &now);
    }
    fvv_delta_move(s, i, a, to[a]);
  }
  s->now[i] = now;
  return FVV_OK;
}

static fvv_status decode_level(fvv_mesh_sequence *s, uint32_t level, const fvv_delta_level *coded,
                               const uint8_t *payload, fvv_diagnostic *diagnostic) {
  if (!coded->size) {
    fvv_delta_follow(s, level, coded->step);
    return FVV_OK;
  }
  fvv_range_decoder d;
  fvv_range_decoder_init(&d, payload + coded->offset, coded->size);
  const uint32_t end = s->hierarchy.level_end[level];
  const int rounding = fvv_delta_rounding(coded->step);
  fvv_status status = FVV_OK;
  for (uint32_t i = fvv_delta_level_begin(s, level); i < end && status == FVV_OK; i++) {
    status = decode_vertex(s, &d, &s->models[level], i, coded->step, rounding);
    if (fvv_range_decoder_failed(&d)) break;
  }
  if (fvv_range_decoder_failed(&d) || status == FVV_ERROR_DAMAGED ||
      (status == FVV_OK && !fvv_range_decoder_finished(&d)))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DELTA_STREAM, FVV_CHUNK_MESH, coded->offset,
                    "the %zu bytes of level %lu do not end with its last vertex", coded->size,
                    (unsigned long)level);
  if (status == FVV_OK) return status;
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_MESH_LATTICE, FVV_CHUNK_MESH, coded->offset,
                  "level %lu: a vertex moves outside +-2^28", (unsigned long)level);
}

static fvv_status decode(fvv_mesh_sequence *s, const uint8_t *payload, size_t size, uint32_t levels,
                         fvv_diagnostic *diagnostic) {
  fvv_delta_frame frame;
  fvv_status status = fvv_delta_read_header(s, payload, size, &frame, diagnostic);
  for (uint32_t k = 0; k < s->hierarchy.level_count && status == FVV_OK; k++) {
    if (k < levels)
      status = decode_level(s, k, &frame.level[k], payload, diagnostic);
    else
      fvv_delta_follow(s, k, 1); /* not rounded: nothing would mend it */
  }
  return status;
}

fvv_status fvv_mesh_sequence_decode(fvv_mesh_sequence *sequence, const uint8_t *payload, size_t size,
                                    uint32_t levels, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_mesh_sequence *s = sequence;
  if (levels > s->hierarchy.level_count) levels = s->hierarchy.level_count;
  if (s->broken)
    return fvv_fail(diagnostic, FVV_ERROR_STATE, 0, FVV_CHUNK_MESH, 0,
                    "a frame of this sequence was wrong: what follows cannot be decoded up to the next key");
  if (levels > s->exact_levels)
    return fvv_fail(diagnostic, FVV_ERROR_STATE, 0, FVV_CHUNK_MESH, 0,
                    "%lu levels are asked for, but of a former frame only %lu were decoded",
                    (unsigned long)levels, (unsigned long)s->exact_levels);
  const fvv_status status = decode(s, payload, size, levels, diagnostic);
  if (status != FVV_OK) {
    s->broken = 1;
    return status;
  }
  s->exact_levels = levels;
  fvv_delta_end_frame(s);
  return FVV_OK;
}
