// fvv_media/resample.h: pictures along a map.
#include "fvv_media/resample.h"
#include "pictures.h"

using namespace fvv::media;

namespace {

template <class Sample> BasicImage<Sample> ramp(uint32_t width, uint32_t height) {
  BasicImage<Sample> image = make_image<Sample>(width, height, 1, 0);
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++) image.pixels[size_t(y) * width + x] = Sample(20 + 4 * x + 2 * y);
  return image;
}

PixelMap moved(double by_x, double by_y) {
  return [by_x, by_y](double x, double y, double at[2]) {
    at[0] = x + by_x;
    at[1] = y + by_y;
    return true;
  };
}

} // namespace

TEST_CASE("resampled in place a picture stays the same") {
  const Image image = scene(61, 37, 0);
  CHECK(resample(image, 61, 37, moved(0, 0)).pixels == image.pixels);
}

TEST_CASE("a shift by whole and by half pixels is that shift") {
  const Image image = ramp<uint8_t>(40, 20);
  const Image whole = resample(image, 30, 10, moved(3, 2));
  const Image half = resample(image, 30, 10, moved(3.5, 2.5));
  const DeepImage deep = resample(ramp<uint16_t>(40, 20), 30, 10, moved(3.25, 2.5));
  for (uint32_t y = 0; y < 10; y++)
    for (uint32_t x = 0; x < 30; x++) {
      const int before = 20 + 4 * int(x + 3) + 2 * int(y + 2);
      REQUIRE(whole.pixels[y * 30 + x] == before);
      REQUIRE(half.pixels[y * 30 + x] == before + 3);
      REQUIRE(deep.pixels[y * 30 + x] == before + 2);
    }
}

TEST_CASE("what the source does not show is 0, but for half a pixel at its border") {
  const Image white = make_image(20, 20, 1, 255);
  const Image out = resample(white, 24, 20, moved(-2.1, 0));
  const Image edge = resample(white, 20, 20, moved(-0.9, 0)); // the first centres lie 0.4 before the border
  for (uint32_t y = 0; y < 20; y++) {
    for (uint32_t x = 0; x < 24; x++) REQUIRE(out.pixels[y * 24 + x] == (x < 2 || x > 22 ? 0 : 255));
    for (uint32_t x = 0; x < 20; x++) REQUIRE(edge.pixels[y * 20 + x] == 255);
  }
  const Image holes = resample(white, 20, 20, [](double x, double y, double at[2]) {
    at[0] = x;
    at[1] = y;
    return x < 10;
  });
  for (uint32_t x = 0; x < 20; x++) CHECK(holes.pixels[x] == (x < 10 ? 255 : 0));
}

TEST_CASE("along a curved map a smooth picture follows the map") {
  Image image = make_image(300, 200, 1, 0);
  const auto wave = [](double x, double y) { return 128 + 100 * std::sin(x * 0.4) * std::cos(y * 0.3); };
  for (uint32_t y = 0; y < 200; y++)
    for (uint32_t x = 0; x < 300; x++)
      image.pixels[y * 300 + x] = uint8_t(std::lround(wave(x + 0.5, y + 0.5)));
  const PixelMap bent = [](double x, double y, double at[2]) {
    const double dx = (x - 140) / 200, dy = (y - 95) / 200, d = 1 - 0.4 * (dx * dx + dy * dy);
    at[0] = 150 + 200 * dx * d;
    at[1] = 100 + 200 * dy * d;
    return true;
  };
  const Image out = resample(image, 280, 190, bent);
  double worst = 0;
  for (uint32_t y = 0; y < 190; y++)
    for (uint32_t x = 0; x < 280; x++) {
      double at[2];
      bent(x + 0.5, y + 0.5, at);
      worst = std::max(worst, std::fabs(out.pixels[y * 280 + x] - wave(at[0], at[1])));
    }
  CHECK(worst < 2);
}
