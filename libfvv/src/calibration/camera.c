/* A camera: its projection, the rules that it keeps, and its record in CAMR. */
#include <float.h>
#include <inttypes.h>
#include <math.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "base/text.h"
#include "calibration/lens.h"
#include "fvv/calibration.h"

/* A right angle less 1e-13: the r_max of a fisheye stays below it, so that its rays are finite. */
#define ANGLE_MAX 1.5707963267947

static fvv_lens lens_of(const fvv_camera *camera) {
  const fvv_lens lens = {camera->lens, camera->distortion};
  return lens;
}

/* Pixels -> what the lens made of the direction. */
static void normalise(const fvv_camera *camera, const double pixel[2], double d[2]) {
  d[1] = (pixel[1] - camera->cy) / camera->fy;
  d[0] = (pixel[0] - camera->cx - camera->skew * d[1]) / camera->fx;
}

double fvv_camera_r_max(const fvv_camera *camera) {
  const fvv_lens lens = lens_of(camera);
  const double ceiling = camera->lens == FVV_LENS_FISHEYE ? ANGLE_MAX : INFINITY;
  double needed = 0;
  for (int corner = 0; corner < 4; corner++) {
    const double pixel[2] = {corner & 1 ? camera->width : 0, corner & 2 ? camera->height : 0};
    double d[2];
    normalise(camera, pixel, d);
    const double radius = fvv_lens_length(d);
    if (!isfinite(radius)) return 0;
    needed = fmax(needed, radius);
  }
  /* A lens that flattens out may never reach the corner: 14 doublings are nearly a right angle. */
  double end = fmin(needed, ceiling), limit = fvv_lens_invertible(&lens, end);
  for (int i = 0; i < 14 && limit == end && end < ceiling && fvv_lens_radial(&lens, end, NULL) < needed;
       i++) {
    end = fmin(2 * end, ceiling);
    limit = fvv_lens_invertible(&lens, end);
  }
  if (!(fvv_lens_radial(&lens, limit, NULL) >= needed)) return limit;
  const double cap = fmin(1.25 * fvv_lens_radius(&lens, limit, needed), ceiling);
  return cap <= limit ? cap : fvv_lens_invertible(&lens, cap);
}

int fvv_camera_project(const fvv_camera *camera, const double world[3], double pixel[2], double *depth) {
  const double *r = camera->rotation;
  double c[3];
  for (int i = 0; i < 3; i++)
    c[i] = r[3 * i] * world[0] + r[3 * i + 1] * world[1] + r[3 * i + 2] * world[2] + camera->translation[i];
  if (depth) *depth = c[2];
  pixel[0] = pixel[1] = NAN;
  if (!(c[2] > 0)) return 0;

  double q[2] = {c[0] / c[2], c[1] / c[2]};
  double radius = fvv_lens_length(q);
  if (camera->lens == FVV_LENS_FISHEYE) {
    const double angle = atan(radius), scale = radius > 0 ? angle / radius : 1;
    q[0] *= scale;
    q[1] *= scale;
    radius = angle;
  }
  if (!(radius <= camera->r_max)) return 0;
  const fvv_lens lens = lens_of(camera);
  double d[2];
  fvv_lens_distort(&lens, q, d);
  const double u = camera->fx * d[0] + camera->skew * d[1] + camera->cx, v = camera->fy * d[1] + camera->cy;
  if (!isfinite(u) || !isfinite(v)) return 0;
  pixel[0] = u;
  pixel[1] = v;
  return 1;
}

int fvv_camera_unproject(const fvv_camera *camera, const double pixel[2], double ray[3]) {
  const fvv_lens lens = lens_of(camera);
  double d[2], q[2];
  ray[0] = ray[1] = ray[2] = NAN;
  normalise(camera, pixel, d);
  /* 1e-10 px, and the rounding error of pixels far outside the picture. */
  const double size = fabs(pixel[0]) + fabs(pixel[1]) + fabs(camera->cx) + fabs(camera->cy);
  const double tolerance =
      (1e-10 + 4 * DBL_EPSILON * size) / (fmax(camera->fx, camera->fy) + fabs(camera->skew));
  if (!fvv_lens_undistort(&lens, camera->r_max, d, tolerance, q)) return 0;
  double scale = 1;
  if (camera->lens == FVV_LENS_FISHEYE) {
    const double angle = fvv_lens_length(q);
    if (angle > 0) scale = tan(angle) / angle;
  }
  ray[0] = scale * q[0];
  ray[1] = scale * q[1];
  ray[2] = 1;
  return 1;
}

