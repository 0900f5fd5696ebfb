// Colour, depth and mask of a textured, lit mesh in front of a background.
#pragma once

#include "fvv_render/rasteriser.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

namespace fvv::render {

// Red, green, blue. Reflectances and light are linear; 1 is white.
using Rgb = Vec3;

// Display value 0..1 <-> linear light. A gamma of exactly 2 instead of the sRGB curve: squares and square
// roots are the same on every machine, powers are not.
inline Rgb to_linear(Rgb display) {
  return product(display, display);
}
// Clamped, rounded to 8 bits.
inline uint8_t to_display(double linear) {
  return uint8_t(std::sqrt(std::clamp(linear, 0.0, 1.0)) * 255 + 0.5);
}

// Attributes of vertices. Borrowed; all have vertex_count entries.
struct Attributes {
  const float *normals = nullptr;  // unit vectors, three per vertex, world axes
  const float *texture = nullptr;  // three coordinates per vertex for the material (solid texture)
  const float *exposure = nullptr; // part of the surroundings' light that arrives, 0..1
};

struct Reflectance {
  Rgb colour;       // diffuse, linear
  double gloss = 0; // strength of the highlight
};

// Texture of a face at interpolated texture coordinates. Called from one thread for each picture, for every
// visible sample: finer detail than a pixel is averaged, not aliased.
using Material = std::function<Reflectance(uint32_t face, Vec3 texture)>;

// A distant lamp and surroundings that differ between above and below.
struct Light {
  Vec3 towards; // unit vector to the lamp, world axes
  Rgb lamp, above, below;
};

// Red, green and blue of each pixel, linear, rows from the top.
using LightField = std::vector<float>;

struct Picture {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgb;  // 3 bytes per pixel, rows from the top
  std::vector<uint8_t> mask; // 255: the mesh covers at least half of the samples of the pixel, else 0
  std::vector<float> depth;  // z_c at the pixel's centre, metres; +inf: no mesh there
};

// What a camera sees before it becomes 8-bit display values.
struct LitPicture {
  uint32_t width = 0, height = 0;
  LightField light;
  std::vector<uint8_t> mask; // as Picture's
  std::vector<float> depth;
};

// Draws mesh over background (of the camera's size; empty: black). buffer is working memory that is cleared
// and takes the camera's size first; its samples decide the quality. Throws std::invalid_argument when the
// background has another size. part: for pictures of which several are averaged, to save time: coverage is
// exact, but the colour of a pixel is that of one covered sample, the one with this number modulo their
// count.
LitPicture illuminate(const Projection &camera, const Mesh &mesh, const Attributes &attributes,
                      const Material &material, const Light &light, LightField background,
                      SampleBuffer &buffer, std::optional<uint32_t> part = {});
// Light as display values.
Picture displayed(LitPicture &&lit);
// Both in one.
Picture draw(const Projection &camera, const Mesh &mesh, const Attributes &attributes,
             const Material &material, const Light &light, const LightField &background,
             SampleBuffer &buffer);

} // namespace fvv::render
