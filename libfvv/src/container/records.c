/* The two records that the container itself must understand: SCEN and TRAK (clause 5). */
#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/limits.h"
#include "base/text.h"
#include "fvv/container.h"

#include <math.h>

static fvv_status scene_check(const fvv_scene *scene, fvv_status status, fvv_diagnostic *diagnostic) {
  const uint32_t type = FVV_CHUNK_SCENE;
  if (!scene->time_base.numerator || !scene->time_base.denominator)
    return fvv_fail(diagnostic, status, FVV_ISSUE_TIME_BASE, type, FVV_SCEN_TIME_BASE_NUMERATOR,
                    "time base is %u/%u seconds per tick, expected two positive numbers",
                    scene->time_base.numerator, scene->time_base.denominator);
  if (scene->frame_duration <= 0)
    return fvv_fail(diagnostic, status, FVV_ISSUE_TIME_BASE, type, FVV_SCEN_FRAME_DURATION,
                    "frame duration is %lld ticks, expected a positive number",
                    (long long)scene->frame_duration);
  if (!(scene->lattice_step > 0) || !isfinite(scene->lattice_step))
    return fvv_fail(diagnostic, status, FVV_ISSUE_LATTICE, type, FVV_SCEN_LATTICE_STEP,
                    "lattice step is %g, expected a positive number of metres", scene->lattice_step);
  for (int i = 0; i < 3; i++)
    if (!isfinite(fabs(scene->lattice_origin[i]) + scene->lattice_step * FVV_LATTICE_MAX))
      return fvv_fail(diagnostic, status, FVV_ISSUE_LATTICE, type,
                      (uint64_t)(FVV_SCEN_LATTICE_ORIGIN + 8 * i),
                      "lattice origin %g and step %g lead beyond what a double holds",
                      scene->lattice_origin[i], scene->lattice_step);
  if (scene->up_axis > FVV_UP_MINUS_Z)
    return fvv_fail(diagnostic, status, FVV_ISSUE_UP_AXIS, type, FVV_SCEN_UP_AXIS,
                    "up axis is %u, expected 0 to %d", scene->up_axis, FVV_UP_MINUS_Z);
  if (scene->flags & ~FVV_SCENE_SCALE_UNKNOWN)
    return fvv_fail(diagnostic, status, FVV_ISSUE_SCENE_PAYLOAD, type, FVV_SCEN_FLAGS,
                    "scene flags are 0x%02x, expected 0 or 1", scene->flags);
  return FVV_OK;
}

fvv_status fvv_scene_encode(const fvv_scene *scene, uint8_t *out, size_t capacity, size_t *written,
                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_status status = scene_check(scene, FVV_ERROR_ARGUMENT, diagnostic);
  if (status < 0) return status;
  *written = FVV_SCEN_SIZE;
  if (capacity < FVV_SCEN_SIZE) return FVV_ERROR_BUFFER_TOO_SMALL;
  memset(out, 0, FVV_SCEN_SIZE);
  fvv_put_u32(out + FVV_SCEN_TIME_BASE_NUMERATOR, scene->time_base.numerator);
  fvv_put_u32(out + FVV_SCEN_TIME_BASE_DENOMINATOR, scene->time_base.denominator);
  fvv_put_i64(out + FVV_SCEN_FRAME_DURATION, scene->frame_duration);
  for (int i = 0; i < 3; i++) fvv_put_f64(out + FVV_SCEN_LATTICE_ORIGIN + 8 * i, scene->lattice_origin[i]);
  fvv_put_f64(out + FVV_SCEN_LATTICE_STEP, scene->lattice_step);
  out[FVV_SCEN_UP_AXIS] = scene->up_axis;
  out[FVV_SCEN_FLAGS] = scene->flags;
  return FVV_OK;
}

