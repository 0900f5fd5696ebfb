// The parts of a calibration sheet: outlines, guides, numbers, words, layout, each against plain arithmetic.
#include "sheet_fixture.h"

#include "fvvimport/panel.h"

namespace {

using Mask = std::vector<uint8_t>;

// A square of side 20 at x, y in a picture of 80 x 60.
Mask square(uint32_t x, uint32_t y) {
  Mask mask(80 * 60);
  for (uint32_t row = y; row < y + 20; row++) std::fill_n(&mask[row * 80 + x], 20, uint8_t(255));
  return mask;
}

const uint8_t *at(const media::Image &image, double u, double v) {
  return &image.pixels[3 * (size_t(v) * image.width + size_t(u))];
}

bool is(const uint8_t *pixel, fvvimport::Colour colour) {
  return std::abs(pixel[0] - colour.red) < 25 && std::abs(pixel[1] - colour.green) < 25 &&
         std::abs(pixel[2] - colour.blue) < 25;
}

std::vector<fvv_camera> ring() {
  std::vector<fvv_camera> cameras;
  for (size_t k = 0; k < ring_cameras; k++) cameras.push_back(ring_camera(k));
  return cameras;
}

} // namespace

TEST_CASE("sheet parts: the outline lies where rays graze the ball, through the lens") {
  const geometry::Mesh mesh = sheet_ball();
  const geometry::ViewedSurface body(mesh.positions, mesh.faces);
  for (const size_t k : {0, 1, 5}) {
    const fvv_camera camera = ring_camera(k);
    // Twice the camera's size, as a panel may be.
    media::Image image = media::make_image(2 * camera.width, 2 * camera.height, 3, 100);
    fvvimport::draw_outline(body, camera, image);
    size_t light = 0, on_ray = 0;
    for (uint32_t y = 0; y < image.height; y++)
      for (uint32_t x = 0; x < image.width; x++) {
        // Grazing: the ball is seen on one side of the pixel within a distance, and not on the other.
        const auto grazes = [&](double reach) {
          size_t seen = 0;
          for (int turn = 0; turn < 16; turn++) {
            const double a = M_PI * turn / 8;
            seen +=
                ball_seen(camera, (x + 0.5 + reach * std::cos(a)) / 2, (y + 0.5 + reach * std::sin(a)) / 2);
          }
          return seen > 0 && seen < 16;
        };
        const bool is_light = at(image, x, y)[0] > 200;
        light += is_light;
        if (is_light) CHECK(grazes(1.7));
        if (!grazes(0.3)) continue;
        on_ray++;
        CHECK(is_light);
      }
    CHECK(on_ray > 100);
    CHECK(light < 4 * on_ray);
  }
}

TEST_CASE("sheet parts: numbers of shifted squares") {
  const Mask here = square(30, 20);
  const geometry::SilhouetteMatch same = geometry::compare(here, here, 80, 60);
  CHECK(*same.iou == 1);
  CHECK(*same.distance == Approx(0).margin(1e-6));
  const geometry::SilhouetteMatch right = geometry::compare(square(34, 20), here, 80, 60);
  CHECK(*right.iou == Approx(16.0 / 24));
  CHECK((*right.offset)[0] == Approx(4).margin(0.3));
  CHECK((*right.offset)[1] == Approx(0).margin(0.3));
  // Two of four sides are 4 px off, the other two coincide but for their ends.
  CHECK(*right.distance > 1.8);
  CHECK(*right.distance < 2.4);
  const geometry::SilhouetteMatch empty = geometry::compare(Mask(80 * 60), Mask(80 * 60), 80, 60);
  CHECK(!empty.iou);
  CHECK(!empty.distance);
  const geometry::SilhouetteMatch lost = geometry::compare(Mask(80 * 60), here, 80, 60);
  CHECK(*lost.iou == 0);
  CHECK(*lost.distance == 100);
  CHECK(!lost.offset);
}

