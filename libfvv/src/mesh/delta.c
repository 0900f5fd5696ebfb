/* Payloads of delta frames, read and written (clauses 8.7, 8.9). */
#include "mesh/delta.h"

#include <string.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "mesh/mesh.h"
#include "mesh/normals.h"
#include "mesh/patched.h"

static void turn_normals(fvv_mesh_sequence *s) {
  const unsigned bits = s->mesh.normal_bits;
  fvv_normals_of_faces(&s->mesh, NULL, s->face_normals);
  for (size_t v = 0; v < s->mesh.vertex_count; v++) {
    double normal[3];
    uint32_t *index = s->mesh.normals + 2 * v;
    memcpy(index, s->sent_normals + 2 * v, 2 * sizeof *index);
    fvv_octahedral_vector(bits, index, normal);
    if (fvv_normal_turn(s->base_normals + 3 * v, s->face_normals + 3 * v, normal))
      fvv_octahedral_index(bits, normal, index);
  }
}

/* The frame is done: positions in canonical order, normals turned with them (clause 8.13), residuals become
 * those of the frame before. */
static void end_frame(fvv_mesh_sequence *s) {
  const int32_t half = 1 << (FVV_DELTA_FRACTION_BITS - 1);
  const int32_t *from = s->place;
  for (uint32_t i = 0; i < s->mesh.vertex_count; i++, from += 3) {
    int32_t *to = s->mesh.lattice + 3 * (size_t)s->hierarchy.order[i];
    for (int a = 0; a < 3; a++) to[a] = (int32_t)fvv_shift_right(from[a] + half, FVV_DELTA_FRACTION_BITS);
  }
  if (s->sent_normals) turn_normals(s);
  fvv_delta_residuals *const former = s->before;
  s->before = s->now;
  s->now = former;
  s->frame++;
}

/* Levels of delta payloads -> frames of a sequence (clause 8.8, 8.9). Work and memory are bounded by the key
 * mesh, whatever the bytes say. */

/* Exp-Golomb: the number of digits after the leading one, then the digits. A magnitude of 30 digits or more
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
  fvv_delta_model *const model = &s->models[fvv_delta_model_of(&s->hierarchy, level)];
  fvv_status status = FVV_OK;
  for (uint32_t i = fvv_delta_level_begin(s, level); i < end && status == FVV_OK; i++) {
    status = decode_vertex(s, &d, model, i, coded->step, rounding);
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

/* The delta_mesh() at an offset. */
static fvv_status decode_levels(fvv_mesh_sequence *s, const uint8_t *payload, size_t size, size_t at,
                                fvv_diagnostic *diagnostic) {
  fvv_delta_frame frame;
  fvv_status status = fvv_delta_read_levels(s, payload, size, at, &frame, diagnostic);
  for (uint32_t k = 0; k < s->hierarchy.level_count && status == FVV_OK; k++)
    status = decode_level(s, k, &frame.level[k], payload, diagnostic);
  if (status == FVV_OK) end_frame(s);
  return status;
}

static fvv_status decode_patched(fvv_mesh_sequence *s, const uint8_t *payload, size_t size,
                                 const fvv_mesh_header *header, const fvv_limits *limits,
                                 fvv_diagnostic *diagnostic) {
  fvv_patched_parts parts;
  fvv_status status = fvv_patched_split(payload + FVV_MESH_SIZE, header, limits, &parts, diagnostic);
  if (status == FVV_OK) status = fvv_delta_check_number(s, payload, size, parts.delta, diagnostic);
  if (status != FVV_OK) return status;
  fvv_patched_change change = {0};
  status = fvv_patched_read(s, payload, header, &parts, limits, &change, diagnostic);
  if (status == FVV_OK) status = decode_levels(s, payload, size, parts.delta, diagnostic);
  if (status == FVV_OK) status = fvv_patched_merge(s, &change, diagnostic);
  fvv_patched_change_free(&change, &s->allocator);
  return status;
}

static fvv_status decode(fvv_mesh_sequence *s, const uint8_t *payload, size_t size,
                         fvv_diagnostic *diagnostic) {
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_vertices = limits.max_faces = UINT32_MAX; /* the caller has applied his own */
  fvv_mesh_header header;
  const fvv_status status = fvv_delta_read_header(s, payload, size, &limits, &header, diagnostic);
  if (status != FVV_OK) return status;
  fvv_patched_clear(s);
  return header.profile == FVV_MESH_PATCHED ? decode_patched(s, payload, size, &header, &limits, diagnostic)
                                            : decode_levels(s, payload, size, FVV_MESH_SIZE, diagnostic);
}

fvv_status fvv_mesh_sequence_decode(fvv_mesh_sequence *sequence, const uint8_t *payload, size_t size,
                                    fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_mesh_sequence *s = sequence;
  if (s->broken)
    return fvv_fail(diagnostic, FVV_ERROR_STATE, 0, FVV_CHUNK_MESH, 0,
                    "a frame of this sequence was wrong: what follows cannot be decoded up to the next key");
  const fvv_status status = decode(s, payload, size, diagnostic);
  if (status != FVV_OK) {
    s->broken = 1;
    return status;
  }
  return FVV_OK;
}

