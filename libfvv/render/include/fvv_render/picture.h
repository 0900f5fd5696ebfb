// fvv_render/picture.h: colour, depth and mask of a textured, lit mesh in front of a background. Knows the
// rasteriser; knows no scene: materials are callbacks, light is a few numbers.
#pragma once

#include "fvv_render/rasteriser.h"

#include <functional>

namespace fvv::render {

// Red, green, blue. Reflectances and light are linear; 1 is white.
using Rgb = Vec3;

// Display value 0..1 <-> linear light. A gamma of exactly 2 instead of the sRGB curve: squares and square
// roots are the same on every machine, powers are not.
inline Rgb to_linear(Rgb display) {
  return product(display, display);
}
uint8_t to_display(double linear); // clamped, rounded to 8 bits

// What the vertices carry besides their position. Borrowed; all have vertex_count entries.
struct Attributes {
  const float *normals = nullptr;  // unit vectors, three per vertex, world axes
  const float *texture = nullptr;  // three coordinates per vertex for the material (solid texture)
  const float *exposure = nullptr; // share of the surroundings' light that arrives, 0..1
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

struct Picture {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgb;  // 3 bytes per pixel, rows from the top
  std::vector<uint8_t> mask; // 255: the mesh covers at least half of the samples of the pixel, else 0
  std::vector<float> depth;  // z_c at the pixel's centre, metres; +inf: no mesh there
};

// Draws mesh over background (linear, width x height, may be empty: black). buffer is working memory of the
// camera's size that is cleared first; its samples decide the quality. Throws as rasterise.
Picture draw(const Projection &camera, const Mesh &mesh, const Attributes &attributes,
             const Material &material, const Light &light, const std::vector<Rgb> &background,
             SampleBuffer &buffer);

} // namespace fvv::render
