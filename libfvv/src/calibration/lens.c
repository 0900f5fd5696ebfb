/* calibration/lens.c: the lens models of clause 9.1 and their inverses.
 *
 * The rational Brown-Conrady model as OpenCV orders its coefficients, and the equidistant model of Kannala
 * and Brandt (A generic camera model and calibration method, PAMI 2006). */
#include "calibration/lens.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Numerator and denominator of h as polynomials in s = r^2. */
typedef struct rational {
  double n[5], d[4];
} rational;

static rational radial_terms(const fvv_lens *lens) {
  const double *k = lens->coefficients;
  rational t = {{1, 0, 0, 0, 0}, {1, 0, 0, 0}};
  if (lens->model == FVV_LENS_RADTAN) {
    t.n[1] = k[0], t.n[2] = k[1], t.n[3] = k[4];
    t.d[1] = k[5], t.d[2] = k[6], t.d[3] = k[7];
  } else if (lens->model == FVV_LENS_FISHEYE) {
    memcpy(t.n + 1, k, 4 * sizeof *k);
  }
  return t;
}

/* Tangential coefficients as the vector p of T(q) = |q|^2 p + 2 (q . p) q. */
static int tangential_terms(const fvv_lens *lens, double p[2]) {
  const int has = lens->model == FVV_LENS_RADTAN;
  p[0] = has ? lens->coefficients[3] : 0;
  p[1] = has ? lens->coefficients[2] : 0;
  return p[0] != 0 || p[1] != 0;
}

/* h(r) = f(r) / r, and f'(r) = h + 2 s dh/ds. */
static double radial_factor(const fvv_lens *lens, double r, double *slope) {
  /* A pinhole may be given an infinite radius, where 0 * s is not 0. */
  if (lens->model == FVV_LENS_NONE) {
    if (slope) *slope = 1;
    return 1;
  }
  const rational t = radial_terms(lens);
  const double s = r * r;
  double n = 0, dn = 0, d = 0, dd = 0;
  for (int i = 4; i >= 0; i--) dn = dn * s + n, n = n * s + t.n[i];
  for (int i = 3; i >= 0; i--) dd = dd * s + d, d = d * s + t.d[i];
  const double h = n / d;
  if (slope) *slope = h + 2 * s * (dn - h * dd) / d;
  return h;
}

/* T(q). */
static void tangential_part(const double p[2], const double q[2], double out[2]) {
  const double s = q[0] * q[0] + q[1] * q[1], m = 2 * (q[0] * p[0] + q[1] * p[1]);
  out[0] = s * p[0] + m * q[0];
  out[1] = s * p[1] + m * q[1];
}

double fvv_lens_radial(const fvv_lens *lens, double r, double *slope) {
  return r * radial_factor(lens, r, slope);
}

void fvv_lens_distort(const fvv_lens *lens, const double q[2], double out[2]) {
  double p[2], t[2];
  const double h = radial_factor(lens, fvv_lens_length(q), NULL);
  out[0] = h * q[0];
  out[1] = h * q[1];
  if (!tangential_terms(lens, p)) return;
  tangential_part(p, q, t);
  out[0] += t[0];
  out[1] += t[1];
}

/* ---- where a lens can be inverted ------------------------------------------------------------------- */

enum { MAX_DEGREE = 13, MAX_DEPTH = 50 };
#define COEFFICIENT_MAX 1e300 /* sums of MAX_DEGREE + 1 stay finite */

/* De Casteljau's rule: the Bernstein coefficients of the left half go to left, b keeps those of the right
 * half. */
static void halve(double *b, int degree, double *left) {
  for (int i = 0; i <= degree; i++) {
    left[i] = b[0];
    for (int j = 0; j < degree - i; j++) b[j] = 0.5 * (b[j] + b[j + 1]);
  }
}

/* The largest u in [0, 1] up to which the polynomial with power coefficients a is known to be positive. A
 * polynomial lies within the hull of its Bernstein coefficients (Lane and Riesenfeld, Bounds on a polynomial,
 * BIT 1981), so a pair of close zeros is never missed between samples. Intervals are visited from the left;
 * at most MAX_DEPTH halvings. */