void fvv_camera_centre(const fvv_camera *camera, double centre[3]) {
  const double *r = camera->rotation, *t = camera->translation;
  for (int i = 0; i < 3; i++) centre[i] = -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2]);
}

/* The rules for a camera and the CAMR payload (clause 9.2). A rotation is rejected or kept as it is; it is
 * never made orthonormal. */

#define HALF_PI 1.57079632679489661923
#define ROTATION_TOLERANCE 1e-4
#define R_MAX_TOLERANCE 1e-9 /* relative: machines differ in how they find the zero of the derivative */

static int coefficient_count(uint8_t lens) {
  return lens == FVV_LENS_RADTAN ? 8 : lens == FVV_LENS_FISHEYE ? 4 : 0;
}

static fvv_status check_header(const fvv_camera *camera, fvv_status status, fvv_diagnostic *diagnostic) {
  if (camera->flags & ~FVV_CAMERA_MOVES)
    return fvv_fail(diagnostic, status, FVV_ISSUE_CAMERA_PAYLOAD, FVV_CHUNK_CAMERA, FVV_CAMR_FLAGS,
                    "camera flags are 0x%02x, expected 0 or 1", camera->flags);
  const fvv_status text = fvv_text_check(camera->name, camera->name_size, "camera name", status,
                                         FVV_CHUNK_CAMERA, FVV_CAMR_SIZE, diagnostic);
  if (text != FVV_OK) return text;
  if (camera->lens > FVV_LENS_FISHEYE)
    return fvv_fail(diagnostic, status, FVV_ISSUE_CAMERA_LENS, FVV_CHUNK_CAMERA, FVV_CAMR_LENS,
                    "lens model is %d, expected 0 to 2", camera->lens);
  for (int i = coefficient_count(camera->lens); i < 8; i++)
    if (camera->distortion[i] != 0)
      return fvv_fail(diagnostic, status, FVV_ISSUE_CAMERA_PAYLOAD, FVV_CHUNK_CAMERA,
                      FVV_CAMR_DISTORTION + (uint64_t)i * 8,
                      "distortion coefficient %d is %.9g, expected 0 because lens model %d does not use it",
                      i, camera->distortion[i], camera->lens);
  return FVV_OK;
}

static fvv_status check_intrinsics(const fvv_camera *camera, fvv_status status, fvv_diagnostic *diagnostic) {
  const uint32_t issue = FVV_ISSUE_CAMERA_INTRINSICS, type = FVV_CHUNK_CAMERA;
  if (!camera->width || !camera->height)
    return fvv_fail(diagnostic, status, issue, type, FVV_CAMR_WIDTH,
                    "picture size is %" PRIu32 " x %" PRIu32 ", expected at least 1 x 1", camera->width,
                    camera->height);
  const struct {
    const char *name;
    double value;
    int positive;
  } fields[] = {{"fx", camera->fx, 1},
                {"fy", camera->fy, 1},
                {"cx", camera->cx, 0},
                {"cy", camera->cy, 0},
                {"skew", camera->skew, 0}};
  for (int i = 0; i < 5; i++)
    if (!isfinite(fields[i].value) || (fields[i].positive && fields[i].value <= 0))
      return fvv_fail(diagnostic, status, issue, type, FVV_CAMR_FX + (uint64_t)i * 8,
                      "%s is %.9g, expected a finite number%s", fields[i].name, fields[i].value,
                      fields[i].positive ? " above 0" : "");
  for (int i = 0; i < coefficient_count(camera->lens); i++)
    if (!isfinite(camera->distortion[i]))
      return fvv_fail(diagnostic, status, issue, type, FVV_CAMR_DISTORTION + (uint64_t)i * 8,
                      "distortion coefficient %d is %.9g, expected a finite number", i,
                      camera->distortion[i]);
  return FVV_OK;
}

static fvv_status check_pose(const fvv_camera *camera, fvv_status status, fvv_diagnostic *diagnostic) {
  const uint32_t issue = FVV_ISSUE_CAMERA_ROTATION, type = FVV_CHUNK_CAMERA;
  const double *r = camera->rotation;
  for (int i = 0; i < 3; i++)
    for (int j = i; j < 3; j++) {
      const double dot = r[3 * i] * r[3 * j] + r[3 * i + 1] * r[3 * j + 1] + r[3 * i + 2] * r[3 * j + 2];
      if (!(fabs(dot - (i == j)) <= ROTATION_TOLERANCE))
        return fvv_fail(diagnostic, status, issue, type, FVV_CAMR_ROTATION,
                        "rows %d and %d of the rotation have the product %.9g, expected %d within 1e-4", i, j,
                        dot, i == j);
    }
  const double determinant = r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
                             r[2] * (r[3] * r[7] - r[4] * r[6]);
  if (!(determinant > 0))
    return fvv_fail(diagnostic, status, issue, type, FVV_CAMR_ROTATION,
                    "the rotation has the determinant %.9g, expected a positive one: it mirrors",
                    determinant);
  for (int i = 0; i < 3; i++)
    if (!isfinite(camera->translation[i]))
      return fvv_fail(diagnostic, status, issue, type, FVV_CAMR_TRANSLATION + (uint64_t)i * 8,
                      "translation element %d is %.9g, expected a finite number", i, camera->translation[i]);
  return FVV_OK;
}

