// calibration/: up to where a lens can be inverted.
#include "cameras.h"

#include "fvv_catch.h"

#include <limits>
#include <random>

namespace {

// f(r) of clause 9.1 without the tangential part.
long double radial(const fvv_camera &c, long double r) {
  const double *k = c.distortion;
  const long double s = r * r;
  if (c.lens == FVV_LENS_NONE) return r;
  if (c.lens == FVV_LENS_FISHEYE) return r * (1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))));
  return r * (1 + s * (k[0] + s * (k[1] + s * k[4]))) / (1 + s * (k[5] + s * (k[6] + s * k[7])));
}

fvv_status accepts(fvv_camera c, double r_max) {
  c.r_max = r_max;
  fvv_diagnostic d;
  const fvv_status status = fvv_camera_validate(&c, &d);
  if (status != FVV_OK) REQUIRE(d.issue == FVV_ISSUE_CAMERA_R_MAX);
  return status;
}

fvv_camera wide(int lens, std::initializer_list<double> coefficients) {
  fvv_camera c = camera_with(lens, coefficients);
  c.fx = c.fy = 300; // the corner is at 3.6: further than any lens below can be followed
  c.r_max = fvv_camera_r_max(&c);
  return c;
}

} // namespace

TEST_CASE("r_max is where the derivative has its first zero") {
  // 1 + 3 k1 r^2 = 0.
  CHECK(wide(FVV_LENS_RADTAN, {-0.4}).r_max == Approx(std::sqrt(1 / 1.2)).epsilon(1e-12));
  // 1 + 3 k1 r^2 + 5 k2 r^4 = 0, the lesser of two zeros.
  const double s = (1.2 - std::sqrt(1.44 - 20 * 0.06)) / (10 * 0.06);
  CHECK(wide(FVV_LENS_RADTAN, {-0.4, 0.06}).r_max == Approx(std::sqrt(s)).epsilon(1e-12));
  // The two zeros are 5e-4 apart: nothing but luck would find them by sampling.
  const double k2 = 1.44 / 20 - 1e-8, near = (1.2 - std::sqrt(1.44 - 20 * k2)) / (10 * k2);
  CHECK(wide(FVV_LENS_RADTAN, {-0.4, k2}).r_max == Approx(std::sqrt(near)).epsilon(1e-9));
  // The denominator 1 + k4 r^2 has a zero, in front of which f rises without bound.
  CHECK(accepts(wide(FVV_LENS_RADTAN, {0.2, 0, 0, 0, 0, -0.5}), std::sqrt(2.0) * 0.999) == FVV_OK);
  CHECK(accepts(wide(FVV_LENS_RADTAN, {0.2, 0, 0, 0, 0, -0.5}), std::sqrt(2.0) * 1.001) == FVV_ERROR_INVALID);
  // Numerator and denominator vanish together: f(r) = r but for the hole, which is refused.
  CHECK(accepts(wide(FVV_LENS_RADTAN, {-0.5, 0, 0, 0, 0, -0.5}), 1.42) == FVV_ERROR_INVALID);
  // Fisheye: 1 + 3 k1 a^2 = 0.
  CHECK(wide(FVV_LENS_FISHEYE, {-0.2}).r_max == Approx(std::sqrt(1 / 0.6)).epsilon(1e-12));
}

TEST_CASE("r_max of a lens that rises everywhere is what the farthest corner needs times 1.25") {
  fvv_camera c = camera_with(FVV_LENS_NONE, {});
  const double corner = std::hypot(c.cx / c.fx, (c.height - c.cy) / c.fy);
  CHECK(c.r_max == Approx(1.25 * corner).epsilon(1e-12));

  c = camera_with(FVV_LENS_RADTAN, {0.3, 0.05});
  CHECK((double)radial(c, c.r_max / 1.25) == Approx(corner).epsilon(1e-12));

  c = camera_with(FVV_LENS_FISHEYE, {0.01});
  CHECK((double)radial(c, c.r_max / 1.25) == Approx(corner).epsilon(1e-12));
  c.fx = c.fy = 600; // its corner is beyond 90 degrees
  CHECK(fvv_camera_r_max(&c) < 1.5707963267948966);
  CHECK(fvv_camera_r_max(&c) > 1.5707963);

  // A fisheye that turns beyond 90 degrees, whose picture ends before the corner does.
  c = camera_with(FVV_LENS_FISHEYE, {-0.1});
  c.fx = c.fy = 850;
  CHECK((double)radial(c, 1.5707963267948966) < std::hypot(c.cx, c.height - c.cy) / 850);
  CHECK(fvv_camera_r_max(&c) < 1.5707963267948966);
  CHECK(fvv_camera_r_max(&c) > 1.5707963);

  // Between corner and 1.25 times as far the lens folds.
  c = camera_with(FVV_LENS_RADTAN, {-0.5});
  const double fold = std::sqrt(1 / 1.5);
  CHECK((double)radial(c, fold) > corner * 0.7);
  CHECK(c.r_max <= fold);
  CHECK(c.r_max == Approx(fold).epsilon(1e-9));

  // f goes to 1/2 and never reaches a corner at 3.6: the search ends.
  c = wide(FVV_LENS_RADTAN, {0, 0, 0, 0, 0, 1e-30, 0, 0});
  CHECK(std::isfinite(c.r_max));
  c = wide(FVV_LENS_RADTAN, {1, 0, 0, 0, 0, 3, 0.2, 0});
  CHECK(c.r_max > 0);
  CHECK(accepts(c, c.r_max) == FVV_OK);
}

