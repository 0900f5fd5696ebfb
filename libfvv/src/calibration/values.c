/* Quaternions: the largest of the four components is computed from the diagonal of R and the others from it
 * (Shepperd, Quaternion from rotation matrix, Journal of Guidance and Control 1, 1978), which is exact at all
 * angles, 180 degrees included. */
#include "calibration/values.h"

#include "calibration/lens.h"

#include <string.h>

size_t fvv_calibration_value_count(uint8_t lens) {
  return FVV_CALIBRATION_LENS + (lens == FVV_LENS_RADTAN ? 9 : lens == FVV_LENS_FISHEYE ? 5 : 1);
}

int fvv_calibration_bits_valid(const fvv_calibration_bits *bits) {
  return bits->rotation >= FVV_CALIBRATION_ROTATION_MIN && bits->rotation <= FVV_CALIBRATION_ROTATION_MAX &&
         bits->position <= FVV_CALIBRATION_BITS_MAX && bits->pixel <= FVV_CALIBRATION_BITS_MAX &&
         bits->lens <= FVV_CALIBRATION_BITS_MAX;
}

/* The bits of the unit of value i. */
static int bits_of(const fvv_calibration_bits *bits, size_t i) {
  return i < FVV_CALIBRATION_CENTRE ? bits->rotation
         : i < FVV_CALIBRATION_FX   ? bits->position
         : i < FVV_CALIBRATION_LENS ? bits->pixel
                                    : bits->lens;
}

static int round_to(double value, int bits, int64_t *out) {
  const double scaled = floor(ldexp(value, bits) + 0.5);
  if (!(fabs(scaled) <= (double)FVV_CALIBRATION_VALUE_MAX)) return 0;
  *out = (int64_t)scaled;
  return 1;
}

void fvv_quaternion_of(const double *r, double q[4]) {
  const double trace = r[0] + r[4] + r[8];
  const double diagonal[4] = {trace, r[0], r[4], r[8]};
  int largest = 0;
  for (int i = 1; i < 4; i++)
    if (diagonal[i] > diagonal[largest]) largest = i;
  /* Row i: 4 q_i times q. */
  const double rows[4][4] = {{1 + trace, r[7] - r[5], r[2] - r[6], r[3] - r[1]},
                             {r[7] - r[5], 1 + 2 * r[0] - trace, r[1] + r[3], r[2] + r[6]},
                             {r[2] - r[6], r[1] + r[3], 1 + 2 * r[4] - trace, r[5] + r[7]},
                             {r[3] - r[1], r[2] + r[6], r[5] + r[7], 1 + 2 * r[8] - trace}};
  double squares = 0;
  for (int i = 0; i < 4; i++) squares += rows[largest][i] * rows[largest][i];
  for (int i = 0; i < 4; i++) q[i] = rows[largest][i] / sqrt(squares);
}

/* Whether q should be written as -q: it is nearer to before, or, without one, its first component that is not
 * 0 is negative. */
static int is_opposite(const double q[4], const int64_t *before) {
  double product = 0;
  for (int i = 0; i < 4; i++) product += q[i] * (double)before[i];
  for (int i = 0; i < 4 && product == 0; i++) product = q[i];
  return product < 0;
}

static int lens_to_values(const fvv_camera *camera, int bits, int64_t *values) {
  const size_t coefficients = fvv_calibration_value_count(camera->lens) - FVV_CALIBRATION_LENS - 1;
  double rounded[8] = {0};
  for (size_t i = 0; i < coefficients; i++) {
    if (!round_to(camera->distortion[i], bits, &values[i])) return 0;
    rounded[i] = ldexp((double)values[i], -bits);
  }
  values[coefficients] = 0;
  if (isinf(camera->r_max)) return 1;
  const fvv_lens lens = {camera->lens, rounded};
  const double radius = fmin(camera->r_max, fvv_lens_rising(&lens, camera->r_max));
  const double steps = floor(ldexp(radius, bits));
  if (!(steps >= 1 && steps <= (double)FVV_CALIBRATION_VALUE_MAX)) return 0;
  values[coefficients] = (int64_t)steps;
  return 1;
}

int fvv_calibration_to_values(const fvv_camera *camera, const fvv_calibration_bits *bits,
                              const int64_t *before, int64_t *values) {
  double q[4], all[FVV_CALIBRATION_LENS];
  fvv_quaternion_of(camera->rotation, q);
  const double sign = is_opposite(q, before) ? -1 : 1;
  for (int i = 0; i < 4; i++) all[i] = sign * q[i];
  fvv_camera_centre(camera, all + FVV_CALIBRATION_CENTRE);
  const double intrinsics[5] = {camera->fx, camera->fy, camera->cx, camera->cy, camera->skew};
  memcpy(all + FVV_CALIBRATION_FX, intrinsics, sizeof intrinsics);
  for (size_t i = 0; i < FVV_CALIBRATION_LENS; i++)
    if (!round_to(all[i], bits_of(bits, i), &values[i])) return 0;
  return lens_to_values(camera, bits->lens, values + FVV_CALIBRATION_LENS);
}

static int64_t squared_length(const int64_t *q) {
  return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
}

int fvv_calibration_quaternion_valid(const int64_t *values, const fvv_calibration_bits *bits) {
  const int64_t longest = INT64_C(1) << (bits->rotation + 1);
  for (int i = 0; i < 4; i++)
    if (values[i] < -longest || values[i] > longest) return 0;
  const int64_t n = squared_length(values), unit = INT64_C(1) << 2 * bits->rotation;
  return n >= unit / 4 && n <= unit * 4;
}

void fvv_calibration_from_values(const int64_t *values, const fvv_calibration_bits *bits,
                                 fvv_camera *camera) {
  double real[FVV_CALIBRATION_VALUES] = {0};
  const size_t count = fvv_calibration_value_count(camera->lens);
  for (size_t i = FVV_CALIBRATION_CENTRE; i < count; i++)
    real[i] = ldexp((double)values[i], -bits_of(bits, i));
  const int64_t *q = values, n = squared_length(q);
  const int64_t rotation[9] = {q[0] * q[0] + q[1] * q[1] - q[2] * q[2] - q[3] * q[3],
                               2 * (q[1] * q[2] - q[0] * q[3]),
                               2 * (q[1] * q[3] + q[0] * q[2]),
                               2 * (q[1] * q[2] + q[0] * q[3]),
                               q[0] * q[0] - q[1] * q[1] + q[2] * q[2] - q[3] * q[3],
                               2 * (q[2] * q[3] - q[0] * q[1]),
                               2 * (q[1] * q[3] - q[0] * q[2]),
                               2 * (q[2] * q[3] + q[0] * q[1]),
                               q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3]};
  const double *centre = real + FVV_CALIBRATION_CENTRE;
  for (int i = 0; i < 9; i++) camera->rotation[i] = (double)rotation[i] / (double)n;
  for (int i = 0; i < 3; i++) {
    const double *r = camera->rotation + 3 * i;
    camera->translation[i] = -((r[0] * centre[0] + r[1] * centre[1]) + r[2] * centre[2]);
  }
  const double *k = real + FVV_CALIBRATION_FX;
  camera->fx = k[0], camera->fy = k[1], camera->cx = k[2], camera->cy = k[3], camera->skew = k[4];
  memset(camera->distortion, 0, sizeof camera->distortion);
  memcpy(camera->distortion, real + FVV_CALIBRATION_LENS, (count - FVV_CALIBRATION_LENS - 1) * sizeof *real);
  camera->r_max = camera->lens == FVV_LENS_NONE && !values[count - 1] ? INFINITY : real[count - 1];
}