static fvv_status check_r_max(const fvv_camera *camera, fvv_status status, fvv_diagnostic *diagnostic) {
  const uint32_t issue = FVV_ISSUE_CAMERA_R_MAX, type = FVV_CHUNK_CAMERA;
  const double r_max = camera->r_max;
  if (!(r_max > 0))
    return fvv_fail(diagnostic, status, issue, type, FVV_CAMR_R_MAX,
                    "r_max is %.9g, expected a number above 0", r_max);
  if (camera->lens == FVV_LENS_NONE) return FVV_OK;
  if (!isfinite(r_max) || (camera->lens == FVV_LENS_FISHEYE && r_max >= HALF_PI))
    return fvv_fail(diagnostic, status, issue, type, FVV_CAMR_R_MAX, "r_max is %.9g, expected %s", r_max,
                    camera->lens == FVV_LENS_FISHEYE ? "an angle below 90 degrees" : "a finite number");
  const fvv_lens lens = {camera->lens, camera->distortion};
  const double limit = fvv_lens_rising(&lens, r_max);
  if (!(r_max <= limit * (1 + R_MAX_TOLERANCE)))
    return fvv_fail(diagnostic, status, issue, type, FVV_CAMR_R_MAX,
                    "r_max is %.9g, but the lens is invertible only up to %.9g", r_max, limit);
  return FVV_OK;
}

static fvv_status check_camera(const fvv_camera *camera, fvv_status status, fvv_diagnostic *diagnostic) {
  fvv_status result = check_header(camera, status, diagnostic);
  if (result == FVV_OK) result = check_intrinsics(camera, status, diagnostic);
  if (result == FVV_OK) result = check_pose(camera, status, diagnostic);
  if (result == FVV_OK) result = check_r_max(camera, status, diagnostic);
  if (result != FVV_OK || camera->id != FVV_NO_CAMERA) return result;
  return fvv_fail(diagnostic, status, FVV_ISSUE_CAMERA_ID, FVV_CHUNK_CAMERA, FVV_CAMR_ID,
                  "camera identifier is 65535, expected 0 to 65534");
}

fvv_status fvv_camera_validate(const fvv_camera *camera, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  return check_camera(camera, FVV_ERROR_INVALID, diagnostic);
}

fvv_status fvv_camera_encode(const fvv_camera *camera, uint8_t *out, size_t capacity, size_t *written,
                             fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  *written = 0;
  if (camera->name_size > UINT32_MAX - FVV_CAMR_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_CAMERA_PAYLOAD, FVV_CHUNK_CAMERA,
                    FVV_CAMR_NAME_SIZE, "camera name has %zu bytes, more than the record can hold",
                    camera->name_size);
  const fvv_limits limits = fvv_limits_or_default(NULL);
  const uint32_t side = camera->width > camera->height ? camera->width : camera->height;
  fvv_status status = check_camera(camera, FVV_ERROR_INPUT, diagnostic);
  if (status == FVV_OK)
    status = fvv_readable_check(camera->name_size, limits.max_text, "bytes of a camera name",
                                FVV_CHUNK_CAMERA, diagnostic);
  if (status == FVV_OK)
    status = fvv_readable_check(side, limits.max_dimension, "pixels to a side of a camera's picture",
                                FVV_CHUNK_CAMERA, diagnostic);
  if (status != FVV_OK) return status;
  *written = FVV_CAMR_SIZE + camera->name_size;
  if (capacity < *written)
    return fvv_fail(diagnostic, FVV_ERROR_BUFFER_TOO_SMALL, 0, FVV_CHUNK_CAMERA, 0,
                    "the record needs %zu bytes, the buffer has %zu", *written, capacity);
  fvv_put_u16(out + FVV_CAMR_ID, camera->id);
  out[FVV_CAMR_LENS] = camera->lens;
  out[FVV_CAMR_FLAGS] = camera->flags;
  fvv_put_u32(out + FVV_CAMR_NAME_SIZE, (uint32_t)camera->name_size);
  fvv_put_u32(out + FVV_CAMR_WIDTH, camera->width);
  fvv_put_u32(out + FVV_CAMR_HEIGHT, camera->height);
  fvv_put_f64(out + FVV_CAMR_FX, camera->fx);
  fvv_put_f64(out + FVV_CAMR_FY, camera->fy);
  fvv_put_f64(out + FVV_CAMR_CX, camera->cx);
  fvv_put_f64(out + FVV_CAMR_CY, camera->cy);
  fvv_put_f64(out + FVV_CAMR_SKEW, camera->skew);
  for (int i = 0; i < 8; i++) fvv_put_f64(out + FVV_CAMR_DISTORTION + 8 * i, camera->distortion[i]);
  fvv_put_f64(out + FVV_CAMR_R_MAX, camera->r_max);
  for (int i = 0; i < 9; i++) fvv_put_f64(out + FVV_CAMR_ROTATION + 8 * i, camera->rotation[i]);
  for (int i = 0; i < 3; i++) fvv_put_f64(out + FVV_CAMR_TRANSLATION + 8 * i, camera->translation[i]);
  if (camera->name_size) memcpy(out + FVV_CAMR_SIZE, camera->name, camera->name_size);
  return FVV_OK;
}

