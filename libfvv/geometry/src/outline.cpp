#include "fvv_geometry/outline.h"
#include "fvv_render/normals.h"
#include "geometry/src/distance.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace fvv::geometry {

namespace {

// A jump in depth is farther than this many pixels are wide there, and this many times as far as the surface
// extends on either side: otherwise it is a slope.
constexpr double jump_pixels = 12, jump_slope = 4;

// Whether the surface, of depths z[0..3] at four samples in a row, breaks between the middle two.
bool breaks(const float z[4], double samples_per_depth) {
  const bool here = std::isfinite(z[1]), there = std::isfinite(z[2]);
  if (!here || !there) return here != there;
  const double jump = std::abs(double(z[2]) - z[1]);
  if (jump * samples_per_depth < jump_pixels * outline_samples * std::min(z[1], z[2])) return false;
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

ViewedSurface::ViewedSurface(const std::vector<double> &source, std::vector<uint32_t> triangles)
    : faces(std::move(triangles)) {
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
render::Projection ViewedSurface::projection(const fvv_camera &camera, render::Projection::Rays rays) const {
  fvv_camera moved = camera;
  for (int row = 0; row < 3; row++) {
    const double *r = camera.rotation + 3 * row;
    moved.translation[row] =
        (r[0] * origin[0] + r[1] * origin[1] + r[2] * origin[2] + camera.translation[row]) * scale;
  }
  return render::Projection(moved, rays);
}

render::Mesh ViewedSurface::mesh() const {
  return {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3};
}

bool ViewedSurface::inside_out() const {
  return render::inside_out(mesh());
}

std::vector<uint32_t> ViewedSurface::nearest(const fvv_camera &camera) const {
  render::SampleBuffer buffer(camera.width, camera.height, 1);
  rasterise(projection(camera), mesh(), buffer);
  return std::move(buffer.face);
}

std::vector<uint8_t> ViewedSurface::cover(const fvv_camera &camera) const {
  render::SampleBuffer buffer(camera.width, camera.height, 1);
  rasterise_coverage(projection(camera, render::Projection::Rays::none), mesh(), buffer);
  std::vector<uint8_t> out(buffer.face.size());
  std::transform(buffer.face.begin(), buffer.face.end(), out.begin(),
                 [](uint32_t face) { return face == render::no_face ? 0 : 255; });
  return out;
}

std::vector<float> ViewedSurface::outline_distance(const fvv_camera &camera, uint32_t width,
                                                   uint32_t height) const {
  constexpr uint32_t samples = outline_samples;
  render::SampleBuffer buffer(width, height, samples);
  const fvv_camera small = resized(camera, width, height);
  rasterise(projection(small), mesh(), buffer);
  return hull::distance_to(broken_samples(buffer, small.fx * samples), true, buffer.columns,
                           size_t(buffer.height) * samples);
}

namespace {

constexpr size_t least_outline = 16; // pixels, below which an offset means nothing

using Point = std::array<double, 2>; // pixels

// A mask's outline: the middles of the sides between pixels of different kinds, and the signed distance.
class Outline {
public:
  Outline(const std::vector<uint8_t> &mask, uint32_t w, uint32_t h)
      : width(w), height(h), distance(hull::signed_distance(mask, w, h)) {
    for (uint32_t y = 0; y < h; y++)
      for (uint32_t x = 0; x < w; x++) {
        const bool inside = mask[size_t(y) * w + x] != 0;
        if (x + 1 < w && inside != (mask[size_t(y) * w + x + 1] != 0)) points.push_back({x + 1.0, y + 0.5});
        if (y + 1 < h && inside != (mask[size_t(y + 1) * w + x] != 0)) points.push_back({x + 0.5, y + 1.0});
      }
  }

  // Signed distance from the outline, interpolated; beyond the picture that of its border.
  double at(Point p) const {
    const double x = std::clamp(p[0] - 0.5, 0.0, width - 1.0), y = std::clamp(p[1] - 0.5, 0.0, height - 1.0);
    const size_t i = size_t(x), j = size_t(y), right = i + 1 < width ? 1 : 0,
                 below = j + 1 < height ? width : 0;
    const float *d = &distance[j * width + i];
    const double s = x - double(i), t = y - double(j);
    return (d[0] * (1 - s) + d[right] * s) * (1 - t) + (d[below] * (1 - s) + d[below + right] * s) * t;
  }

  const uint32_t width, height;
  const std::vector<float> distance;
  std::vector<Point> points;
};

double mean_distance(const std::vector<Point> &points, const Outline &from) {
  double sum = 0;
  for (const Point &p : points) sum += std::abs(from.at(p));
  return sum / double(points.size());
}

// Gauss and Newton: the shift of the projected outline after which its distances from the mask's are least,
// over the points that are not far off from the others (a limb that the mesh lacks tells nothing about a
// shift).
std::optional<Point> offset_of(const Outline &projected, const Outline &mask) {
  if (projected.points.size() < least_outline || mask.points.size() < least_outline) return std::nullopt;
  Point shift = {0, 0};
  std::vector<double> sizes(projected.points.size());
  for (int step = 0; step < 12; step++) {
    const auto shifted = [&](const Point &p) { return Point{p[0] + shift[0], p[1] + shift[1]}; };
    for (size_t i = 0; i < sizes.size(); i++) sizes[i] = std::abs(mask.at(shifted(projected.points[i])));
    const double limit = 3 * *median(sizes) + 1;
    double xx = 0, xy = 0, yy = 0, xd = 0, yd = 0;
    for (size_t i = 0; i < sizes.size(); i++) {
      if (sizes[i] > limit) continue;
      const Point p = shifted(projected.points[i]);
      const double d = mask.at(p), gx = (mask.at({p[0] + 1, p[1]}) - mask.at({p[0] - 1, p[1]})) / 2,
                   gy = (mask.at({p[0], p[1] + 1}) - mask.at({p[0], p[1] - 1})) / 2;
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
      xd += gx * d;
      yd += gy * d;
    }
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 0.02 * (xx + yy) * (xx + yy))) return std::nullopt; // it slides along the outline
    shift[0] -= (yy * xd - xy * yd) / determinant;
    shift[1] -= (xx * yd - xy * xd) / determinant;
    if (!(std::abs(shift[0]) < mask.width / 4.0 && std::abs(shift[1]) < mask.height / 4.0))
      return std::nullopt;
  }
  return Point{-shift[0], -shift[1]};
}

bool near(double value, double wanted) {
  return std::abs(value - wanted) < 0.15;
}

// All offsets are about half a pixel in x and y, with one sign.
bool half_a_pixel(const std::vector<CameraMatch> &cameras) {
  std::vector<double> axes[2], spread[2];
  for (const CameraMatch &camera : cameras)
    for (int k = 0; camera.match.offset && k < 2; k++) axes[k].push_back((*camera.match.offset)[size_t(k)]);
  if (axes[0].size() < 3) return false;
  double middle[2];
  for (int k = 0; k < 2; k++) {
    middle[k] = *median(axes[k]);
    for (const double value : axes[k]) spread[k].push_back(std::abs(value - middle[k]));
  }
  return (near(middle[0], 0.5) || near(middle[0], -0.5)) && near(middle[1], middle[0]) &&
         *median(spread[0]) < 0.15 && *median(spread[1]) < 0.15;
}

} // namespace

std::optional<double> median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

std::optional<double> silhouette_iou(const std::vector<uint8_t> &a, const std::vector<uint8_t> &b) {
  uint64_t both = 0, either = 0;
  for (size_t i = 0; i < a.size(); i++) {
    both += a[i] && b[i];
    either += a[i] || b[i];
  }
  if (either == 0) return std::nullopt;
  return double(both) / double(either);
}

SilhouetteMatch compare(const std::vector<uint8_t> &projected, const std::vector<uint8_t> &mask,
                        uint32_t width, uint32_t height) {
  SilhouetteMatch match;
  match.iou = silhouette_iou(projected, mask);
  const Outline ours(projected, width, height), theirs(mask, width, height);
  if (ours.points.empty() != theirs.points.empty())
    match.distance = std::hypot(width, height);
  else if (!ours.points.empty())
    match.distance = (mean_distance(ours.points, theirs) + mean_distance(theirs.points, ours)) / 2;
  match.offset = offset_of(ours, theirs);
  return match;
}

MaskDifference difference(const std::vector<uint8_t> &projected, const std::vector<uint8_t> &mask,
                          uint32_t width, uint32_t height, double far) {
  MaskDifference out;
  const std::vector<float> distance = hull::signed_distance(mask, width, height, float(far) + 2);
  size_t sides = 0;
  for (size_t y = 0, i = 0; y < height; y++)
    for (size_t x = 0; x < width; x++, i++) {
      const bool inside = mask[i] != 0;
      sides += x + 1 < width && inside != (mask[i + 1] != 0);
      sides += y + 1 < height && inside != (mask[i + width] != 0);
      if (inside == (projected[i] != 0)) continue;
      (inside ? out.missed : out.extra)++;
      out.far += std::abs(double(distance[i])) > far;
    }
  // Over all directions a line crosses 4 / pi sides per pixel of its length.
  out.length = double(sides) * M_PI / 4;
  return out;
}

std::vector<size_t> outlier_cameras(const std::vector<CameraMatch> &cameras) {
  std::vector<size_t> measured, out;
  for (size_t i = 0; i < cameras.size(); i++)
    if (cameras[i].match.distance) measured.push_back(i);
  if (measured.size() < 3) return out;
  const auto relative = [&](size_t i) { return *cameras[i].match.distance / cameras[i].diagonal; };
  for (const size_t i : measured) {
    std::vector<double> others;
    for (const size_t k : measured)
      if (k != i) others.push_back(relative(k));
    if (relative(i) > 2 * *median(others) + 1 / cameras[i].diagonal) out.push_back(i);
  }
  std::stable_sort(out.begin(), out.end(), [&](size_t a, size_t b) { return relative(a) > relative(b); });
  return out;
}

Suspicion suspect(const std::vector<CameraMatch> &cameras) {
  const auto meets = [](const CameraMatch &camera) { return camera.match.iou && *camera.match.iou > 0; };
  const auto compared = [](const CameraMatch &camera) { return camera.match.iou.has_value(); };
  if (std::any_of(cameras.begin(), cameras.end(), compared) &&
      std::none_of(cameras.begin(), cameras.end(), meets))
    return Suspicion::misses_all;
  return half_a_pixel(cameras) ? Suspicion::half_pixel : Suspicion::nothing;
}

} // namespace fvv::geometry