/* Frames of a sequence -> delta payloads, closed loop: after each frame the encoder holds what a decoder will
 * hold, and predicts from that. */

void fvv_mesh_delta_options_default(fvv_mesh_delta_options *options) {
  memset(options, 0, sizeof *options);
  options->struct_size = sizeof *options;
  options->max_error = 1;
}

static void encode_magnitude(fvv_range_encoder *e, fvv_delta_model *model, uint32_t around, uint32_t value) {
  int digits = 0;
  while (value >> digits > 1) digits++;
  for (int i = 0; i < digits; i++) fvv_range_encode(e, &model->more[around][i], 1);
  fvv_range_encode(e, &model->more[around][digits], 0);
  for (int i = digits - 1; i >= 0; i--) {
    const int digit = value >> i & 1;
    if (i == digits - 1)
      fvv_range_encode(e, &model->first[digits], digit);
    else
      fvv_range_encode_even(e, digit);
  }
}

/* How wide the range of states is that round to positions within the error: those from half of it below
 * the one that is wanted to less than half above. */
static int64_t width_of(uint32_t max_error) {
  return (2 * (int64_t)max_error + 1) * (1 << FVV_DELTA_FRACTION_BITS);
}

/* The residual: 0 within the width, else that which leaves least, the smaller where there is a choice. One
 * that would lead outside the lattice is one step shorter: there the error may be a whole step. */
static int64_t quantise(int64_t difference, int64_t step, int64_t width, int64_t predicted) {
  if (difference > -width / 2 && difference <= width / 2) return 0;
  const int64_t magnitude = ((difference < 0 ? -difference : difference) + (step - 1) / 2) / step;
  int64_t residual = difference < 0 ? -magnitude : magnitude;
  const int64_t to = predicted + residual * step;
  if (to > FVV_DELTA_STATE_MAX) residual--;
  if (to < -FVV_DELTA_STATE_MAX) residual++;
  return residual;
}

/* 1 when the vertex has a residual that is not 0. wanted NULL: it goes where it is predicted. */
static int encode_vertex(fvv_mesh_sequence *s, fvv_range_encoder *e, fvv_delta_model *model, uint32_t i,
                         const fvv_delta_level *coded, const int32_t *wanted) {
  int32_t to[3];
  fvv_delta_predict(s, i, fvv_delta_rounding(coded->step), to);
  fvv_delta_context context = fvv_delta_look_around(s, i);
  fvv_delta_residuals now = FVV_DELTA_NO_RESIDUALS;
  for (int a = 0; a < 3; a++) {
    const uint32_t around = fvv_delta_around_class(&context, a);
    int64_t residual = 0;
    if (wanted) {
      const int64_t asked = (int64_t)wanted[a] * (1 << FVV_DELTA_FRACTION_BITS);
      residual = quantise(asked - to[a], coded->step, coded->width, to[a]);
    }
    fvv_range_encode(e, fvv_delta_some(model, &context, a, around), residual != 0);
    if (residual) {
      const uint32_t magnitude = (uint32_t)(residual < 0 ? -residual : residual);
      encode_magnitude(e, model, around, magnitude);
      fvv_range_encode(e, fvv_delta_negative(model, &context, a), residual < 0);
      to[a] = (int32_t)(to[a] + residual * coded->step);
      fvv_delta_note(&context, a, magnitude, residual < 0, &now);
    }
    fvv_delta_move(s, i, a, to[a]);
  }
  s->now[i] = now;
  return now != FVV_DELTA_NO_RESIDUALS;
}

/* Appends the bytes of a level, or none when no vertex of it has a residual: then its model learns nothing,
 * as in the decoder. */
static fvv_status encode_level(fvv_mesh_sequence *s, uint32_t level, fvv_delta_level *coded,
                               const int32_t *lattice, const uint8_t *used, fvv_bytes *data) {
  const size_t begin = data->size;
  fvv_delta_model *const model = &s->models[fvv_delta_model_of(&s->hierarchy, level)];
  const fvv_delta_model former = *model;
  fvv_range_encoder e;
  fvv_range_encoder_init(&e, data);
  int some = 0;
  const uint32_t end = s->hierarchy.level_end[level];
  for (uint32_t i = fvv_delta_level_begin(s, level); i < end; i++) {
    const size_t v = s->hierarchy.order[i];
    some |= encode_vertex(s, &e, model, i, coded, !used || used[v] ? lattice + 3 * v : NULL);
  }
  const fvv_status status = fvv_range_encoder_finish(&e);
  if (status != FVV_OK) return status;
  if (!some) {
    data->size = begin;
    *model = former;
  }
  coded->size = data->size - begin;
  return FVV_OK;
}

/* Steps of three quarters of the width: a vertex that left it comes back near to its middle, and stays there
 * for longer. */
static void choose_steps(const fvv_mesh_sequence *s, const fvv_mesh_delta_options *options,
                         fvv_delta_frame *frame) {
  const int64_t width = width_of(options->max_error);
  for (uint32_t k = 0; k < s->hierarchy.level_count; k++) {
    frame->level[k].width = width;
    frame->level[k].step = (uint32_t)(options->max_error ? width / 4 * 3 : width);
  }
}

