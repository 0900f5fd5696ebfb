// Cameras that move: payloads of CALB chunks, how exact they are, and cameras for which coding is hard.
#include "cameras.h"
#include "fvv_catch.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <random>

namespace {

using Handle = std::unique_ptr<fvv_calibration, void (*)(fvv_calibration *)>;

Handle handle_of(const std::vector<fvv_camera> &cameras) {
  fvv_calibration *created = nullptr;
  REQUIRE(fvv_calibration_create(cameras.data(), cameras.size(), nullptr, &created) == FVV_OK);
  return Handle(created, fvv_calibration_destroy);
}

std::vector<uint8_t> encode(const Handle &handle, const fvv_calibration_bits &bits,
                            const std::vector<fvv_camera> &cameras, bool key) {
  fvv_bytes payload = {};
  fvv_diagnostic diagnostic = {};
  const fvv_status status =
      fvv_calibration_encode(handle.get(), &bits, cameras.data(), cameras.size(), key, &payload, &diagnostic);
  INFO(diagnostic.message);
  REQUIRE(status == FVV_OK);
  std::vector<uint8_t> out(payload.data, payload.data + payload.size);
  fvv_bytes_free(&payload);
  return out;
}

// In a heap block of exactly that size, so that a sanitizer sees any over-read.
uint32_t decode(const Handle &handle, const std::vector<uint8_t> &payload, bool key) {
  const std::unique_ptr<uint8_t[]> exact(new uint8_t[payload.size()]);
  std::copy(payload.begin(), payload.end(), exact.get());
  fvv_diagnostic diagnostic = {};
  const fvv_status status =
      fvv_calibration_decode(handle.get(), exact.get(), payload.size(), key, &diagnostic);
  INFO(diagnostic.message);
  CHECK(status == diagnostic.status);
  CHECK((status == FVV_OK || status == FVV_ERROR_INVALID));
  CHECK((status == FVV_OK) == (diagnostic.issue == 0));
  return diagnostic.issue;
}

fvv_camera camera_in(const Handle &handle, uint16_t id) {
  fvv_camera camera = {};
  REQUIRE(fvv_calibration_camera(handle.get(), id, &camera) == FVV_OK);
  return camera;
}

// Pixels between a point's pixels in two cameras, at most, all over the picture and at several distances.
double difference(const fvv_camera &a, const fvv_camera &b) {
  double centre[3], worst = 0;
  fvv_camera_centre(&a, centre);
  for (int i = 0; i < 11 * 11; i++)
    for (const double distance : {1.0, 10.0, 1000.0}) {
      const double pixel[2] = {a.width * (i % 11) / 10.0, a.height * (i / 11) / 10.0};
      double ray[3], world[3], before[2], after[2];
      if (!fvv_camera_unproject(&a, pixel, ray)) continue;
      // Not the very edge of what the lens may do: r_max is rounded down.
      const double radius = std::hypot(ray[0], ray[1]);
      if ((a.lens == FVV_LENS_FISHEYE ? std::atan(radius) : radius) > a.r_max * (1 - 1e-6)) continue;
      for (double &x : ray) x *= distance;
      double point[3];
      for (int k = 0; k < 3; k++) point[k] = ray[k];
      to_world(a, point, world);
      if (!fvv_camera_project(&a, world, before, nullptr)) continue;
      REQUIRE(fvv_camera_project(&b, world, after, nullptr));
      worst = std::max(worst, std::hypot(before[0] - after[0], before[1] - after[1]));
    }
  return worst;
}

// A turn by an angle about an axis (Rodrigues), with the centre at a place.
void place(fvv_camera &c, const double axis[3], double angle, const double centre[3]) {
  const double length = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  const double x = axis[0] / length, y = axis[1] / length, z = axis[2] / length;
  const double s = std::sin(angle), t = 1 - std::cos(angle), k = std::cos(angle);
  const double r[9] = {t * x * x + k,     t * x * y - s * z, t * x * z + s * y,
                       t * x * y + s * z, t * y * y + k,     t * y * z - s * x,
                       t * x * z - s * y, t * y * z + s * x, t * z * z + k};
  std::copy(r, r + 9, c.rotation);
  for (int i = 0; i < 3; i++)
    c.translation[i] = -(r[3 * i] * centre[0] + r[3 * i + 1] * centre[1] + r[3 * i + 2] * centre[2]);
}

fvv_camera moving(fvv_camera camera, uint16_t id) {
  camera.id = id;
  camera.flags = FVV_CAMERA_MOVES;
  return camera;
}

constexpr fvv_calibration_bits some_bits = {20, 12, 8, 20};

} // namespace

