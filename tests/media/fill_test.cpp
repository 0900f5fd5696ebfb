// fvv_media/frame.h: the smooth background.
#include "fvv_catch.h"
#include "fvv_media/frame.h"
#include "pictures.h"

using namespace fvv::media;

namespace {

// Two discs of a picture are kept.
Image discs(uint32_t width, uint32_t height) {
  Image keep = make_image(width, height, 1, 0);
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++)
      for (const int centre : {int(width) / 4, int(width) * 3 / 4}) {
        const int dx = int(x) - centre, dy = int(y) - int(height) / 2;
        if (dx * dx + dy * dy < 64) keep.pixels[size_t(y) * width + x] = 128;
      }
  return keep;
}

} // namespace

TEST_CASE("a smooth fill keeps what is kept, and stays between its values") {
  for (const auto &[width, height] : {std::pair(64u, 48u), std::pair(67u, 41u), std::pair(31u, 33u)}) {
    CAPTURE(width, height);
    const Image original = scene(width, height, 0), keep = discs(width, height);
    Image filled = original;
    fill_smoothly(filled, keep);
    uint8_t low[3] = {255, 255, 255}, high[3] = {0, 0, 0};
    size_t changed = 0;
    for (size_t i = 0; i < keep.pixels.size(); i++)
      for (size_t c = 0; c < 3; c++)
        if (keep.pixels[i] > 127) {
          low[c] = std::min(low[c], original.pixels[3 * i + c]);
          high[c] = std::max(high[c], original.pixels[3 * i + c]);
          changed += filled.pixels[3 * i + c] != original.pixels[3 * i + c];
        }
    size_t beyond = 0;
    for (size_t i = 0; i < filled.pixels.size(); i++)
      beyond += filled.pixels[i] < low[i % 3] || filled.pixels[i] > high[i % 3];
    CHECK(changed == 0);
    CHECK(beyond == 0);
  }
}

TEST_CASE("between black and white a smooth fill rises without a step") {
  Image image = make_image(64, 16, 1, 7), keep = make_image(64, 16, 1, 0);
  for (size_t y = 0; y < 16; y++) {
    keep.pixels[y * 64] = keep.pixels[y * 64 + 63] = 255;
    image.pixels[y * 64] = 0;
    image.pixels[y * 64 + 63] = 255;
  }
  fill_smoothly(image, keep);
  int steepest = 0;
  for (size_t x = 2; x < 62; x++) {
    const int rise = int(image.pixels[8 * 64 + x]) - int(image.pixels[8 * 64 + x - 1]);
    CHECK(rise >= 0);
    steepest = std::max(steepest, rise);
  }
  CHECK(steepest < 40);
  CHECK(std::abs(int(image.pixels[8 * 64 + 31]) - 127) < 12);
}

TEST_CASE("of one value a smooth fill makes that value, of nothing grey") {
  Image image = scene(40, 30, 1), keep = make_image(40, 30, 1, 0);
  fill_smoothly(image, keep);
  CHECK(image.pixels == make_image(40, 30, 3, flat_grey).pixels);
  DeepImage deep = make_image<uint16_t>(40, 30, 3, 0);
  keep.pixels[30] = keep.pixels[700] = 255;
  for (const size_t i : {30u, 700u})
    for (size_t c = 0; c < 3; c++) deep.pixels[3 * i + c] = 65535;
  fill_smoothly(deep, keep);
  CHECK(deep.pixels == make_image<uint16_t>(40, 30, 3, 65535).pixels);
  CHECK_THAT(error_of([&] { fill_smoothly(image, make_image(40, 31, 1, 0)); }),
             Contains("size of the picture"));
}

TEST_CASE("a body is extended over its silhouette, and nothing else changes") {
  constexpr int body[3] = {200, 120, 40}, behind[3] = {10, 60, 210};
  Image image = make_image(48, 32, 3, 0), mask = make_image(48, 32, 1, 0);
  DeepImage deep = make_image<uint16_t>(48, 32, 3, 0);
  for (size_t i = 0; i < image.pixels.size(); i++) {
    const bool inside = i / 3 % 48 < 24;
    mask.pixels[i / 3] = inside ? 128 : 127;
    image.pixels[i] = uint8_t(inside ? body[i % 3] : behind[i % 3]);
    deep.pixels[i] = uint16_t(257 * image.pixels[i]);
  }
  extend(image, mask, 8);
  extend(deep, mask, 8);
  size_t wrong = 0;
  for (size_t i = 0; i < image.pixels.size(); i++) {
    const int wanted = i / 3 % 48 < 32 ? body[i % 3] : behind[i % 3];
    wrong += image.pixels[i] != wanted || deep.pixels[i] != 257 * wanted;
  }
  CHECK(wrong == 0);
  CHECK_THAT(error_of([&] { extend(image, make_image(48, 31, 1, 0), 8); }), Contains("size of the picture"));
}

TEST_CASE("a guard band repeats the edge of the tile that is nearest") {
  const std::vector<fvv_tile> tiles = {{1, {0, 0, 20, 20}, {0, 0, 20, 20}},
                                       {2, {0, 0, 20, 20}, {32, 16, 20, 20}}};
  const Image frame = compose(tiles, {make_image(20, 20, 1, 10), make_image(20, 20, 1, 200)}, 64, 48);
  const auto at = [&](size_t x, size_t y) { return int(frame.pixels[y * 64 + x]); };
  CHECK(at(19, 18) == 10);
  CHECK(at(27, 18) == 10); // to the next multiple of 16, but for the other's band
  CHECK(at(28, 18) == 200);
  CHECK(at(31, 18) == 200);
  CHECK(at(40, 12) == 200);
  CHECK(at(40, 11) == flat_grey);
  CHECK(at(55, 47) == 200);
  CHECK(at(63, 30) == 200);
  CHECK(at(30, 5) == 10);
  CHECK(at(36, 5) == flat_grey);
}
