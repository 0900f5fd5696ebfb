// calibration/: points to pixels and back, against the formulas of clause 9.1 in long double, and up to where
// a lens can be inverted.
#include "cameras.h"
#include "fvv_catch.h"

#include <limits>
#include <random>

namespace {

const double infinity = std::numeric_limits<double>::infinity();
const double nan_value = std::numeric_limits<double>::quiet_NaN();

// A ray of the camera frame at an undistorted radius (fisheye: angle) and direction.
void ray_at(const fvv_camera &c, double radius, double direction, double ray[3]) {
  const double r = c.lens == FVV_LENS_FISHEYE ? std::tan(radius) : radius;
  ray[0] = r * std::cos(direction);
  ray[1] = r * std::sin(direction);
  ray[2] = 1;
}

double distance(const double a[2], const long double b[2]) {
  return (double)std::hypot(a[0] - b[0], a[1] - b[1]);
}

} // namespace

TEST_CASE("points up to r_max project as the formulas say and come back within 1e-9 pixels") {
  for (const auto &[name, c] : lenses()) {
    CAPTURE(name);
    REQUIRE(fvv_camera_validate(&c, nullptr) == FVV_OK);
    double worst_project = 0, worst_return = 0;
    int refused = 0;
    const double end = std::isinf(c.r_max) ? 3 : c.r_max;
    for (int i = 0; i <= 120; i++)
      for (int j = 0; j < 48; j++) {
        // Denser towards r_max, where the lens is hardest to invert.
        const double share = 1 - std::pow(1 - i / 120.0, 3);
        double ray[3], point[3], world[3], pixel[2], depth, back[3];
        long double expected[2];
        ray_at(c, end * (1 - 1e-14) * share, 0.1309 * j, ray);
        // At one distance, not at one depth: rays near 90 degrees would run out of digits.
        const double scale = 2.75 / std::sqrt(ray[0] * ray[0] + ray[1] * ray[1] + 1);
        for (int k = 0; k < 3; k++) point[k] = scale * ray[k];
        to_world(c, point, world);
        if (!fvv_camera_project(&c, world, pixel, &depth)) {
          // Rounding on the way through the world may carry the last ring over the edge.
          refused += share < 1 ? 1000 : 1;
          continue;
        }
        REQUIRE(depth == Approx(point[2]).margin(1e-14));
        reference_pixel(c, point, expected);
        worst_project = std::max(worst_project, distance(pixel, expected));
        REQUIRE(fvv_camera_unproject(&c, pixel, back) == 1);
        REQUIRE(back[2] == 1);
        reference_pixel(c, back, expected);
        worst_return = std::max(worst_return, distance(pixel, expected));
      }
    CAPTURE(c.r_max);
    CHECK(refused <= 48);
    CHECK(worst_project < 1e-9);
    CHECK(worst_return < 1e-9);
  }
}

TEST_CASE("every pixel of the picture that has a ray gives the pixel again, and its ray is within r_max") {
  for (const auto &[name, c] : lenses()) {
    CAPTURE(name);
    double worst = 0;
    int answered = 0;
    for (double v = 0; v <= c.height; v += 13.5)
      for (double u = 0; u <= c.width; u += 24) {
        const double pixel[2] = {u, v};
        double ray[3];
        long double expected[2];
        if (!fvv_camera_unproject(&c, pixel, ray)) {
          REQUIRE(std::isnan(ray[0]));
          continue;
        }
        answered++;
        const double r = std::hypot(ray[0], ray[1]), radius = c.lens == FVV_LENS_FISHEYE ? std::atan(r) : r;
        REQUIRE(radius <= c.r_max * (1 + 1e-12));
        reference_pixel(c, ray, expected);
        worst = std::max(worst, distance(pixel, expected));
      }
    CHECK(answered > 1900); // of 6561: the corners of two lenses are beyond their fold
    CHECK(worst < 1e-9);
  }
}

TEST_CASE("a pixel comes back as the ray that made it, not as another one") {
  for (const auto &[name, c] : lenses()) {
    CAPTURE(name);
    double worst = 0;
    for (int i = 0; i <= 95; i++)
      for (int j = 0; j < 24; j++) {
        double ray[3], back[3];
        long double pixel[2];
        ray_at(c, c.r_max * i / 100, 0.2618 * j, ray);
        reference_pixel(c, ray, pixel);
        const double rounded[2] = {(double)pixel[0], (double)pixel[1]};
        REQUIRE(fvv_camera_unproject(&c, rounded, back) == 1);
        // The angle between the two rays, which stays meaningful near 90 degrees.
        const double x = ray[1] - back[1], y = back[0] - ray[0], z = ray[0] * back[1] - ray[1] * back[0];
        const double sine =
            std::sqrt(x * x + y * y + z * z) /
            std::sqrt((1 + ray[0] * ray[0] + ray[1] * ray[1]) * (1 + back[0] * back[0] + back[1] * back[1]));
        worst = std::max(worst, sine);
      }
    CHECK(worst < 1e-10);
  }
}

