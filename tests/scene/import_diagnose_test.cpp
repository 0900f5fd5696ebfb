// tools/import: points that a calibration explains, and those that it would explain but for one mistake.
#include "import_fixture.h"

#include "fvv_scene/file_io.h"
#include "fvv_scene/import.h"
#include "scene/src/import/camera.h"

#include <random>

using namespace fvv;
using import::Mistake;

namespace {

// Four cameras around the origin, none of them symmetric in any way that would hide a mistake.
std::vector<scene::Camera> ring(const std::vector<double> &coefficients) {
  std::vector<scene::Camera> cameras;
  for (int i = 0; i < 4; i++) {
    scene::Camera camera;
    fvv_camera &c = camera.calibration;
    c.id = static_cast<uint16_t>(20 + i);
    c.width = 1280;
    c.height = 720;
    c.fx = 1100 + i;
    c.fy = 1102;
    c.cx = 645;
    c.cy = 357;
    double eight[8] = {};
    std::copy(coefficients.begin(), coefficients.end(), eight);
    import::set_radtan(c, eight);
    const double a = 0.4 + 1.3 * i;
    const double axes[9] = {-std::sin(a),
                            std::cos(a),
                            0,
                            -0.2 * std::cos(a),
                            -0.2 * std::sin(a),
                            std::sqrt(0.96),
                            std::sqrt(0.96) * std::cos(a),
                            std::sqrt(0.96) * std::sin(a),
                            0.2};
    const double centre[3] = {5 * std::cos(a), 5 * std::sin(a), 1.5 + 0.1 * i};
    import::set_pose_opengl(c, axes, centre);
    c.r_max = fvv_camera_r_max(&c);
    cameras.push_back(camera);
  }
  return cameras;
}

std::vector<import::Observation> observe(const std::vector<scene::Camera> &cameras, double noise) {
  std::mt19937 random(7);
  const auto uniform = [&](double size) { return size * (random() / 2147483648.0 - 1); };
  std::vector<import::Observation> observations;
  for (int i = 0; i < 60; i++) {
    const double point[3] = {uniform(1.5), uniform(1.5), 0.8 + uniform(0.8)};
    for (const auto &camera : cameras) {
      import::Observation o = {{point[0], point[1], point[2]}, camera.calibration.id, { 0, 0 }};
      REQUIRE(fvv_camera_project(&camera.calibration, point, o.pixel, nullptr));
      for (double &coordinate : o.pixel) coordinate += uniform(noise);
      observations.push_back(o);
    }
  }
  return observations;
}

void turn_axes(fvv_camera &c) {
  for (int i = 3; i < 9; i++) c.rotation[i] *= -1;
  c.translation[1] *= -1;
  c.translation[2] *= -1;
}

// R^T and -R^T t in place of R and t.
void invert(fvv_camera &c) {
  double centre[3];
  fvv_camera_centre(&c, centre);
  for (const auto &[a, b] : {std::pair(1, 3), {2, 6}, {5, 7}}) std::swap(c.rotation[a], c.rotation[b]);
  std::copy(centre, centre + 3, c.translation);
}

import::Diagnosis after(const std::vector<double> &coefficients, double noise,
                        const std::function<void(fvv_camera &)> &mistake){
    std::vector<scene::Camera> cameras = ring(coefficients);
const auto observations = observe(cameras, noise);
for (auto &camera : cameras) {
  mistake(camera.calibration);
  camera.calibration.r_max = fvv_camera_r_max(&camera.calibration);
}
return import::diagnose(cameras, observations);
} // namespace

const std::vector<double> lens = {-0.2, 0.05, 0.003, -0.006, 0.02};

} // namespace

TEST_CASE("a good calibration is not suspected, with noise or without") {
  const auto exact = after(lens, 0, [](fvv_camera &) {});
  CHECK(exact.points == 240);
  CHECK(exact.invisible == 0);
  CHECK(exact.rms < 1e-9);
  CHECK_FALSE(exact.suspected);
  const auto noisy = after(lens, 2, [](fvv_camera &) {});
  CHECK(noisy.rms > 1);
  CHECK(noisy.max < 3);
  CHECK(noisy.rms_of_camera.size() == 4);
  CHECK_FALSE(noisy.suspected);
}