TEST_CASE("cameras that move come back within the given pixels") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const double bound : {0.5, 0.01, 0.001})
    for (const named_camera &lens : lenses()) {
      fvv_camera camera = moving(lens.camera, 3);
      const Handle writer = handle_of({camera}), reader = handle_of({camera});
      const double focal = camera.fx;
      double worst = 0;
      for (int i = 0; i < 60; i++) {
        const double axis[3] = {any(random), any(random), any(random)};
        const double centre[3] = {20 * any(random), 20 * any(random), 20 * any(random)};
        place(camera, axis, 3.2 * any(random), centre);
        camera.fx = camera.fy = focal * (1 + 0.1 * any(random));
        camera.r_max = fvv_camera_r_max(&camera);
        fvv_calibration_bits bits;
        // At the distance of 1 m a centre that is off by d metres moves a point by f d pixels.
        fvv_calibration_choose(&camera, 1, bound / (4 * focal), bound, &bits);
        CHECK(decode(reader, encode(writer, bits, {camera}, true), true) == 0);
        const fvv_camera there = camera_in(reader, 3);
        CHECK(fvv_camera_validate(&there, nullptr) == FVV_OK);
        worst = std::max(worst, difference(camera, there));
        const fvv_camera own = camera_in(writer, 3);
        CHECK(std::memcmp(own.rotation, there.rotation, sizeof own.rotation) == 0);
      }
      INFO(lens.name << ", bound " << bound);
      CHECK(worst <= bound * 1.3); // the centre has its own share
      CHECK(worst > bound / 200);  // nor are steps wasted
    }
}

TEST_CASE("a camera that turns through 180 degrees and zooms tenfold is followed by short differences") {
  fvv_camera camera = moving(camera_with(FVV_LENS_RADTAN, {-0.08, 0.01}), 3);
  std::vector<fvv_camera> path;
  for (int i = 0; i <= 100; i++) {
    const double axis[3] = {0.02, 1, 0.01}, centre[3] = {0.01 * i, 1.5, -8};
    place(camera, axis, 3.6 * i / 50, centre); // twice through 180 degrees
    camera.fx = 800 * std::pow(10, i / 100.0);
    camera.fy = 1.001 * camera.fx;
    camera.r_max = fvv_camera_r_max(&camera);
    path.push_back(camera);
  }
  fvv_calibration_bits bits;
  fvv_calibration_choose(path.data(), path.size(), 1e-5, 0.01, &bits);
  const Handle writer = handle_of({camera}), reader = handle_of({camera});
  size_t key = 0, longest = 0;
  for (size_t i = 0; i < path.size(); i++) {
    const std::vector<uint8_t> payload = encode(writer, bits, {path[i]}, i == 0);
    (i ? longest : key) = std::max(i ? longest : key, payload.size());
    REQUIRE(decode(reader, payload, i == 0) == 0);
    // 1 m away and 8,000 px: 5e-6 m are 0.04 px. Further away they are less.
    CHECK(difference(path[i], camera_in(reader, 3)) < 0.08);
  }
  CHECK(longest < key);
  CHECK(longest < 60);
}

TEST_CASE("the values of a payload have the meaning of clause 9.5") {
  // 8 bits: q = (192, 0, 0, 192), n = 73728: a turn by 90 degrees about z. Centre (2, -1, 0.5), fx 100,
  // fy 50.
  const std::vector<uint8_t> payload = {0,    0, 8, 1, 0, 0,    1, 0,   3,  0x80, 3, 0, 0,
                                        0x80, 3, 8, 3, 2, 0xc8, 1, 100, 20, 11,   0, 0};
  const fvv_camera base = moving(camera_with(FVV_LENS_NONE, {}), 3);
  const Handle reader = handle_of({base});
  REQUIRE(decode(reader, payload, true) == 0);
  const fvv_camera camera = camera_in(reader, 3);
  const double rotation[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1}, translation[3] = {-1, -2, -0.5};
  for (int i = 0; i < 9; i++) CHECK(camera.rotation[i] == rotation[i]);
  for (int i = 0; i < 3; i++) CHECK(camera.translation[i] == translation[i]);
  CHECK(camera.fx == 100);
  CHECK(camera.fy == 50);
  CHECK(camera.cx == 10);
  CHECK(camera.cy == -6);
  CHECK(camera.skew == 0);
  CHECK(std::isinf(camera.r_max));
  CHECK(camera.width == base.width);
}

