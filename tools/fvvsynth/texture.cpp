#include "fvvsynth/texture.h"

#include "fvv_cxx/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fvv::synth {

namespace {

// Display values as linear light.
const std::array<float, 256> linear = [] {
  std::array<float, 256> table{};
  for (size_t i = 0; i < 256; i++) table[i] = float(double(i * i) / (255.0 * 255.0));
  return table;
}();

} // namespace

Texture::Texture(double width, double height, double texel, const std::function<Row(double t)> &paint,
                 uint32_t threads)
    : spacing(texel) {
  const auto count = [&](double side) { return std::max<size_t>(1, size_t(std::ceil(side / texel))); };
  Level first = {count(width), count(height), {}};
  first.rgb.resize(first.columns * first.rows * 3);
  fvv::parallel(threads, first.rows, [&](size_t row) {
    const Row painter = paint((double(row) + 0.5) * texel);
    uint8_t *out = &first.rgb[row * first.columns * 3];
    for (size_t i = 0; i < first.columns; i++) {
      const Rgb colour = painter((double(i) + 0.5) * texel);
      for (const double value : {colour.x, colour.y, colour.z}) *out++ = render::to_display(value);
    }
  });
  levels.push_back(std::move(first));
  while (levels.back().columns > 1 || levels.back().rows > 1) {
    const Level &fine = levels.back();
    Level coarse = {(fine.columns + 1) / 2, (fine.rows + 1) / 2, {}};
    coarse.rgb.reserve(coarse.columns * coarse.rows * 3);
    for (size_t y = 0; y < coarse.rows; y++)
      for (size_t x = 0; x < coarse.columns; x++)
        for (size_t channel = 0; channel < 3; channel++) {
          const auto value = [&](size_t column, size_t row) {
            const size_t at =
                std::min(row, fine.rows - 1) * fine.columns + std::min(column, fine.columns - 1);
            return double(linear[fine.rgb[3 * at + channel]]);
          };
          coarse.rgb.push_back(render::to_display((value(2 * x, 2 * y) + value(2 * x + 1, 2 * y) +
                                                   value(2 * x, 2 * y + 1) + value(2 * x + 1, 2 * y + 1)) /
                                                  4));
        }
    levels.push_back(std::move(coarse));
  }
}

Rgb Texture::bilinear(const Level &level, double column, double row) const {
  const double x = std::clamp(column, 0.0, double(level.columns - 1)),
               y = std::clamp(row, 0.0, double(level.rows - 1));
  const size_t left = size_t(x), top = size_t(y);
  const float u = float(x - double(left)), v = float(y - double(top));
  const size_t right = left + 1 < level.columns ? 3 : 0, below = top + 1 < level.rows ? 3 * level.columns : 0;
  const uint8_t *p = &level.rgb[3 * (top * level.columns + left)];
  const auto channel = [&](size_t c) {
    const float a = linear[p[c]], b = linear[p[c + right]], d = linear[p[c + below]],
                e = linear[p[c + below + right]];
    const float upper = a + (b - a) * u, lower = d + (e - d) * u;
    return double(upper + (lower - upper) * v);
  };
  return {channel(0), channel(1), channel(2)};
}

Rgb Texture::at(double s, double t, double footprint) const {
  // The binary logarithm with its fraction taken as linear: smooth enough between levels.
  int exponent = 0;
  const double mantissa = std::frexp(std::max(1.0, footprint / spacing), &exponent);
  const double scale = std::min(double(levels.size() - 1), exponent - 1 + (2 * mantissa - 1));
  const size_t fine = size_t(scale);
  const auto on = [&](size_t level) {
    const double texel = std::ldexp(spacing, int(level));
    return bilinear(levels[level], s / texel - 0.5, t / texel - 0.5);
  };
  const double between = scale - double(fine);
  return between > 0 ? mix(on(fine), on(fine + 1), between) : on(fine);
}

} // namespace fvv::synth