fvv_status fvv_scene_decode(fvv_scene *scene, const uint8_t *payload, size_t size,
                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  memset(scene, 0, sizeof *scene);
  if (size != FVV_SCEN_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_SCENE_PAYLOAD, FVV_CHUNK_SCENE, 0,
                    "payload of %zu bytes, expected %d", size, FVV_SCEN_SIZE);
  if (!fvv_all_zero(payload + FVV_SCEN_RESERVED, FVV_SCEN_SIZE - FVV_SCEN_RESERVED))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_SCENE_PAYLOAD, FVV_CHUNK_SCENE,
                    FVV_SCEN_RESERVED, "reserved bytes are not 0");
  scene->time_base.numerator = fvv_get_u32(payload + FVV_SCEN_TIME_BASE_NUMERATOR);
  scene->time_base.denominator = fvv_get_u32(payload + FVV_SCEN_TIME_BASE_DENOMINATOR);
  scene->frame_duration = fvv_get_i64(payload + FVV_SCEN_FRAME_DURATION);
  for (int i = 0; i < 3; i++)
    scene->lattice_origin[i] = fvv_get_f64(payload + FVV_SCEN_LATTICE_ORIGIN + 8 * i);
  scene->lattice_step = fvv_get_f64(payload + FVV_SCEN_LATTICE_STEP);
  scene->up_axis = payload[FVV_SCEN_UP_AXIS];
  scene->flags = payload[FVV_SCEN_FLAGS];
  return scene_check(scene, FVV_ERROR_INVALID, diagnostic);
}

fvv_status fvv_track_encode(const fvv_track *track, uint8_t *out, size_t capacity, size_t *written,
                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  if (!track->id || !track->kind || track->name_size > UINT16_MAX ||
      !fvv_text_valid((const uint8_t *)track->name, track->name_size, NULL))
    return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, FVV_CHUNK_TRACK, 0,
                    "a track needs an id, a kind and a UTF-8 name of at most 65535 bytes");
  *written = FVV_TRAK_SIZE + track->name_size;
  if (capacity < *written) return FVV_ERROR_BUFFER_TOO_SMALL;
  memset(out, 0, FVV_TRAK_SIZE);
  out[FVV_TRAK_KIND] = track->kind;
  fvv_put_u16(out + FVV_TRAK_NAME_SIZE, (uint16_t)track->name_size);
  if (track->name_size) memcpy(out + FVV_TRAK_SIZE, track->name, track->name_size);
  return FVV_OK;
}

fvv_status fvv_track_decode(fvv_track *track, const uint8_t *payload, size_t size, const fvv_limits *limits,
                            fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  memset(track, 0, sizeof *track);
  if (size < FVV_TRAK_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TRACK_PAYLOAD, FVV_CHUNK_TRACK, 0,
                    "payload of %zu bytes, expected at least %d", size, FVV_TRAK_SIZE);
  if (payload[FVV_TRAK_RESERVED] || !fvv_all_zero(payload + FVV_TRAK_RESERVED2, 4))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TRACK_PAYLOAD, FVV_CHUNK_TRACK,
                    FVV_TRAK_RESERVED, "reserved bytes are not 0");
  track->kind = payload[FVV_TRAK_KIND];
  track->name_size = fvv_get_u16(payload + FVV_TRAK_NAME_SIZE);
  track->name = (const char *)payload + FVV_TRAK_SIZE;
  if (size != FVV_TRAK_SIZE + track->name_size)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TRACK_PAYLOAD, FVV_CHUNK_TRACK,
                    FVV_TRAK_NAME_SIZE, "payload of %zu bytes, expected %zu for a name of %zu", size,
                    FVV_TRAK_SIZE + track->name_size, track->name_size);
  if (!track->kind)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TRACK_KIND, FVV_CHUNK_TRACK, FVV_TRAK_KIND,
                    "track kind is 0");
  const fvv_limits limit = fvv_limits_or_default(limits);
  if (track->name_size > limit.max_text)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_TRACK, FVV_TRAK_NAME_SIZE,
                    "name of %zu bytes, limit %u", track->name_size, limit.max_text);
  return fvv_text_check(track->name, track->name_size, "track name", FVV_ERROR_INVALID, FVV_CHUNK_TRACK,
                        FVV_TRAK_SIZE, diagnostic);
}
