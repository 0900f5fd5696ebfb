/* Spherical linear interpolation of rotations (Shoemake, Animating rotation with quaternion curves, 1985),
 * and all else of a camera between two of its moments. */
#include "calibration/values.h"

#include <math.h>

static double mix(double a, double b, double t) {
  return a + t * (b - a);
}

/* Along the shorter arc; q need not be of unit length. */
static void interpolate_quaternion(const double a[4], const double b[4], double t, double q[4]) {
  double product = 0;
  for (int i = 0; i < 4; i++) product += a[i] * b[i];
  const double sign = product < 0 ? -1 : 1;
  const double angle = acos(fmin(fabs(product), 1));
  /* Sines of small angles are the angles; the quotient of tiny ones says nothing. */
  const int straight = angle < 1e-6;
  const double of_a = straight ? 1 - t : sin((1 - t) * angle), of_b = straight ? t : sin(t * angle);
  for (int i = 0; i < 4; i++) q[i] = of_a * a[i] + sign * of_b * b[i];
}

static void rotation_of(const double q[4], double r[9]) {
  const double n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  const double s = 2 / n;
  r[0] = 1 - s * (q[2] * q[2] + q[3] * q[3]);
  r[1] = s * (q[1] * q[2] - q[0] * q[3]);
  r[2] = s * (q[1] * q[3] + q[0] * q[2]);
  r[3] = s * (q[1] * q[2] + q[0] * q[3]);
  r[4] = 1 - s * (q[1] * q[1] + q[3] * q[3]);
  r[5] = s * (q[2] * q[3] - q[0] * q[1]);
  r[6] = s * (q[1] * q[3] - q[0] * q[2]);
  r[7] = s * (q[2] * q[3] + q[0] * q[1]);
  r[8] = 1 - s * (q[1] * q[1] + q[2] * q[2]);
}

fvv_status fvv_camera_interpolate(const fvv_camera *a, const fvv_camera *b, double t, fvv_camera *camera) {
  if (a->id != b->id || a->lens != b->lens || a->width != b->width || a->height != b->height ||
      !(t >= 0 && t <= 1))
    return FVV_ERROR_ARGUMENT;
  fvv_camera out = *a;
  if (t == 0 || t == 1) {
    if (t == 1) out = *b;
    out.flags = a->flags;
    out.name = a->name;
    out.name_size = a->name_size;
    *camera = out;
    return FVV_OK;
  }
  double from[4], to[4], q[4], first[3], last[3];
  fvv_quaternion_of(a->rotation, from);
  fvv_quaternion_of(b->rotation, to);
  interpolate_quaternion(from, to, t, q);
  rotation_of(q, out.rotation);
  fvv_camera_centre(a, first);
  fvv_camera_centre(b, last);
  for (int i = 0; i < 3; i++) first[i] = mix(first[i], last[i], t);
  for (int i = 0; i < 3; i++)
    out.translation[i] = -(out.rotation[3 * i] * first[0] + out.rotation[3 * i + 1] * first[1] +
                           out.rotation[3 * i + 2] * first[2]);
  out.fx = exp(mix(log(a->fx), log(b->fx), t));
  out.fy = exp(mix(log(a->fy), log(b->fy), t));
  out.cx = mix(a->cx, b->cx, t);
  out.cy = mix(a->cy, b->cy, t);
  out.skew = mix(a->skew, b->skew, t);
  for (int i = 0; i < 8; i++) out.distortion[i] = mix(a->distortion[i], b->distortion[i], t);
  out.r_max = fmin(a->r_max, b->r_max);
  if (fvv_camera_validate(&out, NULL) != FVV_OK) {
    out.r_max = fmin(out.r_max, fvv_camera_r_max(&out));
    if (fvv_camera_validate(&out, NULL) != FVV_OK) return FVV_ERROR_ARGUMENT;
  }
  *camera = out;
  return FVV_OK;
}
