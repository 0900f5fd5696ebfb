// Shading and resolving of samples to pixels.
#include "fvv_render/picture.h"

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>
#include <utility>

namespace fvv::render {

uint8_t to_display(double linear) {
  return uint8_t(std::floor(std::sqrt(std::clamp(linear, 0.0, 1.0)) * 255 + 0.5));
}

namespace {

Vec3 interpolated(const float *values, const uint32_t *index, const std::array<double, 3> &weight) {
  Vec3 sum;
  for (int i = 0; i < 3; i++) {
    const float *v = values + size_t(3) * index[i];
    sum += Vec3{v[0], v[1], v[2]} * weight[size_t(i)];
  }
  return sum;
}

// Lambert's law for lamp and surroundings (hemisphere light), and Blinn's highlight with exponent 32.
Rgb lit(const Reflectance &surface, Vec3 normal, Vec3 towards_eye, double exposure, const Light &light) {
  const double incidence = std::max(0.0, dot(normal, light.towards));
  const Rgb surroundings = mix(light.below, light.above, 0.5 + 0.5 * normal.y) * exposure;
  double highlight = std::max(0.0, dot(normal, normalised(light.towards + towards_eye)));
  for (int i = 0; i < 5; i++) highlight *= highlight;
  const Rgb diffuse =
      product(surface.colour, light.lamp * (incidence * (0.4 + 0.6 * exposure)) + surroundings);
  return diffuse + light.lamp * (surface.gloss * highlight * exposure);
}

} // namespace

LitPicture illuminate(const Projection &camera, const Mesh &mesh, const Attributes &attributes,
                      const Material &material, const Light &light, LightField background,
                      SampleBuffer &buffer, std::optional<uint32_t> part) {
  const size_t pixels = size_t(camera.width()) * camera.height();
  if (!background.empty() && background.size() != 3 * pixels)
    throw std::invalid_argument("the background does not have one colour for each pixel of the camera");
  buffer.resize(camera.width(), camera.height());
  rasterise(camera, mesh, buffer);

  LitPicture picture;
  picture.width = camera.width();
  picture.height = camera.height();
  picture.light = std::move(background);
  picture.light.resize(pixels * 3);
  picture.mask.resize(pixels);
  picture.depth.resize(pixels, std::numeric_limits<float>::infinity());
  const uint32_t n = buffer.samples;
  const Vec3 eye = camera.centre();
  const auto shaded = [&](uint32_t face, double u, double v) {
    const auto weight = barycentric(camera, mesh, face, u, v);
    const uint32_t *index = mesh.faces + size_t(3) * face;
    const Vec3 normal = normalised(interpolated(attributes.normals, index, weight));
    const Vec3 towards_eye = normalised(eye - interpolated(mesh.positions, index, weight));
    double exposure = 0;
    for (size_t k = 0; k < 3; k++) exposure += weight[k] * double(attributes.exposure[index[k]]);
    return lit(material(face, interpolated(attributes.texture, index, weight)), normal, towards_eye, exposure,
               light);
  };
  const SampleBuffer::Extent &drawn = buffer.drawn;
  std::array<uint32_t, 49> covering{}; // numbers of the samples of a pixel that the mesh covers
  for (size_t y = drawn.top / n; y * n < drawn.bottom; y++)
    for (size_t x = drawn.left / n; x * n < drawn.right; x++) {
      uint32_t covered = 0;
      const auto face = [&](uint32_t sample) {
        return buffer.face[(y * n + sample / n) * buffer.columns + x * n + sample % n];
      };
      for (uint32_t sample = 0; sample < n * n; sample++)
        if (face(sample) != no_face) covering[covered++] = sample;
      if (covered == 0) continue;
      const auto colour_of = [&](uint32_t sample) {
        return shaded(face(sample), double(x) + (sample % n + 0.5) / n, double(y) + (sample / n + 0.5) / n);
      };
      Rgb sum;
      if (part)
        sum = colour_of(covering[*part % covered]) * double(covered);
      else
        for (uint32_t i = 0; i < covered; i++) sum += colour_of(covering[i]);
      const size_t pixel = y * picture.width + x;
      float *colour = &picture.light[3 * pixel];
      sum += Rgb{colour[0], colour[1], colour[2]} * double(n * n - covered);
      const Rgb mean = sum * (1.0 / (n * n));
      colour[0] = float(mean.x);
      colour[1] = float(mean.y);
      colour[2] = float(mean.z);
      picture.mask[pixel] = 2 * covered >= n * n ? 255 : 0;
      picture.depth[pixel] = buffer.depth[(y * n + n / 2) * buffer.columns + x * n + n / 2];
    }
  return picture;
}

Picture displayed(LitPicture &&lit) {
  Picture picture;
  picture.width = lit.width;
  picture.height = lit.height;
  picture.rgb.reserve(lit.light.size());
  for (const float value : lit.light) picture.rgb.push_back(to_display(double(value)));
  picture.mask = std::move(lit.mask);
  picture.depth = std::move(lit.depth);
  return picture;
}

Picture draw(const Projection &camera, const Mesh &mesh, const Attributes &attributes,
             const Material &material, const Light &light, const LightField &background,
             SampleBuffer &buffer) {
  return displayed(illuminate(camera, mesh, attributes, material, light, background, buffer));
}

} // namespace fvv::render
