// fvv_media/frame.h: tiles into a frame and back.
#include "fvv_catch.h"
#include "fvv_media/frame.h"
#include "pictures.h"

using namespace fvv::media;

namespace {

uint8_t sample(const Image &image, uint32_t x, uint32_t y, int channel = 0) {
  return image.pixels[(size_t(y) * image.width + x) * size_t(image.channels) + size_t(channel)];
}

} // namespace

TEST_CASE("tiles come back from the frame, edges fill the alignment gap, the rest is flat") {
  const std::vector<fvv_tile> tiles = {
      {3, {0, 0, 60, 45}, {0, 0, 60, 45}},   // as it is
      {7, {10, 20, 80, 40}, {64, 0, 40, 20}} // cropped and halved
  };
  const std::vector<Image> images = {scene(60, 45, 0), scene(100, 70, 3)};
  const Image frame = compose(tiles, images, 128, 64);
  CHECK(extract(frame, tiles[0]).pixels == images[0].pixels);
  CHECK(extract(frame, tiles[1]).pixels ==
        scale(crop(images[1], 10, 20, 80, 40), 40, 20, Filter::lanczos).pixels);
  for (int c = 0; c < 3; c++) {
    for (uint32_t x = 60; x < 64; x++) CHECK(sample(frame, x, 30, c) == sample(images[0], 59, 30, c));
    for (uint32_t y = 45; y < 48; y++) CHECK(sample(frame, 20, y, c) == sample(images[0], 20, 44, c));
    CHECK(sample(frame, 63, 47, c) == sample(images[0], 59, 44, c));
    CHECK(sample(frame, 30, 48, c) == sample(images[0], 30, 44, c)); // guard band
    CHECK(sample(frame, 30, 49, c) == flat_grey);
    CHECK(sample(frame, 111, 31, c) == sample(frame, 103, 19, c));
    CHECK(sample(frame, 112, 10, c) == flat_grey);
    CHECK(sample(frame, 80, 32, c) == flat_grey);
  }

  Image mask = make_image(60, 45, 1, 0);
  mask.pixels[44 * 60 + 59] = 255;
  const Image masks = compose_masks(tiles, {mask, Image()}, 128, 64);
  size_t counted = 0;
  for (const uint8_t value : masks.pixels) counted += value > 127;
  CHECK(counted == 1 + 40 * 20);
  CHECK(sample(masks, 59, 44) == 255);
  CHECK(sample(masks, 64, 0) == 255);
}

TEST_CASE("tiles that do not fit are refused by camera") {
  const Image image = scene(60, 45, 0);
  const fvv_tile tile = {5, {0, 0, 60, 45}, {0, 0, 60, 45}};
  fvv_tile bad = tile;
  bad.destination.x = 16;
  CHECK_THAT(error_of([&] { compose({bad}, {image}, 64, 48); }),
             Contains("camera 5 is not inside the frame"));
  bad = tile;
  bad.source.y = 1;
  CHECK_THAT(error_of([&] { compose({bad}, {image}, 64, 48); }),
             Contains("camera 5: the rectangle 60 x 45 at 0, 1"));
  bad = tile;
  bad.destination.height = 0;
  CHECK_THAT(error_of([&] { compose({bad}, {image}, 64, 48); }), Contains("camera 5"));
  CHECK_THAT(error_of([&] {
               compose({tile, tile}, {image}, 64, 48);
             }),
             Contains("2 tiles came with 1 pictures"));
  CHECK_THAT(error_of([&] {
               compose({tile, tile}, {image, make_image(60, 45, 1, 0)}, 64, 48);
             }),
             Contains("1 channels, the first one has 3"));
  CHECK_THAT(error_of([&] { compose_masks({tile}, {image}, 64, 48); }), Contains("not grey"));
  CHECK_THAT(error_of([&] { extract(image, {5, {}, {1, 0, 60, 45}}); }), Contains("not inside"));
}

TEST_CASE("flattening keeps what is within the margin, in both axes alike") {
  const Image original = scene(50, 40, 0);
  Image mask = make_image(50, 40, 1, 127);
  mask.pixels[10 * 50 + 20] = 128;
  mask.pixels[39 * 50 + 49] = 200;
  for (const uint32_t margin : {0u, 1u, 5u, 1000u}) {
    CAPTURE(margin);
    Image image = original;
    flatten(image, mask, margin);
    size_t wrong = 0;
    for (uint32_t y = 0; y < 40; y++)
      for (uint32_t x = 0; x < 50; x++) {
        const auto distance = [&](int to_x, int to_y) {
          return uint32_t(std::max(std::abs(int(x) - to_x), std::abs(int(y) - to_y)));
        };
        const bool kept = distance(20, 10) <= margin || distance(49, 39) <= margin;
        for (int c = 0; c < 3; c++)
          wrong += sample(image, x, y, c) != (kept ? sample(original, x, y, c) : flat_grey);
      }
    CHECK(wrong == 0);
  }
  Image image = original;
  CHECK_THAT(error_of([&] { flatten(image, make_image(50, 41, 1, 0), 1); }), Contains("size of the picture"));
  flatten(image, make_image(50, 40, 1, 0), 1000);
  CHECK(image.pixels == make_image(50, 40, 3, flat_grey).pixels);
}
