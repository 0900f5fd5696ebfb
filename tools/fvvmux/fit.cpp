#include "fvvmux/fit.h"

#include "hull/distance.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

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
// over the points that are not far off from the others (a limb that the mesh lacks says nothing of a shift).
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

// All offsets alike, at half a pixel in x and y, of one sign.
bool half_a_pixel(const std::vector<Measured> &cameras) {
  std::vector<double> axes[2], spread[2];
  for (const Measured &camera : cameras)
    for (int k = 0; camera.fit.offset && k < 2; k++) axes[k].push_back((*camera.fit.offset)[size_t(k)]);
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

Fit compare(const std::vector<uint8_t> &projected, const std::vector<uint8_t> &mask, uint32_t width,
            uint32_t height) {
  Fit fit;
  uint64_t both = 0, either = 0;
  for (size_t i = 0; i < mask.size(); i++) {
    both += projected[i] && mask[i];
    either += projected[i] || mask[i];
  }
  if (either) fit.iou = double(both) / double(either);
  const Outline ours(projected, width, height), theirs(mask, width, height);
  if (ours.points.empty() != theirs.points.empty())
    fit.distance = std::hypot(width, height);
  else if (!ours.points.empty())
    fit.distance = (mean_distance(ours.points, theirs) + mean_distance(theirs.points, ours)) / 2;
  fit.offset = offset_of(ours, theirs);
  return fit;
}

std::vector<size_t> standing_out(const std::vector<Measured> &cameras) {
  std::vector<size_t> measured, out;
  for (size_t i = 0; i < cameras.size(); i++)
    if (cameras[i].fit.distance) measured.push_back(i);
  if (measured.size() < 3) return out;
  const auto relative = [&](size_t i) { return *cameras[i].fit.distance / cameras[i].diagonal; };
  for (const size_t i : measured) {
    std::vector<double> others;
    for (const size_t k : measured)
      if (k != i) others.push_back(relative(k));
    if (relative(i) > 2 * *median(others) + 1 / cameras[i].diagonal) out.push_back(i);
  }
  std::stable_sort(out.begin(), out.end(), [&](size_t a, size_t b) { return relative(a) > relative(b); });
  return out;
}

Suspicion suspect(const std::vector<Measured> &cameras) {
  const auto meets = [](const Measured &camera) { return camera.fit.iou && *camera.fit.iou > 0; };
  const auto compared = [](const Measured &camera) { return camera.fit.iou.has_value(); };
  if (std::any_of(cameras.begin(), cameras.end(), compared) &&
      std::none_of(cameras.begin(), cameras.end(), meets))
    return Suspicion::misses_all;
  return half_a_pixel(cameras) ? Suspicion::half_pixel : Suspicion::nothing;
}

} // namespace fvv::mux
