/* calibration/camera.c: from the world to pixels and back, by one camera.
 *
 * Knows the conventions of clause 9 and hands the lens itself to lens.c; must not know records, other cameras
 * or pictures. The fisheye calls the C library's atan and tan, whose last bit differs between machines:
 * projection is no part of bit-exact decoding, and nothing that is may depend on it. */
#include "fvv/calibration.h"

#include "calibration/lens.h"

#include <float.h>
#include <math.h>

/* A right angle less 1e-13: what a fisheye's r_max stays below, so that its rays are finite. */
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
  /* 1e-10 px, and the rounding that pixels far outside the picture bring along. */
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