TEST_CASE("sheet parts: outliers") {
  const auto with = [](std::vector<double> distances) {
    std::vector<geometry::CameraMatch> cameras;
    for (const double d : distances) cameras.push_back({{0.9, d, std::nullopt}, 1000});
    return geometry::outlier_cameras(cameras);
  };
  CHECK(with({1, 1.2, 0.9, 1.1}).empty());
  CHECK(with({1, 1.2, 3.5, 1.1}) == std::vector<size_t>{2});
  CHECK(with({1, 9, 1.1, 12, 1}) == std::vector<size_t>{3, 1});
  CHECK(with({0.01, 0.9, 0.01}).empty()); // less than a pixel more is nothing
  CHECK(with({1, 50}).empty());           // of two cameras neither is an outlier
  CHECK(*geometry::median({4, 1, 3, 2}) == 2.5);
  CHECK(!geometry::median({}));
}

TEST_CASE("sheet parts: axes, ground and cameras are where the calibration projects them") {
  const std::vector<fvv_camera> cameras = ring();
  CHECK(fvvimport::guide_step(cameras) == 0.5);
  media::Image image = media::make_image(400, 300, 3, 90);
  const auto pixel = [&](double x, double y, double z) {
    const double world[3] = {x, y, z};
    double p[2];
    REQUIRE(fvv_camera_project(&cameras[0], world, p, nullptr) == 1);
    return at(image, 2 * p[0], 2 * p[1]);
  };
  fvvimport::draw_axes(cameras, 0, image);
  CHECK(is(pixel(0.3, 0, 0), fvvimport::vermillion));
  CHECK(is(pixel(0, 0.3, 0), fvvimport::bluish_green));
  CHECK(is(pixel(-0.3, 0, 0), {90, 90, 90}));
  fvvimport::draw_ground(cameras, 0, FVV_UP_UNKNOWN, image);
  CHECK(is(pixel(-0.5, 0, 0.25), {90, 90, 90}));
  fvvimport::draw_ground(cameras, 0, FVV_UP_Y, image);
  CHECK(pixel(-0.5, 0, 0.25)[0] > 130);
  CHECK(is(pixel(-0.75, 0, 0.25), {90, 90, 90}));
  size_t seen = 0;
  image = media::make_image(400, 300, 3, 90);
  fvvimport::draw_cameras(cameras, 0, image);
  for (size_t k = 1; k < cameras.size(); k++) {
    double centre[3], p[2];
    fvv_camera_centre(&cameras[k], centre);
    if (!fvv_camera_project(&cameras[0], centre, p, nullptr) || p[0] < 0 || p[1] < 0 || p[0] >= 200 ||
        p[1] >= 150)
      continue;
    seen++;
    CHECK(is(at(image, 2 * p[0], 2 * p[1]), fvvimport::light));
  }
  CHECK(seen >= 2);
}

TEST_CASE("sheet parts: sheets stay within their limit, and are nearly square") {
  std::vector<fvv_camera> cameras(47, ring_camera(0));
  fvvimport::Layout layout = fvvimport::arrange_panels(cameras, 480);
  CHECK(layout.picture == 480);
  CHECK(layout.width < fvvimport::largest_sheet);
  CHECK(layout.height < fvvimport::largest_sheet);
  CHECK(layout.width < 1.3 * layout.height);
  CHECK(layout.height < 1.3 * layout.width);
  CHECK(layout.columns * layout.rows >= 47);
  cameras.resize(1024, ring_camera(1));
  cameras[5].height = 3 * cameras[5].width;
  layout = fvvimport::arrange_panels(cameras, 2048);
  CHECK(layout.picture < 480);
  CHECK(layout.width <= fvvimport::largest_sheet);
  CHECK(layout.height < fvvimport::largest_sheet);
}

TEST_CASE("sheet parts: words") {
  CHECK(fvvimport::text_width("camera", 2) == 2 * fvvimport::text_width("camera", 1));
  CHECK(fvvimport::text_width("K\xc3\xb6ln", 1) == fvvimport::text_width("K?ln", 1));
  CHECK(fvvimport::shortened("camera", 1, 500) == "camera");
  const std::string kept = fvvimport::shortened("behind the basket", 1, 60);
  CHECK(kept.substr(kept.size() - 3) == "...");
  CHECK(fvvimport::text_width(kept, 1) <= 60);
  media::Image image = media::make_image(100, 20, 3, 0);
  fvvimport::draw_text(image, 2, 2, "H", 1, fvvimport::light);
  const auto lit = std::count(image.pixels.begin(), image.pixels.end(), 255);
  CHECK(lit > 20);
  fvvimport::draw_text(image, 96, 16, "HHHH", 2, fvvimport::light); // beyond the corner
  CHECK(fvvimport::line_height(2) == 24);
}
