#include "fvvmux/body.h"

#include "fvv_render/winding.h"
#include "fvvmux/overlay.h"
#include "hull/distance.h"

#include <algorithm>
#include <stdexcept>

namespace fvv::mux {

namespace {

constexpr uint32_t samples = 3;       // along a side of a pixel, for smooth lines
constexpr double core = 0.7, rim = 2; // pixels from the middle of the line
// A jump in depth is farther than this many pixels are wide there, and this many times as far as the surface
// goes on either side: otherwise it is a slope.
constexpr double jump_pixels = 12, jump_slope = 4;

// Whether the surface, of depths z[0..3] at four samples in a row, breaks between the middle two.
bool breaks(const float z[4], double samples_per_depth) {
  const bool here = std::isfinite(z[1]), there = std::isfinite(z[2]);
  if (!here || !there) return here != there;
  const double jump = std::abs(double(z[2]) - z[1]);
  if (jump * samples_per_depth < jump_pixels * samples * std::min(z[1], z[2])) return false;
  const double before = std::isfinite(z[0]) ? std::abs(double(z[1]) - z[0]) : 0;
  const double after = std::isfinite(z[3]) ? std::abs(double(z[3]) - z[2]) : 0;
  return jump > jump_slope * std::max(before, after);
}

// The samples on both sides of every break.
std::vector<uint8_t> broken_samples(const render::SampleBuffer &buffer, double samples_per_depth) {
  const size_t columns = buffer.columns, rows = size_t(buffer.height) * buffer.samples;
  std::vector<uint8_t> broken(buffer.depth.size());
  const auto walk = [&](size_t from, size_t count, size_t stride) {
    const auto depth = [&](size_t i) { return buffer.depth[from + i * stride]; };
    for (size_t i = 0; i + 1 < count; i++) {
      const float z[4] = {i ? depth(i - 1) : INFINITY, depth(i), depth(i + 1),
                          i + 2 < count ? depth(i + 2) : INFINITY};
      if (breaks(z, samples_per_depth)) broken[from + i * stride] = broken[from + (i + 1) * stride] = 1;
    }
  };
  for (size_t y = 0; y < rows; y++) walk(y * columns, columns, 1);
  for (size_t x = 0; x < columns; x++) walk(x, rows, columns);
  return broken;
}

} // namespace

fvv_camera resized(const fvv_camera &camera, uint32_t width, uint32_t height) {
  fvv_camera out = camera;
  const double x = double(width) / camera.width, y = double(height) / camera.height;
  out.width = width;
  out.height = height;
  out.fx *= x;
  out.skew *= x;
  out.cx *= x;
  out.fy *= y;
  out.cy *= y;
  return out;
}

Body::Body(const std::vector<double> &source, std::vector<uint32_t> triangles) : faces(std::move(triangles)) {
  if (source.empty()) return;
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < source.size(); i++) {
    if (!std::isfinite(source[i]))
      throw std::invalid_argument("vertex " + std::to_string(i / 3) + " has a coordinate that is not finite");
    low[i % 3] = std::min(low[i % 3], source[i]);
    high[i % 3] = std::max(high[i % 3], source[i]);
  }
  double size = 0;
  for (int k = 0; k < 3; k++) {
    origin[k] = low[k] / 2 + high[k] / 2;
    size = std::max(size, high[k] - low[k]);
  }
  if (size > 0 && std::isfinite(1 / size)) scale = 1 / size;
  positions.resize(source.size());
  for (size_t i = 0; i < source.size(); i++) positions[i] = float((source[i] - origin[i % 3]) * scale);
}

// R X + t = (R x + (R origin + t) scale) / scale with x = (X - origin) scale; pixels don't see the factor.
render::Projection Body::projection(const fvv_camera &camera) const {
  fvv_camera moved = camera;
  for (int row = 0; row < 3; row++) {
    const double *r = camera.rotation + 3 * row;
    moved.translation[row] =
        (r[0] * origin[0] + r[1] * origin[1] + r[2] * origin[2] + camera.translation[row]) * scale;
  }
  return render::Projection(moved);
}

render::Mesh Body::mesh() const {
  return {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3};
}

bool Body::inside_out() const {
  return render::inside_out(mesh());
}

std::vector<uint32_t> Body::nearest(const fvv_camera &camera) const {
  render::SampleBuffer buffer(camera.width, camera.height, 1);
  rasterise(projection(camera), mesh(), buffer);
  return std::move(buffer.face);
}

std::vector<uint8_t> Body::cover(const fvv_camera &camera) const {
  const std::vector<uint32_t> nearest_face = nearest(camera);
  std::vector<uint8_t> out(nearest_face.size());
  std::transform(nearest_face.begin(), nearest_face.end(), out.begin(),
                 [](uint32_t face) { return face == render::no_face ? 0 : 255; });
  return out;
}

void Body::draw_outline(const fvv_camera &camera, media::Image &image) const {
  if (empty()) return;
  render::SampleBuffer buffer(image.width, image.height, samples);
  const fvv_camera small = resized(camera, image.width, image.height);
  rasterise(projection(small), mesh(), buffer);
  const std::vector<float> distance = hull::distance_to(broken_samples(buffer, small.fx * samples), true,
                                                        buffer.columns, size_t(buffer.height) * samples);
  for (uint32_t y = 0; y < image.height; y++)
    for (uint32_t x = 0; x < image.width; x++) {
      int light_samples = 0, dark_samples = 0;
      for (uint32_t row = 0; row < samples; row++)
        for (uint32_t column = 0; column < samples; column++) {
          const float d =
              distance[(size_t(y) * samples + row) * buffer.columns + size_t(x) * samples + column];
          light_samples += d <= core * samples;
          dark_samples += d > core * samples && d <= rim * samples;
        }
      if (dark_samples) blend(image, x, y, dark, 0.8 * dark_samples / (samples * samples));
      if (light_samples) blend(image, x, y, light, double(light_samples) / (samples * samples));
    }
}

} // namespace fvv::mux
