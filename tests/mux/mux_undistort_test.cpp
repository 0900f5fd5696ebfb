// fvvmux --undistort: where points lie in pictures without lens, what these show, and which lenses are
// refused.
#include "mux_fixture.h"

#include "calibration/cameras.h"
#include "scene/src/pinhole.h"

#include <cstdio>

namespace {

constexpr double bound = 0.05; // pixels

// A quarter of the size, for speed; world at the camera's own axes.
fvv_camera small(fvv_camera camera) {
  camera.width /= 4;
  camera.height /= 4;
  for (double *value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy, &camera.skew}) *value /= 4;
  for (int i = 0; i < 9; i++) camera.rotation[i] = i % 4 == 0;
  std::fill_n(camera.translation, 3, 0.0);
  camera.r_max = fvv_camera_r_max(&camera);
  return camera;
}

scene::Capture capture_with(const fvv_camera &camera) {
  scene::Capture capture;
  capture.path = "capture.json";
  capture.cameras.emplace_back();
  capture.cameras[0].calibration = camera;
  capture.cameras[0].set_name("one");
  capture.cameras[0].pictures = scene::PictureSource(*scene::Pattern::parse("%04d.png", nullptr));
  return capture;
}

// A soft dot of the scene, round in the new picture.
struct Dot {
  double u, v, sigma; // pixels of the new picture
};

std::optional<std::array<double, 2>> through(const fvv_camera &from, const fvv_camera &to, double u,
                                             double v) {
  const double pixel[2] = {u, v};
  double ray[3];
  std::array<double, 2> at;
  if (!fvv_camera_unproject(&from, pixel, ray) || !fvv_camera_project(&to, ray, at.data(), nullptr))
    return {};
  return at;
}

// On a grid over the old picture, as large as two of its pixels; none where the lens stretches it by more
// than 2.5, because they would run into each other.
std::vector<Dot> dots_of(const fvv_camera &before, const fvv_camera &after) {
  std::vector<Dot> dots;
  for (double v = 12.7; v < before.height - 10; v += 40)
    for (double u = 12.3; u < before.width - 10; u += 40) {
      const auto at = through(before, after, u, v), right = through(before, after, u + 1, v),
                 below = through(before, after, u, v + 1);
      if (!at || !right || !below) continue;
      const double stretch = std::max(std::hypot((*right)[0] - (*at)[0], (*right)[1] - (*at)[1]),
                                      std::hypot((*below)[0] - (*at)[0], (*below)[1] - (*at)[1]));
      if (stretch < 2.5) dots.push_back({(*at)[0], (*at)[1], 2 * stretch});
    }
  return dots;
}

// What the old camera sees of them.
media::Image seen_by(const fvv_camera &before, const fvv_camera &after, const std::vector<Dot> &dots) {
  media::Image image = media::make_image(before.width, before.height, 1, 0);
  for (uint32_t y = 0; y < before.height; y++)
    for (uint32_t x = 0; x < before.width; x++) {
      const auto at = through(before, after, x + 0.5, y + 0.5);
      if (!at) continue;
      double light = 0;
      for (const Dot &dot : dots) {
        const double far = std::hypot((*at)[0] - dot.u, (*at)[1] - dot.v) / dot.sigma;
        if (far < 5) light += 250 * std::exp(-far * far / 2);
      }
      image.pixels[size_t(y) * image.width + x] = uint8_t(std::lround(std::min(light, 255.0)));
    }
  return image;
}

// The middle of its light.
std::array<double, 2> centroid(const media::Image &image, const Dot &dot) {
  double sum = 0, x_sum = 0, y_sum = 0;
  const double reach = 3.5 * dot.sigma;
  for (int64_t y = std::llround(dot.v - reach); y < std::llround(dot.v + reach); y++)
    for (int64_t x = std::llround(dot.u - reach); x < std::llround(dot.u + reach); x++) {
      const double light = image.pixels[size_t(y) * image.width + size_t(x)];
      sum += light;
      x_sum += light * (double(x) + 0.5);
      y_sum += light * (double(y) + 0.5);
    }
  return {x_sum / sum, y_sum / sum};
}

struct Found {
  double worst = 0; // pixels of the new picture
  int points = 0;
};

