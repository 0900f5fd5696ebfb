// Shading and resolving of samples to pixels.
#include "fvv_render/picture.h"

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>
#include <utility>

namespace fvv::render {

namespace {

using Corners = std::array<Vec3, 3>;

Corners corners_of(const float *values, const uint32_t *index) {
  Corners out;
  for (size_t i = 0; i < 3; i++) {
    const float *v = values + size_t(3) * index[i];
    out[i] = {v[0], v[1], v[2]};
  }
  return out;
}

Vec3 interpolated(const Corners &values, const std::array<double, 3> &weight) {
  Vec3 sum;
  for (size_t i = 0; i < 3; i++) sum += values[i] * weight[i];
  return sum;
}

// What the samples of one face have in common.
struct Facet {
  uint32_t face;
  FaceInterpolator interpolator;
  Corners normals, positions, texture;
  std::array<double, 3> exposure;

  Facet(const Projection &camera, const Mesh &mesh, const Attributes &attributes, uint32_t number)
      : face(number), interpolator(camera, mesh, number) {
    const uint32_t *index = mesh.faces + size_t(3) * number;
    normals = corners_of(attributes.normals, index);
    positions = corners_of(mesh.positions, index);
    texture = corners_of(attributes.texture, index);
    for (size_t k = 0; k < 3; k++) exposure[k] = double(attributes.exposure[index[k]]);
  }
};

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
  std::optional<Facet> facet; // that of the last sample, which most samples share with the one before
  const auto shaded = [&](uint32_t face, double u, double v) {
    if (!facet || facet->face != face) facet.emplace(camera, mesh, attributes, face);
    const auto weight = facet->interpolator.at(camera.ray(u, v));
    const Vec3 normal = normalised(interpolated(facet->normals, weight));
    const Vec3 towards_eye = normalised(eye - interpolated(facet->positions, weight));
    double exposure = 0;
    for (size_t k = 0; k < 3; k++) exposure += weight[k] * facet->exposure[k];
    return lit(material(face, interpolated(facet->texture, weight)), normal, towards_eye, exposure, light);
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
