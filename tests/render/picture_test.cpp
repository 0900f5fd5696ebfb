// Shading and resolving: coverage to mask and colour, depth at pixel centres, texture coordinates.
#include "fvv_catch.h"

#include "fvv_render/picture.h"

#include <cmath>
#include <limits>

using namespace fvv::render;

namespace {

// A square in the plane z = 2 whose left edge is at pixel position u, in front of a camera of 8 x 8 pixels;
// texture coordinates are its x and y.
struct Square {
  fvv_camera camera = {};
  std::vector<float> positions, normals, texture, exposure = std::vector<float>(4, 1.0f);
  std::vector<uint32_t> faces = {0, 1, 2, 0, 2, 3};

  explicit Square(double u) {
    camera.lens = FVV_LENS_NONE;
    camera.width = camera.height = 8;
    camera.fx = camera.fy = 8;
    camera.r_max = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 9; i += 4) camera.rotation[i] = 1;
    const double left = u / 8 * 2;
    for (const auto &p : {std::array<double, 2>{left, -1}, {4, -1}, {4, 4}, {left, 4}}) {
      for (const double value : {p[0], p[1], 2.0}) positions.push_back(float(value));
      for (const double value : {0.0, 0.0, -1.0}) normals.push_back(float(value));
      for (const double value : {p[0], p[1], 0.0}) texture.push_back(float(value));
    }
  }
  Picture draw(const Material &material, const LightField &background) const {
    SampleBuffer buffer(8, 8, 3);
    const Light light = {{0, 0, -1}, {0, 0, 0}, {1, 1, 1}, {1, 1, 1}}; // what is white comes out white
    return fvv::render::draw(Projection(camera), {positions.data(), 4, faces.data(), 2},
                             {normals.data(), texture.data(), exposure.data()}, material, light, background,
                             buffer);
  }
};

Reflectance white(uint32_t, Vec3) {
  return {{1, 1, 1}, 0};
}

} // namespace

TEST_CASE("a pixel is in the mask from half coverage on, and its colour is the mean of its samples") {
  LightField red;
  for (int i = 0; i < 64; i++) red.insert(red.end(), {1, 0, 0});
  // Samples of a pixel lie at 1/6, 3/6, 5/6: an edge at 0.4 leaves two of three columns, at 0.6 one.
  const Picture more = Square(3.4).draw(white, red), less = Square(3.6).draw(white, red);
  for (size_t y = 0; y < 8; y++)
    for (size_t x = 0; x < 8; x++) {
      const size_t at = y * 8 + x;
      CHECK(more.mask[at] == (x >= 3 ? 255 : 0));
      CHECK(less.mask[at] == (x >= 4 ? 255 : 0));
      const double share = x < 3 ? 0 : x > 3 ? 1 : 2.0 / 3;
      CHECK(more.rgb[3 * at] == 255);
      CHECK(more.rgb[3 * at + 1] == to_display(share));
      CHECK(more.rgb[3 * at + 2] == to_display(share));
      CHECK(std::isinf(more.depth[at]) == (x < 3)); // the centre of column 3 is covered
      if (x >= 3) CHECK(more.depth[at] == 2.0f);
      CHECK(std::isinf(less.depth[at]) == (x < 4));
    }
}

TEST_CASE("the material is evaluated at the texture coordinates of the sample") {
  double worst = 0;
  std::vector<Vec3> evaluated;
  const auto remember = [&](uint32_t, Vec3 texture) {
    evaluated.push_back(texture);
    return Reflectance{{0, 0, 0}, 0};
  };
  Square(0).draw(remember, {});
  REQUIRE(evaluated.size() == 24 * 24);
  size_t i = 0;
  for (int y = 0; y < 8; y++)
    for (int x = 0; x < 8; x++)
      for (int b = 0; b < 3; b++)
        for (int a = 0; a < 3; a++, i++) {
          const Vec3 expected = {(x + (a + 0.5) / 3) / 4, (y + (b + 0.5) / 3) / 4, 0};
          worst = std::max(worst, length(evaluated[i] - expected));
        }
  CHECK(worst < 1e-6);
}

TEST_CASE("display values and linear light come back, beyond white is white") {
  for (int value = 0; value < 256; value++)
    CHECK(int(to_display(to_linear(Rgb{value / 255.0, 0, 0}).x)) == value);
  CHECK(to_display(7) == 255);
  CHECK(to_display(-1) == 0);
}

TEST_CASE("a background of another size is refused") {
  CHECK_THROWS_AS(Square(0).draw(white, LightField(63 * 3)), std::invalid_argument);
}
