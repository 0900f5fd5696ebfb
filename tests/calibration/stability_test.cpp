// calibration/: cameras for which coding is hard, each named in a printed table with its error at the corners
// of the scene and its bytes; one group of 25 frames each, the steps chosen for 0.01 pixels.
#include "cameras.h"

#include "fvv_catch.h"

#include <cstdio>
#include <functional>
#include <memory>

namespace {

constexpr int frames = 25;
constexpr double bound = 0.05;          // pixels
constexpr double corner[3] = {3, 2, 3}; // metres: the scene reaches from -corner to corner
constexpr double position_step = 0.0001;

using Handle = std::unique_ptr<fvv_calibration, void (*)(fvv_calibration *)>;
Handle handle_of(const std::vector<fvv_camera> &cameras) {
  fvv_calibration *created = nullptr;
  REQUIRE(fvv_calibration_create(cameras.data(), cameras.size(), nullptr, &created) == FVV_OK);
  return Handle(created, fvv_calibration_destroy);
}

// At a place, turned about y and then by tilt about x; near the scene's middle for all angles.
fvv_camera looking(fvv_camera c, double angle, double distance, double tilt = 0) {
  const double s = std::sin(angle), k = std::cos(angle), u = std::sin(tilt), v = std::cos(tilt);
  const double r[9] = {k, 0, s, u * s, v, -u * k, -v * s, u, v * k};
  std::copy(r, r + 9, c.rotation);
  c.translation[0] = c.translation[1] = 0;
  c.translation[2] = distance;
  c.flags = FVV_CAMERA_MOVES;
  return c;
}

struct Outcome {
  double worst = 0; // pixels, of points two metres in front and more
  double near = 0;  // of nearer ones, metres on the plane through the point
  size_t points = 0, bytes = 0;
};

// Points of the scene that the picture, or what is around it by half its size, shows.
void compare(const fvv_camera &before, const fvv_camera &after, Outcome &outcome) {
  constexpr int steps = 6;
  for (int i = 0; i <= steps * steps * steps + steps * steps + steps; i++) {
    const int at[3] = {i % (steps + 1), i / (steps + 1) % (steps + 1), i / (steps + 1) / (steps + 1)};
    double point[3], a[2], b[2], depth;
    for (int k = 0; k < 3; k++) point[k] = corner[k] * (2.0 * at[k] / steps - 1);
    if (!fvv_camera_project(&before, point, a, &depth)) continue;
    const double margin = before.width / 2.0;
    if (a[0] < -margin || a[1] < -margin || a[0] > before.width + margin || a[1] > before.height + margin)
      continue;
    if (!fvv_camera_project(&after, point, b, nullptr)) continue; // within the last step of r_max
    // The centre is off by a share of a millimetre, which is many pixels where the scene touches the camera.
    const double off = std::hypot(a[0] - b[0], a[1] - b[1]);
    if (depth > 2)
      outcome.worst = std::fmax(outcome.worst, off);
    else
      outcome.near = std::fmax(outcome.near, off * depth / before.fx);
    outcome.points++;
  }
}

using Path = std::function<fvv_camera(int frame)>;

Outcome run(const Path &path, size_t count) {
  const auto at = [&](int frame) {
    std::vector<fvv_camera> cameras(count, path(frame));
    for (size_t i = 0; i < count; i++) cameras[i].id = (uint16_t)(3 * i);
    return cameras;
  };
  std::vector<fvv_camera> all;
  for (int frame = 0; frame < frames; frame++) all.push_back(path(frame));
  fvv_calibration_bits bits;
  fvv_calibration_choose(all.data(), all.size(), position_step, 0.01, &bits);
  const Handle writer = handle_of(at(0)), reader = handle_of(at(0));
  Outcome outcome;
  for (int frame = 0; frame < frames; frame++) {
    const std::vector<fvv_camera> cameras = at(frame);
    fvv_bytes payload = {};
    fvv_diagnostic diagnostic = {};
    fvv_status status =
        fvv_calibration_encode(writer.get(), &bits, cameras.data(), count, frame == 0, &payload, &diagnostic);
    INFO(diagnostic.message);
    REQUIRE(status == FVV_OK);
    REQUIRE(fvv_calibration_decode(reader.get(), payload.data, payload.size, frame == 0, &diagnostic) ==
            FVV_OK);
    outcome.bytes += payload.size;
    fvv_bytes_free(&payload);
    for (const fvv_camera &camera : cameras) {
      fvv_camera there = {};
      REQUIRE(fvv_calibration_camera(reader.get(), camera.id, &there) == FVV_OK);
      REQUIRE(fvv_camera_validate(&there, nullptr) == FVV_OK);
      compare(camera, there, outcome);
    }
  }
  return outcome;
}

} // namespace

