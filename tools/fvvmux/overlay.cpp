#include "fvvmux/overlay.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

constexpr double rim = 1; // pixels

} // namespace

void blend(media::Image &image, uint32_t x, uint32_t y, Colour colour, double alpha) {
  if (x >= image.width || y >= image.height) return;
  uint8_t *p = &image.pixels[3 * (static_cast<size_t>(y) * image.width + x)];
  const uint8_t to[3] = {colour.red, colour.green, colour.blue};
  for (int i = 0; i < 3; i++) p[i] = static_cast<uint8_t>(std::lround(p[i] + (to[i] - p[i]) * alpha));
}

void fill(media::Image &image, const Box &box, Colour colour, double alpha) {
  for (uint32_t y = box.top; y < std::min(box.bottom, image.height); y++)
    for (uint32_t x = box.left; x < std::min(box.right, image.width); x++) blend(image, x, y, colour, alpha);
}

void frame(media::Image &image, const Box &box, uint32_t thickness, Colour colour) {
  fill(image, {box.left, box.top, box.right, box.top + thickness}, colour, 1);
  fill(image, {box.left, box.bottom - thickness, box.right, box.bottom}, colour, 1);
  fill(image, {box.left, box.top, box.left + thickness, box.bottom}, colour, 1);
  fill(image, {box.right - thickness, box.top, box.right, box.bottom}, colour, 1);
}

void tint(media::Image &image, const media::Image &shares, Colour colour, double alpha) {
  for (uint32_t y = 0; y < image.height; y++)
    for (uint32_t x = 0; x < image.width; x++)
      if (const uint8_t share = shares.pixels[static_cast<size_t>(y) * image.width + x])
        blend(image, x, y, colour, alpha * share / 255);
}

Lines::Lines(uint32_t w, uint32_t h)
    : width(w), height(h), inner(static_cast<size_t>(w) * h), outer(inner.size()) {}

void Lines::add(Pixel a, Pixel b, double core) {
  for (const Pixel &end : {a, b})
    if (!(end[0] >= -double(width) && end[0] <= 2.0 * width && end[1] >= -double(height) &&
          end[1] <= 2.0 * height))
      return;
  cover(inner, a, b, core / 2);
  cover(outer, a, b, core / 2 + rim);
}

// What lies within radius of the line, softened over one pixel.
void Lines::cover(std::vector<float> &share, Pixel a, Pixel b, double radius) const {
  const double dx = b[0] - a[0], dy = b[1] - a[1], squared = dx * dx + dy * dy, reach = radius + 1;
  const auto first = [&](double u) { return static_cast<uint32_t>(std::max(0.0, std::floor(u - reach))); };
  const auto last = [&](double u, uint32_t size) {
    return static_cast<uint32_t>(std::clamp(std::ceil(u + reach), 0.0, static_cast<double>(size)));
  };
  for (uint32_t y = first(std::min(a[1], b[1])); y < last(std::max(a[1], b[1]), height); y++)
    for (uint32_t x = first(std::min(a[0], b[0])); x < last(std::max(a[0], b[0]), width); x++) {
      const double px = x + 0.5 - a[0], py = y + 0.5 - a[1];
      const double along = squared > 0 ? std::clamp((px * dx + py * dy) / squared, 0.0, 1.0) : 0;
      const double ex = px - along * dx, ey = py - along * dy;
      float &value = share[static_cast<size_t>(y) * width + x];
      value = std::max(value,
                       static_cast<float>(std::clamp(radius + 0.5 - std::sqrt(ex * ex + ey * ey), 0.0, 1.0)));
    }
}

void Lines::draw(media::Image &image, Colour colour, double alpha) const {
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++) {
      const size_t i = static_cast<size_t>(y) * width + x;
      if (outer[i] > 0) blend(image, x, y, dark, 0.7 * alpha * outer[i]);
      if (inner[i] > 0) blend(image, x, y, colour, alpha * inner[i]);
    }
}

void paste(media::Image &image, const media::Image &part, uint32_t x, uint32_t y) {
  for (uint32_t row = 0; row < part.height; row++)
    std::copy_n(&part.pixels[size_t(3) * row * part.width], size_t(3) * part.width,
                &image.pixels[3 * (static_cast<size_t>(y + row) * image.width + x)]);
}

} // namespace fvv::mux