TEST_CASE("validate refuses an r_max beyond the fold, with a relative allowance of 1e-9") {
  const fvv_camera c = wide(FVV_LENS_RADTAN, {-0.4});
  const double fold = std::sqrt(1 / 1.2);
  CHECK(accepts(c, fold * (1 + 5e-10)) == FVV_OK);
  CHECK(accepts(c, fold * (1 + 5e-9)) == FVV_ERROR_INVALID);
  CHECK(accepts(c, 1.2) == FVV_ERROR_INVALID);
  CHECK(accepts(c, 1e-6) == FVV_OK);
  for (const double bad : {0.0, -0.5, std::nan(""), -std::numeric_limits<double>::infinity(),
                           std::numeric_limits<double>::infinity(), 1e200})
    CHECK(accepts(c, bad) == FVV_ERROR_INVALID);

  const fvv_camera fisheye = wide(FVV_LENS_FISHEYE, {0.01});
  CHECK(accepts(fisheye, 1.57) == FVV_OK);
  CHECK(accepts(fisheye, 1.5707963267948966) == FVV_ERROR_INVALID);

  const fvv_camera pinhole = camera_with(FVV_LENS_NONE, {});
  CHECK(accepts(pinhole, std::numeric_limits<double>::infinity()) == FVV_OK);
  CHECK(accepts(pinhole, std::nan("")) == FVV_ERROR_INVALID);

  const fvv_camera overflowing = wide(FVV_LENS_RADTAN, {1e308, -1e308, 0, 0, 1e308, 1e308});
  CHECK(overflowing.r_max == 0);
  CHECK(accepts(overflowing, 1) == FVV_ERROR_INVALID);
}

TEST_CASE("random lenses rise up to r_max and, where r_max is a fold, no longer beyond it") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  int folds = 0;
  for (int n = 0; n < 400; n++) {
    const int fisheye = n % 4 == 0;
    fvv_camera c = fisheye
                       ? wide(FVV_LENS_FISHEYE, {any(random) / 4, any(random) / 8, any(random) / 16, 0.01})
                       : wide(FVV_LENS_RADTAN, {any(random), any(random), 0, 0, any(random) / 2,
                                                n % 2 ? any(random) : 0, n % 2 ? any(random) : 0, 0});
    CAPTURE(n, c.r_max);
    REQUIRE(c.r_max > 0);
    REQUIRE(accepts(c, c.r_max) == FVV_OK);
    int falls = 0;
    long double former = 0;
    for (int i = 1; i <= 2000; i++) {
      const long double value = radial(c, (long double)c.r_max * i / 2000);
      falls += value <= former;
      former = value;
    }
    REQUIRE(falls == 0);
    if (accepts(c, c.r_max * 1.0001) == FVV_OK || (fisheye && c.r_max > 1.5707)) continue;
    folds++;
    const long double past = radial(c, c.r_max * (1 + 1e-3L)), beyond = radial(c, c.r_max * (1 + 2e-3L));
    REQUIRE((beyond < past || past < 0 || beyond < 0));
  }
  CHECK(folds > 100);
}

TEST_CASE("with tangential terms r_max stays where the map is one to one") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int n = 0; n < 200; n++) {
    const fvv_camera c = wide(FVV_LENS_RADTAN, {-0.1 - 0.4 * std::fabs(any(random)), 0.05 * any(random),
                                                0.02 * any(random), 0.02 * any(random)});
    const double p1 = c.distortion[2], p2 = c.distortion[3];
    CAPTURE(n, c.r_max);
    REQUIRE(accepts(c, c.r_max) == FVV_OK);
    for (int j = 0; j < 64; j++) {
      // Differences of the full map in long double: determinant of its Jacobian just inside the rim.
      const long double a = 0.0981747704L * j, r = c.r_max * (1 - 1e-6L), h = 1e-7L;
      long double d[2][2];
      for (int axis = 0; axis < 2; axis++) {
        long double f[2][2];
        for (int side = 0; side < 2; side++) {
          const long double step = side ? h : -h;
          const long double x = r * std::cos(a) + (axis == 0 ? step : 0),
                            y = r * std::sin(a) + (axis == 1 ? step : 0);
          const long double q = std::sqrt(x * x + y * y), m = radial(c, q) / q;
          f[side][0] = x * m + 2 * p1 * x * y + p2 * (q * q + 2 * x * x);
          f[side][1] = y * m + p1 * (q * q + 2 * y * y) + 2 * p2 * x * y;
        }
        for (int i = 0; i < 2; i++) d[i][axis] = (f[1][i] - f[0][i]) / (2 * h);
      }
      REQUIRE(d[0][0] * d[1][1] - d[0][1] * d[1][0] > 0);
    }
  }
}