TEST_CASE("each of the classic mistakes is named, and undoing it leaves the noise") {
  const std::vector<std::pair<Mistake, std::function<void(fvv_camera &)>>> mistakes = {
      {Mistake::axes, turn_axes},
      {Mistake::inverse, invert},
      {Mistake::inverse,
       [](fvv_camera &c) { // the same in a format with OpenGL's axes
         turn_axes(c);
         invert(c);
         turn_axes(c);
       }},
      {Mistake::inverse_and_axes,
       [](fvv_camera &c) { // nerfstudio's matrix pasted as rotation and translation
         turn_axes(c);
         invert(c);
       }},
      {Mistake::inverse_and_axes,
       [](fvv_camera &c) {
         invert(c);
         turn_axes(c);
       }},
      {Mistake::half_pixel,
       [](fvv_camera &c) {
         c.cx -= 0.5;
         c.cy -= 0.5;
       }},
      {Mistake::half_pixel,
       [](fvv_camera &c) {
         c.cx += 0.5;
         c.cy += 0.5;
       }},
      {Mistake::distortion, // k1 k2 k3 p1 p2 written, k1 k2 p1 p2 k3 read
       [](fvv_camera &c) {
         const double d[3] = {c.distortion[4], c.distortion[2], c.distortion[3]};
         std::copy(d, d + 3, c.distortion + 2);
       }},
      {Mistake::distortion, // the reverse
       [](fvv_camera &c) {
         const double d[3] = {c.distortion[3], c.distortion[4], c.distortion[2]};
         std::copy(d, d + 3, c.distortion + 2);
       }},
      {Mistake::distortion, [](fvv_camera &c) { std::swap(c.distortion[2], c.distortion[3]); }}};
  for (size_t i = 0; i < mistakes.size(); i++) {
    for (const double noise : {0.0, 0.3}) {
      const auto diagnosis = after(lens, noise, mistakes[i].second);
      INFO("mistake " << i << ", noise " << noise);
      REQUIRE(diagnosis.suspected);
      CHECK(import::name_of(*diagnosis.suspected) == std::string(import::name_of(mistakes[i].first)));
      CHECK(diagnosis.undone[static_cast<size_t>(mistakes[i].first)] <= noise + 1e-9);
    }
  }
}

TEST_CASE("an error that is none of them stays without a name") {
  const auto focal = after(lens, 0.3, [](fvv_camera &c) { c.fx *= 1.02; });
  CHECK(focal.rms > 1);
  CHECK_FALSE(focal.suspected);
  const auto moved = after(lens, 0.3, [](fvv_camera &c) { c.translation[0] += 0.1; });
  CHECK_FALSE(moved.suspected);
  // A lens that has no coefficients cannot have them in the wrong order.
  CHECK(std::isnan(after({}, 0.3, turn_axes).undone[static_cast<size_t>(Mistake::distortion)]));
  CHECK(after({}, 0.3, turn_axes).suspected == Mistake::axes);
}

TEST_CASE("points: malformed files, each with its message") {
  const ImportFolder folder;
  const auto cameras = ring(lens);
  std::string good = "# points\n\n";
  for (int i = 0; i < 8; i++) good += "0 0 1 2" + std::to_string(i % 4) + " 640 360\n";
  const std::string path = folder.path("points.txt");
  const auto message = [&](const std::string &text) {
    folder.write("points.txt", text);
    return message_of([&] { import::read_observations(path, cameras); });
  };
  CHECK(message(good).empty());
  CHECK(message(with(good, " 360", "")) == path + ":3: expected X Y Z CAMERA_ID U V, found 5 words");
  CHECK(message(with(good, "0 0 1", "0 0 -inf")) ==
        path + ":3: expected a finite number for X Y Z, found \"-inf\"");
  CHECK(message(with(good, "640 360", "640 ?")) ==
        path + ":3: expected a finite number for U V, found \"?\"");
  CHECK(message(with(good, " 20 ", " 2.5 ")) ==
        path + ":3: expected an integer from 0 to 65534 for CAMERA_ID, found \"2.5\"");
  CHECK(message(with(good, " 21 ", " 24 ")) ==
        path + ":4: expected the id of a camera of the calibration, found 24");
  CHECK(message(with(good, "0 0 1 20 640 360\n", "")) == path + ": expected at least 8 points, found 7");
}
