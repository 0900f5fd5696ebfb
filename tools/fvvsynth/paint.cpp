#include "fvvsynth/paint.h"

#include "fvv_cxx/parallel.h"
#include "fvvsynth/look.h"
#include "fvvsynth/random.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

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

namespace {

using render::to_linear;

double line(double distance) {
  return 1 - smoothstep(0.024, 0.028, std::abs(distance));
}

// 1 within, 0 outside a distance; the edge as soft as the texels are wide.
double within(double distance, double limit) {
  return 1 - smoothstep(limit - 0.008, limit + 0.008, distance);
}

// Maple boards along x.
Rgb wood(double x, double z, uint32_t key) {
  constexpr double width = 0.095, board_length = 1.6;
  const int32_t row = int32_t(std::floor(z / width));
  const double shifted = x + 5 * cell_value(row, 0, 0, key);
  const int32_t board = int32_t(std::floor(shifted / board_length));
  const double tone = cell_value(row, board, 1, key);
  const double grain = turbulence({x * 2.2, z * 38, double(row)}, key + 1);
  const double joint = std::min(z / width - row, 1 - (z / width - row)) * width;
  const double end = shifted - board * board_length;
  const double gap = smoothstep(0.0, 0.004, std::min(joint, std::min(end, board_length - end)));
  const Rgb base = mix(Rgb{0.50, 0.29, 0.13}, Rgb{0.60, 0.38, 0.19}, tone);
  return base * ((0.78 + 0.34 * grain) * (0.6 + 0.4 * gap));
}

// Ground and figure of what is printed, display values.
struct Print {
  Rgb ground, figure;
};
constexpr Print prints[] = {
    {{0.16, 0.17, 0.21}, {0.93, 0.92, 0.89}}, {{0.92, 0.91, 0.88}, {0.72, 0.12, 0.14}},
    {{0.12, 0.24, 0.58}, {0.95, 0.94, 0.92}}, {{0.76, 0.14, 0.14}, {0.97, 0.93, 0.85}},
    {{0.93, 0.70, 0.16}, {0.13, 0.13, 0.16}}, {{0.10, 0.40, 0.28}, {0.95, 0.90, 0.72}},
    {{0.90, 0.90, 0.90}, {0.12, 0.26, 0.60}}, {{0.13, 0.14, 0.17}, {0.93, 0.48, 0.14}}};

Print print_of(int32_t number, uint32_t key) {
  const Print &print = prints[size_t(cell_value(number, 0, 5, key) * std::size(prints))];
  return {to_linear(print.ground), to_linear(print.figure)};
}

double segment_distance(Vec3 p, Vec3 a, Vec3 b) {
  const double t = std::clamp(dot(p - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
  return length(p - a - (b - a) * t);
}

// From the strokes of "fvv", 1 high, about the origin.
double name_distance(double x, double y) {
  static constexpr Vec3 strokes[][2] = {
      {{-0.62, -0.5, 0}, {-0.62, 0.35, 0}}, {{-0.62, 0.35, 0}, {-0.48, 0.5, 0}},
      {{-0.80, 0.12, 0}, {-0.46, 0.12, 0}}, {{-0.32, 0.15, 0}, {-0.08, -0.5, 0}},
      {{-0.08, -0.5, 0}, {0.16, 0.15, 0}},  {{0.40, 0.15, 0}, {0.64, -0.5, 0}},
      {{0.64, -0.5, 0}, {0.88, 0.15, 0}}};
  double nearest = 1e9;
  for (const auto &stroke : strokes)
    nearest = std::min(nearest, segment_distance({x, y, 0}, stroke[0], stroke[1]));
  return nearest;
}

// Advertising boards, 2.4 m long and 0.9 m high, of five kinds.
constexpr double board_length = 2.4, board_height = 0.9;
Rgb board(int wall, double s, double y, uint32_t key) {
  const int32_t number = int32_t(std::floor(s / board_length)) + 16 * wall;
  const double x = s - std::floor(s / board_length) * board_length - board_length / 2,
               up = y - board_height / 2;
  const Print ink = print_of(number, key);
  double figure = 0;
  switch (int32_t(cell_value(number, 0, 7, key) * 5)) {
  case 0:
    figure = within(name_distance(x / 0.55, up / 0.55) * 0.55, 0.055);
    break;
  case 1: // rings
    for (const double centre : {-0.7, 0.0, 0.7})
      figure = std::max(figure, within(std::abs(std::hypot(x - centre, up) - 0.24), 0.05));
    break;
  case 2: { // slanting stripes
    const double across = (x + up * 0.6) / 0.3;
    figure = within(std::abs(across - std::floor(across) - 0.5) * 0.3, 0.075);
    break;
  }
  case 3: // two numbers
    for (const double centre : {-0.55, 0.55}) {
      const int value = int(cell_value(number, centre > 0, 8, key) * 100);
      figure = std::max(figure, within(number_distance(value, (x - centre) / 0.6, up / 0.6) * 0.6, 0.045));
    }
    break;
  default: { // chequers
    const double squares = std::floor(x / 0.15) + std::floor(up / 0.15);
    figure = squares - 2 * std::floor(squares / 2);
  }
  }
  const Rgb colour = mix(ink.ground, ink.figure, figure);
  const double rim = std::min(board_length / 2 - std::abs(x), board_height / 2 - std::abs(up));
  return mix(Rgb{0.02, 0.02, 0.02}, colour * 0.75, smoothstep(0.015, 0.035, rim));
}

// Heavy cloth in folds.
Rgb curtain(double s, double y, uint32_t key) {
  const double sway = 1.6 * noise({s * 0.9, y * 0.35, 0}, key) + 0.5 * noise({s * 4, y * 0.5, 0}, key + 1);
  const double fold = 0.5 + 0.5 * std::sin(s * 19 + 4 * sway);
  const double crease = 0.5 + 0.5 * std::sin(s * 47 + 7 * sway);
  const double weave = 0.85 + 0.3 * noise({s * 110, y * 110, 0}, key + 2);
  const Rgb cloth = Rgb{0.050, 0.075, 0.150} * (0.22 + 1.25 * fold * fold + 0.25 * crease);
  return cloth * (weave * (0.65 + 0.35 * y / 2.5));
}

// Upright slats of oak before dark felt.
Rgb slats(double s, double y, uint32_t key) {
  constexpr double pitch = 0.13;
  const int32_t number = int32_t(std::floor(s / pitch));
  const double across = s / pitch - number;
  const double grain = turbulence({s * 60, y * 2.5, double(number)}, key);
  const Rgb oak =
      mix(Rgb{0.24, 0.13, 0.06}, Rgb{0.34, 0.20, 0.10}, cell_value(number, 0, 0, key)) * (0.7 + 0.6 * grain);
  const double round = 0.75 + 0.5 * (0.72 - across);
  return across < 0.72 ? oak * round : Rgb{0.012, 0.012, 0.014};
}

Rgb bricks(double s, double y, uint32_t key) {
  constexpr double pitch = 0.25, course = 0.083, joint = 0.011;
  const int32_t row = int32_t(std::floor(y / course));
  const double shifted = s / pitch + 0.5 * (row & 1);
  const int32_t number = int32_t(std::floor(shifted));
  const double left = (shifted - number) * pitch, low = y - row * course;
  const double stain = turbulence({s * 0.8, y * 0.8, 0}, key + 1),
               rough = noise({s * 55, y * 55, 0}, key + 2);
  const Rgb clay = mix(Rgb{0.19, 0.10, 0.075}, Rgb{0.30, 0.17, 0.12}, cell_value(number, row, 0, key));
  const Rgb mortar{0.24, 0.23, 0.21};
  const Rgb colour = left < joint || low < joint ? mortar : clay * (0.8 + 0.4 * rough);
  return colour * (0.55 + 0.7 * stain);
}

// Cloths with numbers that hang before the bricks: 1.3 m wide, every 3 m.
constexpr double banner_top = 4.55, banner_bottom = 2.75;
Rgb bricks_with_banners(int wall, double s, double y, uint32_t key) {
  constexpr double pitch = 3.0, half_width = 0.65;
  const int32_t number = int32_t(std::floor(s / pitch)) + 16 * wall;
  const double x = s - std::floor(s / pitch) * pitch - pitch / 2;
  const double middle = (banner_top + banner_bottom) / 2, up = y - middle;
  // The lower end comes to a point.
  const double end = banner_bottom + 0.25 * std::abs(x) / half_width;
  const Rgb wall_behind = bricks(s, y, key) * (y < banner_top && std::abs(x) < half_width + 0.06 ? 0.6 : 1.0);
  if (std::abs(x) > half_width || y > banner_top || y < end) return wall_behind;
  const Print ink = print_of(number, key + 9);
  const int value = int(cell_value(number, 1, 8, key) * 100);
  const double rim = std::min(half_width - std::abs(x), std::min(banner_top - y, y - end));
  double figure = within(number_distance(value, x / 0.8, (up - 0.05) / 0.8) * 0.8, 0.06);
  figure = std::max(figure, within(std::abs(rim - 0.07), 0.02));
  const double wave = 0.85 + 0.25 * noise({x * 3.5, y * 0.6, double(number)}, key + 3);
  const double weave = 0.92 + 0.16 * noise({s * 90, y * 90, 0}, key + 4);
  return mix(ink.ground, ink.figure, figure) * (0.55 * wave * weave);
}

} // namespace

Rgb floor_colour(double x, double z, uint32_t key) {
  Rgb colour = wood(x, z, key);
  // Paint: a lane with its circle to one side, side lines, a half-way circle.
  const Rgb white{0.80, 0.79, 0.76}, lane{0.10, 0.17, 0.36};
  const double to_spot = std::sqrt((x - 1.6) * (x - 1.6) + z * z),
               to_middle = std::sqrt((x + 3.4) * (x + 3.4) + z * z);
  const bool in_lane = x > 1.6 && x < 6.8 && std::abs(z) < 1.8;
  if (in_lane) colour = mix(colour, lane * (0.8 + 0.4 * colour.x), 0.85);
  if (to_middle < 1.2) colour = mix(colour, Rgb{0.42, 0.07, 0.06} * (0.8 + 0.4 * colour.x), 0.85);
  double painted = std::max(line(to_spot - 1.8), std::max(line(to_middle - 1.8), line(to_middle - 1.2)));
  if (x > 1.57 && x < 6.8) painted = std::max(painted, line(std::abs(z) - 1.8));
  if (std::abs(z) < 1.83) painted = std::max(painted, line(x - 1.6));
  if (std::abs(z) < 3.62) painted = std::max(painted, std::max(line(x + 3.4), line(x - 6.8)));
  if (x < 6.83) painted = std::max(painted, line(std::abs(z) - 3.6));
  colour = mix(colour, white * (0.85 + 0.3 * colour.x), painted);
  // Scuffs, the lamps' light, and less of it near the walls.
  const double scuffs = 0.92 + 0.16 * turbulence({x * 1.1, z * 1.1, 0}, key + 2);
  const double lamp = 1.05 - 0.62 * smoothstep(0.5, 9.5, std::sqrt(x * x + 1.3 * z * z));
  const double to_wall = std::min(room_length / 2 - std::abs(x), room_width / 2 - std::abs(z));
  return colour * (scuffs * lamp * (0.35 + 0.65 * smoothstep(0.0, 0.9, to_wall)));
}

Rgb wall_colour(int wall, double s, double y, uint32_t key) {
  constexpr double top = 2.55, rail = 0.07;
  const uint32_t own = key + 100 * uint32_t(wall + 1);
  // Pools of light, and darkness towards the ceiling.
  const double pool = s / 3.0 - std::floor(s / 3.0) - 0.5;
  const double light = (0.80 + 0.55 * (1 - smoothstep(0.0, 0.5, std::abs(pool)))) *
                       (1 - 0.85 * smoothstep(3.0, room_height, y));
  if (y < board_height) return board(wall, s, y, key);
  if (y < top) {
    const double shadow = 0.6 + 0.4 * smoothstep(0.0, 0.3, y - board_height);
    return (wall < 2 ? slats(s, y, own) : curtain(s, y, own)) * (light * shadow);
  }
  if (y < top + rail) return Rgb{0.22, 0.22, 0.23} * (light * (1.3 - 14 * std::abs(y - top - 0.03)));
  return bricks_with_banners(wall, s, y, own) * light;
}

} // namespace fvv::synth