TEST_CASE("a camera may lack a calibration at a time, and continues from its last values") {
  const fvv_camera a = moving(camera_with(FVV_LENS_NONE, {}), 2),
                   b = moving(camera_with(FVV_LENS_NONE, {}), 9);
  const fvv_camera still = camera_with(FVV_LENS_NONE, {});
  const Handle writer = handle_of({b, still, a}), reader = handle_of({b, still, a});
  fvv_camera camera;
  CHECK(fvv_calibration_camera(reader.get(), 2, &camera) == FVV_END);
  CHECK(fvv_calibration_camera(reader.get(), still.id, &camera) == FVV_ERROR_ARGUMENT);
  CHECK(decode(reader, encode(writer, some_bits, {a, b}, true), true) == 0);
  CHECK(fvv_calibration_camera(reader.get(), 9, &camera) == FVV_OK);
  CHECK(decode(reader, encode(writer, some_bits, {a}, false), false) == 0);
  CHECK(fvv_calibration_camera(reader.get(), 9, &camera) == FVV_END);
  const std::vector<uint8_t> back = encode(writer, some_bits, {a, b}, false);
  CHECK(back.size() == 8 + 2 * 14); // nothing moved
  CHECK(decode(reader, back, false) == 0);
  CHECK(camera_in(reader, 9).fx == b.fx);
  CHECK(decode(reader, encode(writer, some_bits, {}, false), false) == 0);
  CHECK(fvv_calibration_camera(reader.get(), 2, &camera) == FVV_END);
}

TEST_CASE("calibrations that break a rule are refused with its number") {
  const fvv_camera a = moving(camera_with(FVV_LENS_RADTAN, {-0.1}), 2),
                   b = moving(camera_with(FVV_LENS_NONE, {}), 9);
  const Handle writer = handle_of({a, b}), reader = handle_of({a, b});
  const std::vector<uint8_t> key = encode(writer, some_bits, {a, b}, true);
  const std::vector<uint8_t> second = encode(writer, some_bits, {a, b}, false);
  const auto changed = [](std::vector<uint8_t> payload, size_t at, uint8_t value) {
    payload[at] = value;
    return payload;
  };
  for (size_t size = 0; size < key.size(); size++) {
    INFO(size << " bytes");
    CHECK(decode(reader, {key.begin(), key.begin() + std::ptrdiff_t(size)}, true) == 5101);
  }
  std::vector<uint8_t> longer = key;
  longer.push_back(0);
  CHECK(decode(reader, longer, true) == 5101);
  CHECK(decode(reader, changed(key, 2, 7), true) == 5101);
  CHECK(decode(reader, changed(key, 2, 26), true) == 5101);
  CHECK(decode(reader, changed(key, 3, 41), true) == 5101);
  CHECK(decode(reader, changed(key, 6, 3), true) == 5102);
  CHECK(decode(reader, changed(key, 8, 3), true) == 5102);
  CHECK(decode(reader, changed(key, 6, 1), true) == 5101);
  CHECK(decode(reader, key, false) == 5103);
  CHECK(decode(reader, second, true) == 5103);
  CHECK(decode(reader, second, false) == 5103); // nothing before it
  REQUIRE(decode(reader, key, true) == 0);
  CHECK(decode(reader, changed(second, 0, 2), false) == 5103);
  REQUIRE(decode(reader, key, true) == 0);
  CHECK(decode(reader, changed(second, 4, 9), false) == 5103);
  CHECK(decode(reader, second, false) == 5103); // an error ends the run
  // The second entry once more in place of the first: 9, 9.
  std::vector<uint8_t> twice(second.begin(), second.begin() + 8);
  for (int i = 0; i < 2; i++) {
    twice.push_back(9);
    twice.insert(twice.end(), 13, 0);
  }
  REQUIRE(decode(reader, key, true) == 0);
  CHECK(decode(reader, twice, false) == 5102);
  const std::vector<uint8_t> head = {0, 0, 8, 0, 0, 0, 1, 0, 9};
  const auto with = [&](std::vector<uint8_t> values) {
    values.insert(values.begin(), head.begin(), head.end());
    return values;
  };
  CHECK(decode(reader, with({0x80, 4, 0, 0, 0, 0, 0, 0, 2, 2, 0, 0, 0, 0}), true) == 0);
  CHECK(decode(reader, with({0xfe, 1, 0, 0, 0, 0, 0, 0, 2, 2, 0, 0, 0, 0}), true) == 5104); // |q| = 127 / 256
  CHECK(decode(reader, with({0, 0, 0, 0, 0, 0, 0, 2, 2, 0, 0, 0, 0}), true) == 5104);
  CHECK(decode(reader, with({0x80, 4, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0}), true) == 5105); // fx = 0
  CHECK(decode(reader, with({0x80, 4, 0, 0, 0, 0, 0, 0, 2, 2, 0, 0, 0, 1}), true) == 5105); // r_max = -1
  // 2^53 + 1, then the largest that ULEB128 can say.
  CHECK(decode(reader, with({0x80, 4,    0, 0, 0, 0x82, 0x80, 0x80, 0x80, 0x80, 0x80,
                             0x80, 0x20, 0, 0, 2, 2,    0,    0,    0,    0}),
               true) == 5104);
  CHECK(decode(reader, with({0x80, 4,    0, 0, 0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,
                             0xff, 0xff, 1, 0, 0, 2,    2,    0,    0,    0,    0}),
               true) == 5104);
}