TEST_CASE("hard cameras come back within a twentieth of a pixel at the corners of the scene") {
  const fvv_camera plain = camera_with(FVV_LENS_NONE, {});
  const fvv_camera radtan = camera_with(FVV_LENS_RADTAN, {-0.08, 0.01});
  fvv_camera folding = camera_with(FVV_LENS_RADTAN, {-0.4});
  folding.fx = folding.fy = 600; // the fold at r = 0.91 lies within the picture
  folding.r_max = fvv_camera_r_max(&folding);
  struct Case {
    const char *name;
    size_t cameras;
    Path path;
  };
  const auto pan = [&](int i) { return looking(radtan, 0.03 * i, 8); };
  const std::vector<Case> cases = {
      {"pan", 1, pan},
      {"7 cameras", 7, pan},
      {"32 cameras", 32, pan},
      {"64 cameras", 64, pan},
      {"camera inside the scene", 1, [&](int i) { return looking(radtan, 0.2 * i, 0.5); }},
      {"camera on a corner of the scene", 1, [&](int i) { return looking(radtan, 0.785 + 0.001 * i, 4.25); }},
      {"principal point beside the picture", 1,
       [&](int i) {
         fvv_camera c = looking(plain, 0.03 * i, 8);
         c.cx = -900 - i;
         c.cy = 1400;
         return c;
       }},
      {"turn through 180 degrees", 1, [&](int i) { return looking(radtan, M_PI + 0.02 * (i - 12), 8); }},
      {"turn by 180 degrees a frame", 1, [&](int i) { return looking(radtan, M_PI * i, 8); }},
      {"180 degrees with rounding", 1,
       [&](int i) { return looking(radtan, M_PI + 1e-9 * (i - 12), 8, 1e-10); }},
      {"looking straight down and over", 1,
       [&](int i) { return looking(radtan, 0.4, 8, M_PI / 2 + 0.01 * (i - 12)); }},
      {"zoom by 10 within the group", 1,
       [&](int i) {
         fvv_camera c = looking(radtan, 0, 8);
         c.fx *= std::pow(10, i / 24.0);
         c.fy *= std::pow(10, i / 24.0);
         c.r_max = fvv_camera_r_max(&c);
         return c;
       }},
      {"k1 = -0.4", 1, [&](int i) { return looking(folding, 0.02 * i, 6); }},
  };
  std::printf("%-38s %-9s %-8s %s\n", "case", "worst px", "points", "bytes/frame");
  for (const Case &one : cases) {
    const Outcome outcome = run(one.path, one.cameras);
    std::printf("%-38s %-9.4f %-8zu %.1f\n", one.name, outcome.worst, outcome.points,
                double(outcome.bytes) / frames);
    CAPTURE(one.name);
    CHECK(outcome.points > 100);
    CHECK(outcome.worst < bound);
    CHECK(outcome.worst > 0);
    CHECK(outcome.near < position_step);
    CHECK(double(outcome.bytes) / frames / double(one.cameras) < 60);
  }
}

TEST_CASE("points behind a camera, on its plane and beyond the fold are not projected") {
  fvv_camera folding = camera_with(FVV_LENS_RADTAN, {-0.4});
  folding.fx = folding.fy = 600;
  folding.r_max = fvv_camera_r_max(&folding);
  CHECK(folding.r_max == Approx(std::sqrt(1 / 1.2)).epsilon(1e-9));
  for (int i = 0; i < 9; i++) folding.rotation[i] = i % 4 == 0;
  std::fill_n(folding.translation, 3, 0.0);
  fvv_camera aside = folding; // its principal point beside the picture
  aside.cx = -900;
  aside.r_max = fvv_camera_r_max(&aside);
  struct Point {
    const char *name;
    double at[3];
    int seen;
  };
  const Point points[] = {{"in front", {0.1, 0.1, 1}, 1},
                          {"behind", {0.1, 0.1, -1}, 0},
                          {"the camera itself", {0, 0, 0}, 0},
                          {"on the plane", {1, 0, 0}, 0},
                          {"just before the plane", {1, 0, 1e-300}, 0},
                          {"just within the fold", {0.9128, 0, 1}, 1},
                          {"just beyond the fold", {0.9130, 0, 1}, 0},
                          {"folded into the picture's middle", {1.58, 0, 1}, 0}};
  for (const fvv_camera *camera : {&folding, &aside})
    for (const Point &point : points) {
      double pixel[2];
      CAPTURE(point.name, camera->cx);
      CHECK(fvv_camera_project(camera, point.at, pixel, nullptr) == point.seen);
      CHECK(std::isfinite(pixel[0]) == (point.seen != 0));
    }
}