fvv_status fvv_delta_put_header(const fvv_mesh_sequence *s, uint8_t profile, uint32_t vertices,
                                uint32_t faces, fvv_bytes *payload) {
  uint8_t header[FVV_MESH_SIZE] = {0};
  header[FVV_MESH_PROFILE] = profile;
  header[FVV_MESH_ATTRIBUTES] = fvv_mesh_attributes(&s->mesh);
  header[FVV_MESH_TEXTURE_BITS] = s->mesh.texture_bits;
  header[FVV_MESH_NORMAL_BITS] = s->mesh.normal_bits;
  fvv_put_u32(header + FVV_MESH_VERTEX_COUNT, vertices);
  fvv_put_u32(header + FVV_MESH_FACE_COUNT, faces);
  return fvv_bytes_append(payload, header, sizeof header);
}

static fvv_status put_levels(const fvv_mesh_sequence *s, const fvv_delta_frame *frame, const fvv_bytes *data,
                             fvv_bytes *payload) {
  fvv_status status = fvv_bytes_append_uleb(payload, (uint64_t)s->frame + 1);
  if (status == FVV_OK) status = fvv_bytes_append_uleb(payload, s->hierarchy.level_count);
  for (uint32_t k = 0; k < s->hierarchy.level_count && status == FVV_OK; k++) {
    status = fvv_bytes_append_uleb(payload, frame->level[k].step);
    if (status == FVV_OK) status = fvv_bytes_append_uleb(payload, frame->level[k].size);
  }
  return status == FVV_OK ? fvv_bytes_append(payload, data->data, data->size) : status;
}

static fvv_mesh_delta_options options_or_default(const fvv_mesh_delta_options *options) {
  fvv_mesh_delta_options chosen;
  fvv_mesh_delta_options_default(&chosen);
  if (options)
    memcpy(&chosen, options, options->struct_size < sizeof chosen ? options->struct_size : sizeof chosen);
  return chosen;
}

fvv_status fvv_delta_check_input(const fvv_mesh_sequence *s, const int32_t *lattice,
                                 const fvv_mesh_delta_options *options, fvv_diagnostic *diagnostic) {
  const fvv_mesh_delta_options chosen = options_or_default(options);
  if (s->broken)
    return fvv_fail(diagnostic, FVV_ERROR_STATE, 0, 0, 0,
                    "a frame of this sequence was wrong: nothing can follow it");
  if (chosen.max_error > FVV_DELTA_ERROR_MAX)
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "an error of %lu steps is allowed, at most %d",
                    (unsigned long)chosen.max_error, FVV_DELTA_ERROR_MAX);
  for (size_t i = 0; i < 3 * (size_t)s->mesh.vertex_count; i++)
    if (lattice[i] > FVV_LATTICE_MAX || lattice[i] < -FVV_LATTICE_MAX)
      return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_MESH_LATTICE, 0, 0,
                      "vertex %zu: %c index %ld is outside +-2^28", i / 3, "xyz"[i % 3], (long)lattice[i]);
  return FVV_OK;
}

fvv_status fvv_delta_put_levels(fvv_mesh_sequence *s, const int32_t *lattice, const uint8_t *used,
                                const fvv_mesh_delta_options *options, fvv_bytes *payload,
                                fvv_diagnostic *diagnostic) {
  const fvv_mesh_delta_options chosen = options_or_default(options);
  fvv_delta_frame frame;
  choose_steps(s, &chosen, &frame);
  fvv_bytes data = {NULL, 0, 0, s->allocator};
  fvv_status status = FVV_OK;
  for (uint32_t k = 0; k < s->hierarchy.level_count && status == FVV_OK; k++)
    status = encode_level(s, k, &frame.level[k], lattice, used, &data);
  if (status == FVV_OK) status = put_levels(s, &frame, &data, payload);
  fvv_bytes_free(&data);
  if (status != FVV_OK) {
    s->broken = 1;
    return fvv_fail(diagnostic, status, 0, 0, 0, "no memory for a delta frame of %lu vertices",
                    (unsigned long)s->mesh.vertex_count);
  }
  end_frame(s);
  return FVV_OK;
}

fvv_status fvv_mesh_sequence_encode(fvv_mesh_sequence *sequence, const int32_t *lattice,
                                    const fvv_mesh_delta_options *options, fvv_bytes *payload,
                                    fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_mesh_sequence *s = sequence;
  if (!payload->allocator.resize) payload->allocator = s->allocator;
  payload->size = 0;
  fvv_status status = fvv_delta_check_input(s, lattice, options, diagnostic);
  if (status != FVV_OK) return status;
  if (fvv_delta_put_header(s, FVV_MESH_DELTA, s->mesh.vertex_count, s->mesh.face_count, payload) != FVV_OK)
    return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory for a delta frame of %lu vertices",
                    (unsigned long)s->mesh.vertex_count);
  fvv_patched_clear(s);
  return fvv_delta_put_levels(s, lattice, NULL, options, payload, diagnostic);
}
