#include "fvv_geometry/silhouette.h"
#include "geometry/src/distance.h"

#include <algorithm>
#include <cmath>

namespace fvv::hull {

namespace {

// Distances are exact up to this number of pixels. Cells that cover more are too coarse for the difference to
// matter.
constexpr uint32_t window_margin = 64;
constexpr double no_silhouette = 1e4; // pixels from an outline that is not there

// Binomial over 3 x 3 pixels: smooths the steps of the mask's edge. Rows and columns end at the border.
void smooth(std::vector<float> &d, size_t width, size_t height) {
  for (size_t y = 0; y < height; y++) {
    float *value = &d[y * width], before = value[0];
    for (size_t x = 0; x < width; x++) {
      const float here = value[x], after = value[std::min(x + 1, width - 1)];
      value[x] = 0.25f * before + 0.5f * here + 0.25f * after;
      before = here;
    }
  }
  std::vector<float> above(d.begin(), d.begin() + std::ptrdiff_t(width));
  for (size_t y = 0; y < height; y++) {
    float *value = &d[y * width];
    const float *below = &d[std::min(y + 1, height - 1) * width];
    for (size_t x = 0; x < width; x++) {
      const float here = value[x];
      value[x] = 0.25f * above[x] + 0.5f * here + 0.25f * below[x];
      above[x] = here;
    }
  }
}

} // namespace

Silhouette::Silhouette(const fvv_camera &from, const std::vector<uint8_t> &mask) : camera(from) {
  camera.name = nullptr;
  camera.name_size = 0;
  Box silhouette{camera.width, camera.height, 0, 0};
  for (uint32_t y = 0; y < camera.height; y++) {
    const uint8_t *row = &mask[size_t(y) * camera.width], *end = row + camera.width;
    const uint8_t *first = std::find_if(row, end, [](uint8_t v) { return v != 0; });
    if (first == end) continue;
    uint32_t last = camera.width;
    while (!row[last - 1]) last--;
    silhouette = {std::min(silhouette.left, uint32_t(first - row)), std::min(silhouette.top, y),
                  std::max(silhouette.right, last), y + 1};
  }
  if (silhouette.right == 0) return;
  const auto before = [](uint32_t v) { return v - std::min(v, window_margin); };
  const auto after = [](uint32_t v, uint32_t end) { return std::min(v + window_margin, end); };
  window = {before(silhouette.left), before(silhouette.top), after(silhouette.right, camera.width),
            after(silhouette.bottom, camera.height)};
  const size_t width = window.width(), height = window.height();
  std::vector<uint8_t> part(width * height);
  counts.resize((width + 1) * (height + 1));
  for (size_t y = 0; y < height; y++) {
    const uint8_t *row = &mask[(y + window.top) * camera.width + window.left];
    std::copy(row, row + width, &part[y * width]);
    uint32_t sum = 0;
    for (size_t x = 0; x < width; x++) {
      sum += row[x] != 0;
      counts[(y + 1) * (width + 1) + x + 1] = counts[y * (width + 1) + x + 1] + sum;
    }
  }
  distance = signed_distance(part, width, height, float(window_margin));
  smooth(distance, width, height);
}

double Silhouette::at(double u, double v) const {
  if (window.right == 0) return no_silhouette;
  const double x = std::clamp(u - 0.5, 0.0, camera.width - 1.0) - window.left,
               y = std::clamp(v - 0.5, 0.0, camera.height - 1.0) - window.top;
  const size_t width = window.width(), height = window.height();
  if (x < 0 || y < 0 || x > double(width - 1) || y > double(height - 1)) return window_margin;
  const size_t i = size_t(x), j = size_t(y), right = i + 1 < width ? 1 : 0,
               below = j + 1 < height ? width : 0;
  const double s = x - double(i), t = y - double(j);
  const float *d = &distance[j * width + i];
  const double upper = d[0] + (double(d[right]) - double(d[0])) * s;
  d += below;
  const double lower = d[0] + (double(d[right]) - double(d[0])) * s;
  return upper + (lower - upper) * t;
}

Silhouette::View Silhouette::view(const double world[3]) const {
  View view;
  if (!fvv_camera_project(&camera, world, view.pixel, &view.depth)) return view;
  view.seen = view.pixel[0] >= 0 && view.pixel[1] >= 0 && view.pixel[0] <= camera.width &&
              view.pixel[1] <= camera.height;
  if (!view.seen) return view;
  view.per_metre = camera.fx / view.depth;
  view.pixels = at(view.pixel[0], view.pixel[1]);
  view.metres = view.pixels / view.per_metre;
  return view;
}

uint64_t Silhouette::count(double left, double top, double right, double bottom) const {
  if (window.right == 0) return 0;
  const auto within = [](double v, uint32_t low, uint32_t high) {
    return size_t(std::clamp(v, double(low), double(high)) - low);
  };
  const size_t l = within(std::floor(left), window.left, window.right),
               r = within(std::ceil(right), window.left, window.right),
               t = within(std::floor(top), window.top, window.bottom),
               b = within(std::ceil(bottom), window.top, window.bottom), row = window.width() + 1;
  return uint64_t(counts[b * row + r]) + counts[t * row + l] - counts[t * row + r] - counts[b * row + l];
}

Silhouette::Ball Silhouette::ball(const double centre[3], double radius) const {
  const double *r = camera.rotation, *t = camera.translation;
  double c[3];
  for (int k = 0; k < 3; k++)
    c[k] = r[3 * k] * centre[0] + r[3 * k + 1] * centre[1] + r[3 * k + 2] * centre[2] + t[k];
  const double away = std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]), twice = 2 * radius;
  if (!(away > twice)) return Ball::unsure;
  const double widest = camera.lens == FVV_LENS_FISHEYE ? camera.r_max : std::atan(camera.r_max);
  if (std::acos(std::clamp(c[2] / away, -1.0, 1.0)) - std::asin(twice / away) > std::min(widest, M_PI / 2))
    return Ball::unseen;
  double pixel[2], depth;
  if (c[2] <= twice || !fvv_camera_project(&camera, centre, pixel, &depth)) return Ball::unsure;
  // A step across the ray moves the picture by the focal length over the depth; a step away from the axis by
  // away / depth times that. One pixel and a half is for smoothing.
  const double reach = twice * std::max(camera.fx, camera.fy) / (depth - radius) * (away / depth) + 1.5;
  const double left = pixel[0] - reach, right = pixel[0] + reach, top = pixel[1] - reach,
               bottom = pixel[1] + reach;
  if (right < 0 || bottom < 0 || left > camera.width || top > camera.height) return Ball::unseen;
  if (!(left > 0 && top > 0 && right < camera.width && bottom < camera.height)) return Ball::unsure;
  const uint64_t pixels = count(left, top, right, bottom);
  if (pixels == 0) return Ball::outside;
  const double area = (std::ceil(right) - std::floor(left)) * (std::ceil(bottom) - std::floor(top));
  return double(pixels) == area ? Ball::inside : Ball::unsure;
}

} // namespace fvv::hull