TEST_CASE("what cannot be written is refused, and leaves the writer where it was") {
  const fvv_camera a = moving(camera_with(FVV_LENS_NONE, {}), 2);
  fvv_camera still = a, wrong = a, far = a;
  still.flags = 0;
  still.id = 3;
  wrong.width++;
  far.translation[0] = 1e30;
  const Handle writer = handle_of({a, still});
  fvv_bytes payload = {};
  fvv_diagnostic diagnostic = {};
  const auto status = [&](const std::vector<fvv_camera> &cameras, bool key, fvv_calibration_bits bits) {
    return fvv_calibration_encode(writer.get(), &bits, cameras.data(), cameras.size(), key, &payload,
                                  &diagnostic);
  };
  CHECK(status({a}, false, some_bits) == FVV_ERROR_ARGUMENT);
  CHECK(status({a}, true, {7, 0, 0, 0}) == FVV_ERROR_ARGUMENT);
  REQUIRE(status({a}, true, some_bits) == FVV_OK);
  CHECK(status({a}, false, {20, 12, 8, 21}) == FVV_ERROR_ARGUMENT);
  CHECK(status({still}, false, some_bits) == FVV_ERROR_INPUT);
  CHECK(status({wrong}, false, some_bits) == FVV_ERROR_INPUT);
  CHECK(status({far}, false, some_bits) == FVV_ERROR_INPUT);
  CHECK(diagnostic.issue == FVV_ISSUE_CALIBRATION_RANGE);
  REQUIRE(status({a}, false, some_bits) == FVV_OK);
  CHECK(payload.data[0] == 1);
  fvv_bytes_free(&payload);
}

TEST_CASE("calibrations of any bytes give a valid camera or an error") {
  std::mt19937 random(9);
  const fvv_camera a = moving(camera_with(FVV_LENS_RADTAN, {-0.1}), 2),
                   b = moving(camera_with(FVV_LENS_FISHEYE, {0.01}), 9);
  const Handle writer = handle_of({a, b}), reader = handle_of({a, b});
  const std::vector<uint8_t> key = encode(writer, some_bits, {a, b}, true);
  const std::vector<uint8_t> second = encode(writer, some_bits, {a, b}, false);
  int good = 0;
  for (int round = 0; round < 20000; round++) {
    std::vector<uint8_t> payload = round % 2 ? key : second;
    if (round % 2 == 0) REQUIRE(decode(reader, key, true) == 0);
    for (int i = 0, edits = 1 + int(random() % 3); i < edits; i++)
      payload[random() % payload.size()] = uint8_t(random() % 4 ? random() : 0x80);
    payload.resize(payload.size() - random() % 2 * (random() % 3));
    if (decode(reader, payload, round % 2) != 0) continue;
    good++;
    for (const uint16_t id : {2, 9}) {
      fvv_camera camera;
      if (fvv_calibration_camera(reader.get(), id, &camera) == FVV_OK)
        CHECK(fvv_camera_validate(&camera, nullptr) == FVV_OK);
    }
  }
  CHECK(good > 100);
}

// ---- calibration/: cameras for which coding is hard, each named in a printed table with its error at the
// corners of the scene and its bytes; one group of 25 frames each, the steps chosen for 0.01 pixels.

namespace {

constexpr int frames = 25;
constexpr double bound = 0.05;          // pixels
constexpr double corner[3] = {3, 2, 3}; // metres: the scene reaches from -corner to corner
constexpr double position_step = 0.0001;

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
    // The centre is off by a fraction of a millimetre, which is many pixels where the scene touches the
    // camera.
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