TEST_CASE("strong tangential terms are undone up to the rim, where plain Newton steps leave the disc") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(-1, 1);
  int refused = 0;
  double worst = 0;
  for (int n = 0; n < 1000; n++) {
    fvv_camera c = camera_with(FVV_LENS_RADTAN, {-0.5 * std::fabs(any(random)), 0.2 * any(random),
                                                 0.3 * any(random), 0.3 * any(random)});
    c.fx = c.fy = 500;
    c.r_max = fvv_camera_r_max(&c);
    REQUIRE(fvv_camera_validate(&c, nullptr) == FVV_OK);
    for (int j = 0; j < 30; j++) {
      double ray[3], back[3];
      long double pixel[2];
      ray_at(c, c.r_max * (1 - std::pow(10.0, -0.4 * j)), 3.2 * any(random), ray);
      reference_pixel(c, ray, pixel);
      const double rounded[2] = {(double)pixel[0], (double)pixel[1]};
      if (!fvv_camera_unproject(&c, rounded, back)) {
        refused++;
        continue;
      }
      reference_pixel(c, back, pixel);
      worst = std::max(worst, distance(rounded, pixel));
    }
  }
  CHECK(refused == 0);
  CHECK(worst < 1e-9);
}

TEST_CASE("points from which Newton's method alone runs to the rim and stays there come back") {
  const struct {
    fvv_camera camera;
    double x, y;
  } cases[] = {
      {camera_with(FVV_LENS_RADTAN, {-0.30412839274114378, -0.076579834649609338, 0.042414785242832639,
                                     -0.25443897980937685, 0, -0.76579834649609335, 0.14138261747610881}),
       1.1862065820792784, -0.25535644568282434},
      {camera_with(FVV_LENS_RADTAN, {-0.78011607321915966, -0.078645460623617047, -0.18618277045254725,
                                     0.22674366325454023, 0, -0.78645460623617036, -0.62060923484182418}),
       -0.75823268415306222, 0.063722991767465251},
  };
  for (auto [c, x, y] : cases) {
    c.fx = c.fy = 300;
    c.r_max = fvv_camera_r_max(&c);
    const double ray[3] = {x, y, 1};
    REQUIRE(std::hypot(x, y) < 0.95 * c.r_max);
    double back[3];
    long double pixel[2];
    reference_pixel(c, ray, pixel);
    const double rounded[2] = {(double)pixel[0], (double)pixel[1]};
    REQUIRE(fvv_camera_unproject(&c, rounded, back) == 1);
    CHECK(back[0] == Approx(x).margin(1e-11));
    CHECK(back[1] == Approx(y).margin(1e-11));
  }
}

TEST_CASE("a lens with a pole is inverted below it, even when r_max is at the pole") {
  for (const double tangential : {0.0, 0.19}) {
    fvv_camera c = camera_with(
        FVV_LENS_RADTAN, {1.67822, 0.0662941, -0.268252 * tangential, tangential, 0, 0.662941, -0.894173, 0});
    // The positive zero of 1 + k4 s + k5 s^2, and a little more within the allowance of validate.
    const double k4 = c.distortion[5], k5 = c.distortion[6];
    const double pole = std::sqrt((-k4 - std::sqrt(k4 * k4 - 4 * k5)) / (2 * k5));
    c.r_max = pole * (1 + 5e-10);
    REQUIRE(fvv_camera_validate(&c, nullptr) == FVV_OK);
    for (int i = 0; i <= 95; i++) {
      double ray[3], back[3];
      long double pixel[2];
      ray_at(c, pole * i / 100, 0.1 * i, ray);
      reference_pixel(c, ray, pixel);
      const double rounded[2] = {(double)pixel[0], (double)pixel[1]};
      REQUIRE(fvv_camera_unproject(&c, rounded, back) == 1);
      REQUIRE(back[0] == Approx(ray[0]).margin(1e-12));
      REQUIRE(back[1] == Approx(ray[1]).margin(1e-12));
    }
  }
}

