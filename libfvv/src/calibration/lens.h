/* calibration/lens.h: what a lens does to directions, and how to undo it.
 *
 * A direction is a vector q: the point (x, y) at z = 1, for the fisheye the unit vector of (x, y) times the
 * angle to the axis in radians. The lens returns F(q) = h(|q|) q + T(q) in the same units, with the radial
 * function f(r) = r h(r) and the tangential part T. */
#ifndef FVV_CALIBRATION_LENS_H
#define FVV_CALIBRATION_LENS_H

#include "fvv/format.h"

#include <math.h>

typedef struct fvv_lens {
  int model;                  /* FVV_LENS_... */
  const double *coefficients; /* 8, as in fvv_camera.distortion; borrowed */
} fvv_lens;

static inline double fvv_lens_length(const double q[2]) {
  return sqrt(q[0] * q[0] + q[1] * q[1]);
}

/* f(r); slope, if not NULL, receives f'(r). */
double fvv_lens_radial(const fvv_lens *lens, double r, double *slope);

/* F(q). */
void fvv_lens_distort(const fvv_lens *lens, const double q[2], double out[2]);

/* The largest radius in [0, end] up to which f rises strictly: up to the first zero of f' or pole of h. 0
 * when the coefficients overflow. */
double fvv_lens_rising(const fvv_lens *lens, double end);

/* The same with T taken into account: the largest radius below which the Jacobian of F is positive definite
 * in every direction, so that F can be inverted. Equal to fvv_lens_rising without tangential coefficients,
 * else less. */
double fvv_lens_invertible(const fvv_lens *lens, double end);

/* The r in [0, end] with f(r) = target, or end when f(end) <= target. f must rise up to end. */
double fvv_lens_radius(const fvv_lens *lens, double end, double target);

/* The q with |q| <= r_max and F(q) = d. Returns 1 and |F(q) - d| <= tolerance, else 0: there is none, or it
 * was not found within a fixed number of steps. */
int fvv_lens_undistort(const fvv_lens *lens, double r_max, const double d[2], double tolerance, double q[2]);

#endif