// Dots, drawn as the old camera sees them, looked for where the new one does.
Found measure(const fvv_camera &before, const fvv_camera &after, const scene::Undistortion &undistortion,
              int64_t frame) {
  const std::vector<Dot> dots = dots_of(before, after);
  const media::Image picture = undistortion.apply(0, frame, seen_by(before, after, dots));
  REQUIRE((picture.width == after.width && picture.height == after.height));
  Found found;
  for (const Dot &dot : dots) {
    const double border = 4 * dot.sigma;
    if (dot.u < border || dot.v < border || dot.u > after.width - border || dot.v > after.height - border)
      continue;
    const auto [x, y] = centroid(picture, dot);
    found.worst = std::max(found.worst, std::hypot(x - dot.u, y - dot.v));
    found.points++;
  }
  return found;
}

} // namespace

TEST_CASE("points lie where the camera without lens sees them", "[long]") {
  std::printf("%-32s %-9s %-8s %-11s %-9s %s\n", "lens", "picture", "degrees", "kept/blank", "worst px",
              "points");
  for (const named_camera &lens : lenses()) {
    const fvv_camera before = small(lens.camera);
    if (before.lens == FVV_LENS_NONE || scene::LensView(before).is_too_wide()) continue;
    for (const double alpha : {0.0, 1.0}) {
      scene::Capture capture = capture_with(before);
      const scene::Undistortion undistortion(capture, alpha);
      const fvv_camera &after = capture.cameras[0].calibration;
      CAPTURE(lens.name, alpha);
      REQUIRE(after.lens == FVV_LENS_NONE);
      REQUIRE(fvv_camera_validate(&after, nullptr) == FVV_OK);
      REQUIRE(undistortion.report().size() == 1);
      const scene::Undistorted &report = undistortion.report()[0];
      const Found found = measure(before, after, undistortion, 0);
      std::printf("%-32s %ux%-5u %3.0fx%-4.0f %3.0f%%/%-3.0f%%   %-9.3f %d\n", lens.name.c_str(), after.width,
                  after.height, report.horizontal, report.vertical, 100 * report.kept, 100 * report.blank,
                  found.worst, found.points);
      CHECK(found.points > 12);
      CHECK(found.worst < bound);
      // White stays white wherever the lens shows anything.
      media::Image white = media::make_image(before.width, before.height, 3, 255);
      white = undistortion.apply(0, 0, std::move(white));
      const auto dark =
          std::count_if(white.pixels.begin(), white.pixels.end(), [](uint8_t p) { return p < 255; });
      if (alpha == 0)
        CHECK(dark == 0);
      else
        CHECK(double(dark) / double(white.pixels.size()) == Approx(report.blank).margin(0.02));
      if (alpha == 1 && !report.limited) CHECK(report.kept > 0.9999);
    }
  }
}

TEST_CASE("half a pixel more would be seen") {
  fvv_camera before = small(camera_with(FVV_LENS_RADTAN, {-0.2, 0.04}));
  scene::Capture capture = capture_with(before);
  const scene::Undistortion undistortion(capture, 0);
  fvv_camera after = capture.cameras[0].calibration;
  CHECK(measure(before, after, undistortion, 0).worst < bound);
  after.cx += 0.5;
  const Found found = measure(before, after, undistortion, 0);
  CHECK((found.points > 30 && found.worst > 0.4));
}

TEST_CASE("a camera that zooms has a lens of its own in each frame, and pictures of one size") {
  scene::Capture capture = capture_with(small(camera_with(FVV_LENS_RADTAN, {-0.2, 0.04})));
  capture.frames.count = 3;
  for (int64_t frame = 0; frame < 3; frame++) {
    fvv_camera one = capture.cameras[0].calibration;
    one.name = nullptr;
    one.name_size = 0;
    one.fx *= std::pow(10, 0.5 * double(frame)); // by ten in all
    one.fy *= std::pow(10, 0.5 * double(frame));
    one.distortion[0] = -0.2 + 0.1 * double(frame);
    one.cx += 3 * double(frame);
    one.r_max = fvv_camera_r_max(&one);
    capture.cameras[0].per_frame[frame] = one;
  }
  const scene::Capture before = capture;
  const scene::Undistortion undistortion(capture, 0);
  for (int64_t frame = 0; frame < 3; frame++) {
    const fvv_camera now = capture.cameras[0].calibration_at(frame);
    const Found found = measure(before.cameras[0].calibration_at(frame), now, undistortion, frame);
    CAPTURE(frame);
    CHECK((now.lens == FVV_LENS_NONE && now.width == capture.cameras[0].calibration.width));
    CHECK((found.points > 30 && found.worst < bound));
  }
  CHECK(capture.cameras[0].calibration_at(2).fx > 9 * capture.cameras[0].calibration_at(0).fx);
}

