// Gains of cameras: what unlike exposure and white balance are, and what is none of either.
#include "fvv_render/colour_match.h"

#include "fvv_catch.h"
#include "view_fixture.h"

#include <algorithm>
#include <functional>

namespace {

using namespace view_fixture;

double linear_of(double display) {
  return display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
}
double display_of(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

const std::vector<float> &light_of_codes() {
  static const std::vector<float> table = [] {
    std::vector<float> out;
    for (int code = 0; code < 256; code++) out.push_back(float(linear_of(code / 255.0)));
    return out;
  }();
  return table;
}

// The square |x|, |y| <= 1 in the plane z = 0, its front towards -z, n x n vertices.
struct Sheet {
  explicit Sheet(uint32_t n) {
    for (uint32_t i = 0; i < n * n; i++)
      for (const double value : {2.0 * (i % n) / (n - 1) - 1, 2.0 * (i / n) / (n - 1) - 1, 0.0})
        positions.push_back(value);
    for (uint32_t y = 0; y + 1 < n; y++)
      for (uint32_t x = 0; x + 1 < n; x++) {
        const uint32_t a = y * n + x;
        for (const uint32_t i : {a, a + n, a + 1, a + 1, a + n, a + n + 1}) faces.push_back(i);
      }
  }
  std::vector<double> positions;
  std::vector<uint32_t> faces;
};

// Light of a surface with stripes and shades, from 0.05 to 0.65.
Vec3 pattern(Vec3 at) {
  const double stripe = std::fmod(std::floor(4 * (at.x + at.y + 8)), 2) < 1 ? 0.1 : 0;
  return {0.3 + 0.2 * at.x + stripe, 0.25 + 0.1 * at.y + stripe, 0.2 - 0.1 * at.x + stripe};
}

using Colour = std::function<Vec3(Vec3)>;

// What a camera shows of the plane z = 0 whose light is colour times gain.
std::vector<uint8_t> filmed(const fvv_camera &camera, const Colour &colour, Vec3 gain) {
  std::vector<uint8_t> out;
  for (uint32_t y = 0; y < camera.height; y++)
    for (uint32_t x = 0; x < camera.width; x++) {
      const Vec3 c = product(colour(on_plane(camera, x + 0.5, y + 0.5, 0)), gain);
      for (const double value : {c.x, c.y, c.z})
        out.push_back(uint8_t(std::lround(255 * std::clamp(display_of(std::max(value, 0.0)), 0.0, 1.0))));
    }
  return out;
}

struct Rig {
  std::vector<fvv_camera> cameras;
  std::vector<Vec3> gains;
  std::vector<Colour> colours;

  void add(Vec3 eye, Vec3 gain, Colour colour = pattern) {
    cameras.push_back(looking(eye, {}, 320, 240, 300));
    gains.push_back(gain);
    colours.push_back(std::move(colour));
  }

  std::vector<PlaceLight> frame() const {
    const Sheet sheet(61);
    const MatchSurface surface(sheet.positions, sheet.faces);
    std::vector<PlaceLight> out;
    for (size_t i = 0; i < cameras.size(); i++) {
      const std::vector<uint8_t> picture = filmed(cameras[i], colours[i], gains[i]);
      out.push_back(surface.light({cameras[i], picture.data(), nullptr, light_of_codes().data()}));
    }
    return out;
  }

  // The largest error of a gain; their mean over the first cameras is that of what was put in.
  double error(const ColourMatch &found, size_t count) const {
    double worst = 0;
    for (int k = 0; k < 3; k++) {
      double mean = 0;
      for (size_t i = 0; i < count; i++) mean += std::log(axis_of(gains[i], k)) / double(count);
      for (size_t i = 0; i < count; i++)
        worst =
            std::max(worst, std::abs(found.cameras[i].gain[k] * axis_of(gains[i], k) / std::exp(mean) - 1));
    }
    return worst;
  }
};

const Vec3 none = {1, 1, 1};

Rig unlike() {
  Rig rig;
  rig.add({-1.5, 0.5, -4}, {1.2, 1.1, 0.9});
  rig.add({-0.5, -0.5, -4.5}, none);
  rig.add({0.5, 0.5, -4}, {0.8, 0.85, 1.1});
  rig.add({1.5, 0, -3.5}, {1.3, 1.3, 1.3});
  return rig;
}

} // namespace

TEST_CASE("gains of cameras with unlike exposure and white balance are found, their mean is 1") {
  const Rig rig = unlike();
  const ColourMatch found = match_colours({rig.frame()});
  REQUIRE(found.cameras.size() == 4);
  CHECK(rig.error(found, 4) < 0.01);
  CHECK(found.before > 0.2);
  CHECK(found.after < 0.01);
  CHECK(found.departure() > 0.15);
  for (int k = 0; k < 3; k++) {
    double product = 1;
    for (const CameraMatch &camera : found.cameras) product *= camera.gain[k];
    CHECK(std::abs(product - 1) < 0.005); // gains are rounded
  }
  for (const CameraMatch &camera : found.cameras) {
    CHECK(camera.matched);
    CHECK(camera.places > 500);
  }
}

TEST_CASE("the unit and the place of a surface make no difference") {
  const Rig rig = unlike();
  Sheet sheet(61);
  for (size_t i = 0; i < sheet.positions.size(); i++)
    sheet.positions[i] = sheet.positions[i] * 1e-4 + double(i % 3) * 10;
  const MatchSurface surface(sheet.positions, sheet.faces);
  std::vector<PlaceLight> frame;
  for (size_t i = 0; i < rig.cameras.size(); i++) {
    const std::vector<uint8_t> picture = filmed(rig.cameras[i], pattern, rig.gains[i]);
    fvv_camera camera = rig.cameras[i];
    for (int row = 0; row < 3; row++) {
      camera.translation[row] *= 1e-4;
      for (int k = 0; k < 3; k++) camera.translation[row] -= camera.rotation[3 * row + k] * 10 * k;
    }
    frame.push_back(surface.light({camera, picture.data(), nullptr, light_of_codes().data()}));
  }
  CHECK(rig.error(match_colours({frame}), 4) < 0.01);
}

TEST_CASE("equal cameras stay as they are, with calibration a pixel off and highlights that move") {
  Rig rig;
  for (const double x : {-1.5, -0.5, 0.5, 1.5}) {
    // A highlight of a fifth of the surface, elsewhere for each camera.
    rig.add({x, 0.3 * x, -4}, none, [x](Vec3 at) {
      return pattern(at) + none * (0.4 * std::exp(-8 * (at.x - x / 2) * (at.x - x / 2) - 8 * at.y * at.y));
    });
  }
  std::vector<PlaceLight> frame;
  const Sheet sheet(61);
  const MatchSurface surface(sheet.positions, sheet.faces);
  for (size_t i = 0; i < rig.cameras.size(); i++) {
    const std::vector<uint8_t> picture = filmed(rig.cameras[i], rig.colours[i], none);
    rig.cameras[i].cx += i % 2 ? 1 : -1;
    frame.push_back(surface.light({rig.cameras[i], picture.data(), nullptr, light_of_codes().data()}));
  }
  const ColourMatch found = match_colours({frame});
  CHECK(found.departure() < 0.02);
  for (const CameraMatch &camera : found.cameras) CHECK(camera.matched);
}

TEST_CASE("places that are clipped or near black do not count") {
  Rig rig = unlike();
  // Half of the surface is brighter than cameras can show, a quarter is black with an offset.
  for (size_t i = 0; i < rig.colours.size(); i++)
    rig.colours[i] = [i](Vec3 at) {
      return at.x > 0 ? Vec3{2, 2, 2} : at.y > 0 ? Vec3{0.0005, 0.0005, 0.0005} * double(i) : pattern(at);
    };
  CHECK(rig.error(match_colours({rig.frame()}), 4) < 0.01);
}

TEST_CASE("a camera without enough common surface stays as it is, and so does the mean of the others") {
  Rig rig = unlike();
  rig.add({0, 0, 4}, {1.5, 1.5, 1.5}); // sees backs alone
  const ColourMatch found = match_colours({rig.frame(), rig.frame()});
  CHECK(rig.error(found, 4) < 0.01);
  const CameraMatch &alone = found.cameras[4];
  CHECK(!alone.matched);
  CHECK(alone.places == 0);
  for (const double gain : alone.gain) CHECK(gain == 1);
}

TEST_CASE("frames that lack a camera, and no frames at all") {
  const Rig rig = unlike();
  std::vector<PlaceLight> first = rig.frame(), second = first;
  first[0].clear();
  second[3].clear();
  CHECK(rig.error(match_colours({first, second}), 4) < 0.01);
  CHECK(match_colours({}).cameras.empty());
  CHECK(match_colours({}).departure() == 0);
  CHECK_THROWS_AS(match_colours({first, {}}), std::invalid_argument);
}

TEST_CASE("places that are hidden, next to an edge or outside of the mask are not compared") {
  Sheet sheet(61);
  const size_t count = sheet.positions.size() / 3;
  const auto first = uint32_t(count);
  // A square in front of the middle.
  for (const auto &[x, y] : {std::pair{-0.52, -0.52}, {0.52, -0.52}, {0.52, 0.52}, {-0.52, 0.52}})
    for (const double value : {x, y, -0.5}) sheet.positions.push_back(value);
  for (const uint32_t i : {0u, 2u, 1u, 0u, 3u, 2u}) sheet.faces.push_back(first + i);
  const MatchSurface surface(sheet.positions, sheet.faces);
  const fvv_camera camera = looking({0, 0, -4}, {}, 320, 240, 300);
  const std::vector<uint8_t> picture = filmed(
      camera, [](Vec3) { return none * 0.3; }, none);
  std::vector<uint8_t> mask(size_t(320) * 240, 255);
  for (size_t y = 0; y < 240; y++) std::fill_n(&mask[320 * y], 120, uint8_t(0)); // x < -0.53
  const auto light = [&](const uint8_t *outline, double x, double y) {
    const PlaceLight all = surface.light({camera, picture.data(), outline, light_of_codes().data()});
    for (size_t v = 0; v < count; v++)
      if (std::abs(sheet.positions[3 * v] - x) < 0.01 && std::abs(sheet.positions[3 * v + 1] - y) < 0.01)
        return double(all[3 * v]);
    return -1.0;
  };
  CHECK(light(nullptr, 0, 0) == 0);   // hidden
  CHECK(light(nullptr, 0.6, 0) == 0); // the square covers up to 0.594
  CHECK(std::abs(light(nullptr, 0.8, 0) - 0.3) < 0.01);
  CHECK(light(nullptr, 1, 0) == 0); // where the sheet ends
  CHECK(std::abs(light(nullptr, -0.8, 0) - 0.3) < 0.01);
  CHECK(light(mask.data(), -0.8, 0) == 0);
  CHECK(std::abs(light(mask.data(), 0.8, 0) - 0.3) < 0.01);
}
