/* calibration/values.h: a camera that moves as the integers of clause 9.4, and back by clause 9.5.
 *
 * Knows steps and ranges of the integers; must not know how they stand in a payload. */
#ifndef FVV_CALIBRATION_VALUES_H
#define FVV_CALIBRATION_VALUES_H

#include "fvv/calibration.h"

enum {
  FVV_CALIBRATION_ROTATION_MIN = 8,
  FVV_CALIBRATION_ROTATION_MAX = 25, /* squares of four components are then exact in binary64 */
  FVV_CALIBRATION_BITS_MAX = 40,
  FVV_CALIBRATION_CENTRE = 4, /* where the centre, fx and the coefficients stand */
  FVV_CALIBRATION_FX = 7,
  FVV_CALIBRATION_LENS = 12,
  FVV_CALIBRATION_VALUES = 21 /* at most */
};

/* |value|, the last integer up to which all are exact in binary64. */
#define FVV_CALIBRATION_VALUE_MAX (INT64_C(1) << 53)

/* How many values a camera of a lens model has, r_max last: 0 where it is infinite. */
size_t fvv_calibration_value_count(uint8_t lens);

int fvv_calibration_bits_valid(const fvv_calibration_bits *bits);

/* A unit quaternion, real part first, of a rotation that is orthonormal to 1e-4. */
void fvv_quaternion_of(const double *rotation, double q[4]);

/* camera -> values, each the nearest. before: the camera's last values, all 0 when there are none; of q and
 * -q, the same rotation, the nearer is taken. r_max is rounded down and shortened to where the rounded lens
 * can be inverted. 0: a value would be beyond its range. For a valid camera. */
int fvv_calibration_to_values(const fvv_camera *camera, const fvv_calibration_bits *bits,
                              const int64_t *before, int64_t *values);

/* 0: q is no unit quaternion. */
int fvv_calibration_quaternion_valid(const int64_t *values, const fvv_calibration_bits *bits);

/* values -> camera, of which everything else is kept. The result is not checked. */
void fvv_calibration_from_values(const int64_t *values, const fvv_calibration_bits *bits, fvv_camera *camera);

#endif