TEST_CASE("cameras without lens, and without pictures, stay as they are") {
  scene::Capture capture = capture_with(small(camera_with(FVV_LENS_NONE, {})));
  capture.cameras.push_back(capture.cameras[0]);
  capture.cameras[1].calibration = small(camera_with(FVV_LENS_RADTAN, {-0.2}));
  capture.cameras[1].pictures.reset();
  const scene::Undistortion undistortion(capture, 0);
  CHECK(undistortion.report().empty());
  CHECK(capture.cameras[1].calibration.lens == FVV_LENS_RADTAN);
  const media::Image picture = picture_of(0, 480, 270, 0);
  CHECK(undistortion.apply(0, 0, picture).pixels == picture.pixels);
}

TEST_CASE("pixels of 16 bits keep their depth") {
  scene::Capture capture = capture_with(small(camera_with(FVV_LENS_RADTAN, {-0.2})));
  const scene::Undistortion undistortion(capture, 0);
  const media::DeepImage out = undistortion.apply(0, 0, media::make_image<uint16_t>(480, 270, 3, 40001));
  CHECK(std::all_of(out.pixels.begin(), out.pixels.end(), [](uint16_t p) { return p == 40001; }));
}

TEST_CASE("lenses that see too far round are refused by name") {
  fvv_camera wide = small(camera_with(FVV_LENS_FISHEYE, {0.02, -0.004}));
  wide.fx = wide.fy = 240 / 1.5; // 85 degrees to either side
  wide.r_max = fvv_camera_r_max(&wide);
  scene::Capture capture = capture_with(wide);
  CHECK_THROWS_WITH(scene::Undistortion(capture, 0),
                    Catch::Contains("undistort: camera 7: the lens shows 150 degrees"));
  // 74 degrees to either side, and more in the corners, is a picture.
  wide.fx = wide.fy = 240 / 1.29;
  wide.r_max = fvv_camera_r_max(&wide);
  capture = capture_with(wide);
  const scene::Undistortion undistortion(capture, 1);
  CHECK(undistortion.report()[0].limited);
  CHECK(undistortion.report()[0].horizontal > 140);
}

TEST_CASE("a stream with --undistort holds cameras without lens, and verifies") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  scene::Capture source = make_capture(folder, shape);
  for (const size_t k : {0, 2}) {
    fvv_camera &camera = source.cameras[k].calibration;
    camera.lens = k ? FVV_LENS_FISHEYE : FVV_LENS_RADTAN;
    camera.distortion[0] = k ? 0.02 : -0.15;
    camera.r_max = fvv_camera_r_max(&camera);
  }
  scene::write_capture(source, source.path);
  FileOptions options = options_for(folder);
  options.undistort = options.verify = true;
  options.crop = mux::Crop::automatic; // by masks of cameras without lens
  options.tile_fill = mux::TileFill::flat;
  const mux::Report summary = mux_file(options);
  REQUIRE(summary.verdict);
  CHECK(summary.undistorted->size() == 2);
  const std::string one = read_bytes(options.output);
  options.threads = 1;
  mux_file(options);
  CHECK(read_bytes(options.output) == one);
  const mux::Plan plan = mux::make_plan(options, {});
  for (const scene::Camera &camera : plan.capture.cameras) CHECK(camera.calibration.lens == FVV_LENS_NONE);
  // Without the option they stay as shot.
  options.undistort = false;
  CHECK(mux::make_plan(options, {}).capture.cameras[0].calibration.lens == FVV_LENS_RADTAN);
}
