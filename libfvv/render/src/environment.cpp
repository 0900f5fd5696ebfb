#include "fvv_render/environment.h"

#include "surface.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace fvv::render {

namespace {

// IEC 61966-2-1.
double to_linear(double v) {
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}
double to_srgb(double v) {
  return v <= 0.0031308 ? v * 12.92 : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

// Index of a pixel along one side.
uint32_t wrapped(double index, uint32_t size, bool clamped) {
  if (clamped) return uint32_t(std::clamp(index, 0.0, double(size - 1)));
  return uint32_t(std::min(index - size * std::floor(index / size), double(size - 1)));
}

Vec3 texel(const EnvironmentImage &image, uint32_t x, uint32_t y) {
  const uint8_t *p = &image.pixels[3 * (size_t(y) * image.width + x)];
  return Vec3{double(p[0]), double(p[1]), double(p[2])} * (1 / 255.0);
}

Vec3 bilinear(const EnvironmentImage &image, double u, double v, bool clamped) {
  const double x = u * image.width - 0.5, y = v * image.height - 0.5;
  const double left = std::floor(x), top = std::floor(y), right = x - left, down = y - top;
  const uint32_t x0 = wrapped(left, image.width, clamped), x1 = wrapped(left + 1, image.width, clamped),
                 y0 = wrapped(top, image.height, clamped), y1 = wrapped(top + 1, image.height, clamped);
  return (texel(image, x0, y0) * (1 - right) + texel(image, x1, y0) * right) * (1 - down) +
         (texel(image, x0, y1) * (1 - right) + texel(image, x1, y1) * right) * down;
}

} // namespace

// The faces of all parts that show their front, as one mesh.
class Environment::Drawn : public Environment::View {
public:
  Drawn(const std::vector<EnvironmentPart> &all, const fvv_camera &target, uint32_t samples) : parts(all) {
    double centre[3];
    fvv_camera_centre(&target, centre);
    for (uint32_t i = 0; i < parts.size(); i++) add(i, {centre[0], centre[1], centre[2]});
    mesh = {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3};
    if (faces.empty()) return;
    if (target.lens != FVV_LENS_NONE) rays.emplace(mesh);
    surface.emplace(target, mesh, rays ? &*rays : nullptr, samples);
  }

  std::optional<EnvironmentPoint> at(uint32_t x, uint32_t y, uint32_t sample) const override {
    if (!surface) return {};
    const Hit hit = surface->at(x, y, sample);
    if (hit.face == no_face) return {};
    return EnvironmentPoint{hit.depth, colour(hit)};
  }

private:
  void add(uint32_t number, Vec3 eye) {
    const EnvironmentPart &part = parts[number];
    const uint32_t base = uint32_t(positions.size() / 3);
    positions.insert(positions.end(), part.positions.begin(), part.positions.end());
    const auto corner = [&](uint32_t index) {
      const float *p = &part.positions[3 * size_t(index)];
      return Vec3{p[0], p[1], p[2]};
    };
    for (size_t f = 0; f < part.faces.size(); f += 3) {
      const uint32_t *c = &part.faces[f];
      const Vec3 a = corner(c[0]), normal = cross(corner(c[1]) - a, corner(c[2]) - a);
      if (!part.double_sided && dot(normal, eye - a) <= 0) continue;
      faces.insert(faces.end(), {base + c[0], base + c[1], base + c[2]});
      part_of.push_back(number);
    }
    bases.push_back(base);
  }

  Vec3 colour(const Hit &hit) const {
    const uint32_t number = part_of[hit.face];
    const EnvironmentPart &part = parts[number];
    Vec3 display{1, 1, 1};
    if (part.picture) {
      double at[2] = {0, 0};
      for (size_t c = 0; c < 3; c++) {
        const size_t vertex = faces[3 * size_t(hit.face) + c] - bases[number];
        for (size_t k = 0; k < 2; k++) at[k] += hit.barycentric[c] * part.texture[2 * vertex + k];
      }
      display = bilinear(*part.picture, at[0], at[1], part.clamped);
    }
    const Vec3 f = part.colour;
    if (f.x == 1 && f.y == 1 && f.z == 1) return display;
    return {to_srgb(to_linear(display.x) * f.x), to_srgb(to_linear(display.y) * f.y),
            to_srgb(to_linear(display.z) * f.z)};
  }

  const std::vector<EnvironmentPart> &parts;
  std::vector<float> positions;
  std::vector<uint32_t> faces, part_of, bases; // part of each face, first vertex of each part
  Mesh mesh;
  std::optional<RayCaster> rays;
  std::optional<Surface> surface;
};

Environment::Environment(std::vector<EnvironmentPart> all) : parts(std::move(all)) {
  for (const EnvironmentPart &part : parts) {
    const size_t vertices = part.positions.size() / 3;
    if (std::any_of(part.faces.begin(), part.faces.end(),
                    [&](uint32_t index) { return index >= vertices; }) ||
        (part.picture && part.texture.size() != 2 * vertices))
      throw std::invalid_argument(
          "a part of an environment has indices or texture coordinates that do not fit "
          "its vertices");
  }
}
Environment::~Environment() = default;

std::unique_ptr<const Environment::View> Environment::view(const fvv_camera &target, uint32_t samples) const {
  return std::make_unique<const Drawn>(parts, target, samples);
}

} // namespace fvv::render