static double positive_up_to(const double *a, int degree) {
  double stack[MAX_DEPTH + 1][MAX_DEGREE + 1], left[MAX_DEGREE + 1] = {0};
  int depths[MAX_DEPTH + 1], top = 0;
  double u = 0;
  for (int j = 0; j <= degree; j++) {
    double ratio = 1; /* binomial(j, i) / binomial(degree, i) */
    stack[0][j] = 0;
    for (int i = 0; i <= j; i++) {
      if (!(fabs(a[i]) < COEFFICIENT_MAX)) return 0;
      stack[0][j] += ratio * a[i];
      ratio *= (double)(j - i) / (degree - i > 0 ? degree - i : 1);
    }
  }
  depths[0] = 0;
  while (top >= 0) {
    double *b = stack[top];
    int positive = 1;
    for (int j = 0; j <= degree; j++) positive &= b[j] > 0;
    if (positive) {
      u += ldexp(1, -depths[top--]);
      continue;
    }
    if (!(b[0] > 0) || depths[top] == MAX_DEPTH) return u;
    halve(b, degree, left);
    depths[top]++;
    memcpy(stack[top + 1], left, sizeof left);
    depths[top + 1] = depths[top];
    top++;
  }
  return 1;
}

/* The largest radius in [0, end] up to which f' > m r and h > m r, and h has no pole. Multiplied by the
 * denominator of h these are polynomials in r; here r = end * u. */
static double limit(const fvv_lens *lens, double end, double m) {
  if (lens->model == FVV_LENS_NONE) return end;
  rational t = radial_terms(lens);
  double power = 1;
  m *= end;
  for (int i = 0; i < 5; i++, power *= end * end) {
    t.n[i] *= power;
    if (i < 4) t.d[i] *= power;
  }
  double slope[MAX_DEGREE + 1] = {0}, factor[9] = {0}, denominator[7] = {0};
  for (int i = 0; i < 4; i++)
    for (int j = 0; j < 4; j++) {
      slope[2 * (i + j)] += (1 + 2 * i - 2 * j) * t.n[i] * t.d[j];
      slope[2 * (i + j) + 1] -= m * t.d[i] * t.d[j];
    }
  slope[8] += 9 * t.n[4]; /* only the fisheye has it, and no denominator */
  for (int i = 0; i < 4; i++) {
    factor[2 * i] = t.n[i];
    factor[2 * i + 1] = -m * t.d[i];
    denominator[2 * i] = t.d[i];
  }
  factor[8] = t.n[4];
  return end * fmin(positive_up_to(slope, MAX_DEGREE),
                    fmin(positive_up_to(factor, 8), positive_up_to(denominator, 6)));
}

double fvv_lens_rising(const fvv_lens *lens, double end) {
  return limit(lens, end, 0);
}

/* In polar axes at q the Jacobian of F is diag(f', h) plus that of T, which is symmetric with eigenvalues no
 * less than -6 |p| r. A map with a positive definite symmetric Jacobian on a disc is one to one. */
double fvv_lens_invertible(const fvv_lens *lens, double end) {
  double p[2];
  tangential_terms(lens, p);
  return limit(lens, end, 6 * fvv_lens_length(p));
}

/* ---- inverses --------------------------------------------------------------------------------------- */

/* f(r) - target; a radius that rounding or the allowance of r_max carried past a pole counts as beyond any
 * target. */
static double excess(const fvv_lens *lens, double r, double target, double *slope) {
  const double value = fvv_lens_radial(lens, r, slope);
  return value < 0 ? INFINITY : value - target;
}

/* Newton's method; the bracket is halved instead where a step leaves it or the step before did not halve the
 * error, as next to a pole. */
