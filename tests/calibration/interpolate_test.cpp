// calibration/: a camera between two of its moments.
#include "cameras.h"

#include "fvv_catch.h"

#include <cstring>

namespace {

fvv_camera turned(fvv_camera c, double angle) { // about y
  const double s = std::sin(angle), k = std::cos(angle), r[9] = {k, 0, s, 0, 1, 0, -s, 0, k};
  std::copy(r, r + 9, c.rotation);
  return c;
}

fvv_camera at(const fvv_camera &a, const fvv_camera &b, double t) {
  fvv_camera out = {};
  REQUIRE(fvv_camera_interpolate(&a, &b, t, &out) == FVV_OK);
  REQUIRE(fvv_camera_validate(&out, nullptr) == FVV_OK);
  return out;
}

double angle_of(const fvv_camera &c) {
  return std::atan2(c.rotation[2], c.rotation[0]);
}

} // namespace

TEST_CASE("a turn goes on evenly along the shorter arc, whatever signs its quaternions have") {
  const fvv_camera base = camera_with(FVV_LENS_NONE, {});
  struct Turn {
    const char *name;
    double from, to;
  };
  for (const Turn &turn : {Turn{"a degree", 0, 0.0175},
                           {"nothing", 0.3, 0.3},
                           {"over 180 degrees", 3.0, 3.4},
                           {"nearly half round", 0, 3.1415},
                           {"back", 2.0, -1.0}}) {
    CAPTURE(turn.name);
    const fvv_camera a = turned(base, turn.from), b = turned(base, turn.to);
    for (int i = 0; i <= 10; i++) {
      const double wanted = turn.from + (turn.to - turn.from) * i / 10;
      CHECK(std::remainder(angle_of(at(a, b, i / 10.0)) - wanted, 2 * M_PI) == Approx(0).margin(1e-9));
    }
  }
}

TEST_CASE("between turns by 180 degrees is a turn by 90, either way round") {
  const fvv_camera a = turned(camera_with(FVV_LENS_NONE, {}), 0), b = turned(a, M_PI);
  CHECK(std::fabs(angle_of(at(a, b, 0.5))) == Approx(M_PI / 2).margin(1e-9));
}

TEST_CASE("the centre goes straight and a zoom evenly by factors") {
  fvv_camera a = turned(camera_with(FVV_LENS_RADTAN, {-0.2, 0.05}), 0), b = turned(a, 1);
  double from[3], to[3];
  b.translation[0] = 7;
  b.fx = 10 * a.fx;
  b.fy = 10 * a.fy;
  b.cx = a.cx + 8;
  b.distortion[0] = -0.1;
  b.r_max = a.r_max / 2;
  fvv_camera_centre(&a, from);
  fvv_camera_centre(&b, to);
  for (const double t : {0.25, 0.5, 0.75}) {
    const fvv_camera c = at(a, b, t);
    double centre[3];
    fvv_camera_centre(&c, centre);
    for (int i = 0; i < 3; i++) CHECK(centre[i] == Approx(from[i] + t * (to[i] - from[i])).margin(1e-9));
    CHECK(c.fx == Approx(a.fx * std::pow(10, t)));
    CHECK(c.fy == Approx(a.fy * std::pow(10, t)));
    CHECK(c.cx == Approx(a.cx + 8 * t));
    CHECK(c.distortion[0] == Approx(-0.2 + 0.1 * t));
    CHECK(c.r_max == b.r_max);
  }
}

TEST_CASE("the ends are the moments themselves, and cameras between all lenses are valid") {
  for (const named_camera &lens : lenses()) {
    CAPTURE(lens.name);
    const fvv_camera a = lens.camera;
    fvv_camera b = turned(a, 0.4);
    b.fx *= 1.5;
    for (double &k : b.distortion) k *= 0.8;
    b.r_max = fvv_camera_r_max(&b);
    const fvv_camera first = at(a, b, 0), last = at(a, b, 1);
    CHECK(std::memcmp(first.rotation, a.rotation, sizeof a.rotation) == 0);
    CHECK(std::memcmp(last.translation, b.translation, sizeof b.translation) == 0);
    CHECK((first.fx == a.fx && last.fx == b.fx && last.r_max == b.r_max));
    for (const double t : {0.1, 0.5, 0.9}) CHECK(at(a, b, t).r_max <= std::fmin(a.r_max, b.r_max));
  }
}

TEST_CASE("unlike cameras, and times beyond the two, are refused") {
  const fvv_camera a = camera_with(FVV_LENS_NONE, {});
  fvv_camera out = {};
  for (const double t : {-0.1, 1.1, (double)NAN})
    CHECK(fvv_camera_interpolate(&a, &a, t, &out) == FVV_ERROR_ARGUMENT);
  fvv_camera id = a, lens = camera_with(FVV_LENS_RADTAN, {}), size = a;
  id.id++;
  size.width++;
  for (const fvv_camera *b : {&id, &lens, &size})
    CHECK(fvv_camera_interpolate(&a, b, 0.5, &out) == FVV_ERROR_ARGUMENT);
  CHECK(out.width == 0);
}