fvv_status fvv_camera_decode(fvv_camera *camera, const uint8_t *payload, size_t size,
                             const fvv_limits *limits, fvv_diagnostic *diagnostic) {
  const fvv_limits allowed = fvv_limits_or_default(limits);
  fvv_diagnostic_clear(diagnostic);
  if (size < FVV_CAMR_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CAMERA_PAYLOAD, FVV_CHUNK_CAMERA, 0,
                    "payload has %zu bytes, expected at least %d", size, FVV_CAMR_SIZE);
  const uint32_t name_size = fvv_get_u32(payload + FVV_CAMR_NAME_SIZE);
  if (name_size != size - FVV_CAMR_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_CAMERA_PAYLOAD, FVV_CHUNK_CAMERA,
                    FVV_CAMR_NAME_SIZE, "name of %" PRIu32 " bytes declared, %zu bytes follow", name_size,
                    size - FVV_CAMR_SIZE);
  if (name_size > allowed.max_text)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_CAMERA, FVV_CAMR_NAME_SIZE,
                    "name of %" PRIu32 " bytes, at most %" PRIu32 " are allowed", name_size,
                    allowed.max_text);
  fvv_camera c = {0};
  c.width = fvv_get_u32(payload + FVV_CAMR_WIDTH);
  c.height = fvv_get_u32(payload + FVV_CAMR_HEIGHT);
  if (c.width > allowed.max_dimension || c.height > allowed.max_dimension)
    return fvv_fail(diagnostic, FVV_ERROR_LIMIT, FVV_ISSUE_LIMIT, FVV_CHUNK_CAMERA, FVV_CAMR_WIDTH,
                    "picture of %" PRIu32 " x %" PRIu32 " pixels, at most %" PRIu32 " a side are allowed",
                    c.width, c.height, allowed.max_dimension);
  c.id = fvv_get_u16(payload + FVV_CAMR_ID);
  c.lens = payload[FVV_CAMR_LENS];
  c.flags = payload[FVV_CAMR_FLAGS];
  c.fx = fvv_get_f64(payload + FVV_CAMR_FX);
  c.fy = fvv_get_f64(payload + FVV_CAMR_FY);
  c.cx = fvv_get_f64(payload + FVV_CAMR_CX);
  c.cy = fvv_get_f64(payload + FVV_CAMR_CY);
  c.skew = fvv_get_f64(payload + FVV_CAMR_SKEW);
  for (int i = 0; i < 8; i++) c.distortion[i] = fvv_get_f64(payload + FVV_CAMR_DISTORTION + 8 * i);
  c.r_max = fvv_get_f64(payload + FVV_CAMR_R_MAX);
  for (int i = 0; i < 9; i++) c.rotation[i] = fvv_get_f64(payload + FVV_CAMR_ROTATION + 8 * i);
  for (int i = 0; i < 3; i++) c.translation[i] = fvv_get_f64(payload + FVV_CAMR_TRANSLATION + 8 * i);
  c.name = (const char *)payload + FVV_CAMR_SIZE;
  c.name_size = name_size;
  const fvv_status status = check_camera(&c, FVV_ERROR_INVALID, diagnostic);
  if (status == FVV_OK) *camera = c;
  return status;
}