double fvv_lens_radius(const fvv_lens *lens, double end, double target) {
  double low = 0, high = end, r = fmin(target, end), former = INFINITY;
  if (excess(lens, end, target, NULL) <= 0) return end;
  for (int i = 0; i < 120; i++) {
    double slope;
    const double error = excess(lens, r, target, &slope);
    if (fabs(error) <= 2 * DBL_EPSILON * target) return r;
    if (error < 0)
      low = r;
    else
      high = r;
    double next = r - error / slope;
    if (!(next > low && next < high) || fabs(error) > 0.5 * former) next = low + 0.5 * (high - low);
    if (!(next > low && next < high)) return r;
    former = fabs(error);
    r = next;
  }
  return r;
}

/* The q of the disc with F(q) = d if there were no T; returns f(|q|) - |d|, 0 but for rounding unless d is
 * outside. */
static double radial_inverse(const fvv_lens *lens, double r_max, const double d[2], double q[2]) {
  const double target = fvv_lens_length(d);
  const double r = target > 0 ? fvv_lens_radius(lens, r_max, target) : 0;
  q[0] = target > 0 ? d[0] * (r / target) : 0;
  q[1] = target > 0 ? d[1] * (r / target) : 0;
  return fvv_lens_radial(lens, r, NULL) - target;
}

static double residual(const fvv_lens *lens, const double q[2], const double d[2], double error[2]) {
  fvv_lens_distort(lens, q, error);
  error[0] -= d[0];
  error[1] -= d[1];
  return fvv_lens_length(error);
}

/* q -= J^-1 error, cut back to the disc. Returns 0 where J cannot be inverted. */
static int newton_step(const fvv_lens *lens, double r_max, const double q[2], const double error[2],
                       double next[2]) {
  double p[2], slope;
  tangential_terms(lens, p);
  const double r = fvv_lens_length(q), h = radial_factor(lens, r, &slope);
  const double c = r > 0 ? q[0] / r : 1, s = r > 0 ? q[1] / r : 0;
  const double pr = c * p[0] + s * p[1], pt = c * p[1] - s * p[0];
  const double a = slope + 6 * r * pr, b = 2 * r * pt, e = h + 2 * r * pr;
  const double determinant = a * e - b * b;
  if (!(determinant > 0)) return 0;
  const double er = c * error[0] + s * error[1], et = c * error[1] - s * error[0];
  const double dr = (e * er - b * et) / determinant, dt = (a * et - b * er) / determinant;
  next[0] = q[0] - (c * dr - s * dt);
  next[1] = q[1] - (s * dr + c * dt);
  const double reached = fvv_lens_length(next);
  if (reached > r_max) {
    next[0] *= r_max / reached;
    next[1] *= r_max / reached;
  }
  return 1;
}

/* Newton's step where it at least halves the residual, else the step q -> f^-1(d - T(q)), which shrinks the
 * residual wherever fvv_lens_invertible holds. If no q of the disc maps to d, the search ends at its rim. */
int fvv_lens_undistort(const fvv_lens *lens, double r_max, const double d[2], double tolerance, double q[2]) {
  double p[2], error[2];
  if (!isfinite(fvv_lens_length(d))) return 0;
  const double outside = radial_inverse(lens, r_max, d, q);
  if (!tangential_terms(lens, p)) return fabs(outside) <= tolerance;
  double size = residual(lens, q, d, error);
  for (int i = 0; i < 60 && size > 0; i++) {
    double next[2], next_error[2], next_size = size;
    if (newton_step(lens, r_max, q, error, next)) next_size = residual(lens, next, d, next_error);
    if (!(next_size < 0.5 * size)) {
      if (size <= tolerance) break;
      double radial[2];
      tangential_part(p, q, radial);
      radial[0] = d[0] - radial[0];
      radial[1] = d[1] - radial[1];
      radial_inverse(lens, r_max, radial, next);
      next_size = residual(lens, next, d, next_error);
      if (!(next_size < size)) break;
    }
    memcpy(q, next, sizeof next);
    memcpy(error, next_error, sizeof next_error);
    size = next_size;
  }
  return size <= tolerance;
}
