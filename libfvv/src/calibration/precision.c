/* calibration/precision.c: how fine the steps of a camera that moves have to be.
 *
 * Knows how far a picture point moves with each value; uses nothing but sums, products and square roots, so
 * that every machine chooses the same. */
#include "calibration/lens.h"
#include "calibration/values.h"

/* The least e with 2^-e <= step, within [least, most]. */
static int bits_for(double step, int least, int most) {
  for (int e = least; e < most; e++)
    if (ldexp(1, -e) <= step) return e;
  return most;
}

/* The most e <= bits with largest * 2^e within the range of values. */
static int bits_within(double largest, int bits) {
  while (bits > 0 && !(ldexp(largest, bits) <= (double)FVV_CALIBRATION_VALUE_MAX / 2)) bits--;
  return bits;
}

static int finer(int a, int b) {
  return a > b ? a : b;
}

/* How far the corner of the picture that is furthest from the axis is from it, at distance 1. */
static double reach_of(const fvv_camera *camera) {
  double reach = 0;
  for (int corner = 0; corner < 4; corner++) {
    const double y = ((corner & 2 ? camera->height : 0) - camera->cy) / camera->fy;
    const double x = ((corner & 1 ? camera->width : 0) - camera->cx - camera->skew * y) / camera->fx;
    reach = fmax(reach, sqrt(x * x + y * y));
  }
  return reach;
}

void fvv_calibration_choose(const fvv_camera *cameras, size_t count, double position_step, double max_pixels,
                            fvv_calibration_bits *bits) {
  const double share = max_pixels / 4;
  int rotation = FVV_CALIBRATION_ROTATION_MIN, pixel = 0, lens = 0;
  double furthest = 0, longest = 0, strongest = 0;
  for (size_t i = 0; i < count; i++) {
    const fvv_camera *c = &cameras[i];
    const double f = fmax(c->fx, c->fy) + fabs(c->skew), reach = reach_of(c);
    const double r = fmin(c->r_max, 1.5 * reach);
    double centre[3];
    /* A quaternion whose components are half a step off turns by two steps at most. */
    rotation = finer(rotation, bits_for(share / (2 * f * (1 + r * r)), FVV_CALIBRATION_ROTATION_MIN,
                                        FVV_CALIBRATION_ROTATION_MAX));
    pixel = finer(pixel, bits_for(share / (1 + reach), 0, FVV_CALIBRATION_BITS_MAX));
    /* Nine powers of the radius at most, eight coefficients, half a step each; twice for denominators. */
    double power = 1;
    for (int k = 0; k < 9 && r > 1; k++) power *= r;
    lens = finer(lens, bits_for(share / (8 * f * power), 0, FVV_CALIBRATION_BITS_MAX));
    fvv_camera_centre(c, centre);
    for (int k = 0; k < 3; k++) furthest = fmax(furthest, fabs(centre[k]));
    longest = fmax(fmax(longest, fmax(f, fabs(c->skew))), fmax(fabs(c->cx), fabs(c->cy)));
    for (int k = 0; k < 8; k++) strongest = fmax(strongest, fabs(c->distortion[k]));
    if (!isinf(c->r_max)) strongest = fmax(strongest, c->r_max);
  }
  bits->rotation = (uint8_t)rotation;
  bits->position = (uint8_t)bits_within(furthest, bits_for(position_step, 0, FVV_CALIBRATION_BITS_MAX));
  bits->pixel = (uint8_t)bits_within(longest, pixel);
  bits->lens = (uint8_t)bits_within(strongest, lens);
}