TEST_CASE("pixels beyond the picture of r_max have no ray") {
  for (const auto &[name, c] : lenses()) {
    CAPTURE(name);
    double ray[3];
    for (int j = 0; j < 24; j++) {
      double edge[3];
      long double pixel[2];
      ray_at(c, c.r_max, 0.2618 * j, edge);
      reference_pixel(c, edge, pixel);
      const double outside[2] = {(double)(pixel[0] + (pixel[0] - c.cx) * 1e-6L),
                                 (double)(pixel[1] + (pixel[1] - c.cy) * 1e-6L)};
      CHECK(fvv_camera_unproject(&c, outside, ray) == 0);
    }
    for (const double bad : {nan_value, infinity, -infinity, 1e300, -1e200}) {
      const double u[2] = {bad, 500}, v[2] = {500, bad};
      CHECK(fvv_camera_unproject(&c, u, ray) == 0);
      CHECK(fvv_camera_unproject(&c, v, ray) == 0);
    }
  }
}

TEST_CASE("points behind the camera, beyond r_max or not finite have no pixel") {
  for (const auto &[name, c] : lenses()) {
    CAPTURE(name);
    const auto projects = [&c = c](double x, double y, double z) {
      const double point[3] = {x, y, z};
      double world[3], pixel[2], depth;
      to_world(c, point, world);
      const int answer = fvv_camera_project(&c, world, pixel, &depth);
      if (!answer) REQUIRE((std::isnan(pixel[0]) && std::isnan(pixel[1])));
      if (answer) REQUIRE((std::isfinite(pixel[0]) && std::isfinite(pixel[1])));
      return answer;
    };
    CHECK(projects(0, 0, 1) == 1);
    CHECK(projects(0, 0, -1) == 0);
    CHECK(projects(0.1, 0.1, -1e-3) == 0);
    CHECK(projects(1, 0, 1e-14) == 0);
    double edge[3];
    ray_at(c, c.r_max, 0.3, edge);
    CHECK(projects(edge[0] * 0.999, edge[1] * 0.999, 1) == 1);
    CHECK(projects(edge[0] * 1.001, edge[1] * 1.001, 1) == 0);
    for (const double bad : {nan_value, infinity, -infinity, 1e308}) {
      const double world[3] = {bad, 0, 0};
      double pixel[2];
      CHECK(fvv_camera_project(&c, world, pixel, nullptr) == 0);
    }
  }
}

TEST_CASE("near the camera plane an unbounded pinhole returns finite pixels or none") {
  fvv_camera c = camera_with(FVV_LENS_NONE, {});
  c.r_max = infinity;
  for (int i = 0; i < 9; i++) c.rotation[i] = i % 4 == 0;
  for (double &t : c.translation) t = 0;
  REQUIRE(fvv_camera_validate(&c, nullptr) == FVV_OK);
  int answered = 0;
  for (int e = 0; e > -330; e -= 5) {
    const double world[3] = {0.5, -0.25, std::pow(10.0, e)};
    double pixel[2], depth;
    const int answer = fvv_camera_project(&c, world, pixel, &depth);
    CHECK(depth == world[2]);
    CHECK(std::isfinite(pixel[0]) == (answer == 1));
    answered += answer;
  }
  CHECK(answered > 10);
  CHECK(answered < 66);
  const double on_plane[3] = {0, 0, 0};
  double pixel[2];
  CHECK(fvv_camera_project(&c, on_plane, pixel, nullptr) == 0);
}

TEST_CASE("the principal axis meets the principal point, and the centre of the camera is where it stands") {
  for (const auto &[name, c] : lenses()) {
    CAPTURE(name);
    const double axis[3] = {0, 0, 3}, origin[3] = {0, 0, 0};
    double world[3], pixel[2], ray[3], centre[3], expected[3];
    to_world(c, axis, world);
    REQUIRE(fvv_camera_project(&c, world, pixel, nullptr) == 1);
    CHECK(pixel[0] == Approx(c.cx).epsilon(1e-12));
    CHECK(pixel[1] == Approx(c.cy).epsilon(1e-12));
    const double point[2] = {c.cx, c.cy};
    REQUIRE(fvv_camera_unproject(&c, point, ray) == 1);
    CHECK(ray[0] == 0);
    CHECK(ray[1] == 0);
    to_world(c, origin, expected);
    fvv_camera_centre(&c, centre);
    for (int i = 0; i < 3; i++) CHECK(centre[i] == Approx(expected[i]).epsilon(1e-14));
  }
}

// ---- calibration/: up to where a lens can be inverted.

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
  // The two zeros are 5e-4 apart: sampling would mostly miss them.
  const double k2 = 1.44 / 20 - 1e-8, near = (1.2 - std::sqrt(1.44 - 20 * k2)) / (10 * k2);
  CHECK(wide(FVV_LENS_RADTAN, {-0.4, k2}).r_max == Approx(std::sqrt(near)).epsilon(1e-9));
  // The denominator 1 + k4 r^2 has a zero, below which f rises without bound.
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
