#include "fvvsynth/look.h"

#include "fvv_cxx/parallel.h"
#include "fvvsynth/game/player.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>

namespace fvv::synth {

namespace {

// Display values as linear light.
const std::array<float, 256> linear = [] {
  std::array<float, 256> table{};
  for (size_t i = 0; i < 256; i++) table[i] = float(double(i * i) / (255.0 * 255.0));
  return table;
}();

double power_of_two(int exponent) {
  const uint64_t bits = uint64_t(1023 + exponent) << 52;
  double out;
  std::memcpy(&out, &bits, sizeof out);
  return out;
}

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
  const uint32_t left = uint32_t(x), top = uint32_t(y);
  const float u = float(x - left), v = float(y - top);
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
  // The binary logarithm with its fraction taken as linear: smooth enough between levels. Numbers are taken
  // apart here, because std::frexp and std::ldexp took a tenth of the time.
  const double texels = std::max(1.0, footprint / spacing);
  uint64_t bits;
  std::memcpy(&bits, &texels, sizeof bits);
  const int exponent = int(bits >> 52) - 1023;
  const double scale = std::min(double(levels.size() - 1), exponent + (texels / power_of_two(exponent) - 1));
  const int fine = int(scale);
  const double column = s / spacing, row = t / spacing;
  const auto on = [&](int level) {
    const double smaller = power_of_two(-level);
    return bilinear(levels[size_t(level)], column * smaller - 0.5, row * smaller - 0.5);
  };
  const double between = scale - fine;
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

Rgb ceiling_colour(double x, double z, uint32_t key) {
  // Acoustic panels between rails, brighter near the lamps.
  constexpr double panel = 0.75;
  const double s = x / panel, t = z / panel;
  const int32_t column = int32_t(std::floor(s)), row = int32_t(std::floor(t));
  const double rim = std::min(std::min(s - column, column + 1 - s), std::min(t - row, row + 1 - t)) * panel;
  const double tone = 0.85 + 0.3 * cell_value(column, row, 0, key + 41);
  const double dots = 0.9 + 0.2 * noise({x * 40, z * 40, 0}, key + 42);
  const double lit = 0.55 + 0.9 * std::exp(-0.03 * (x * x + z * z));
  return mix(Rgb{0.30, 0.30, 0.30}, Rgb{0.15, 0.15, 0.155} * (tone * dots), smoothstep(0.012, 0.024, rim)) *
         lit;
}

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

namespace {

constexpr double jersey_end = 0.927; // height of its lower edge

using render::Reflectance;

// Share of paint at signed distance d inside (d < 0) or outside an outline.
double paint(double d, double softness = 0.0015) {
  return 1 - smoothstep(-softness, softness, d);
}

Rgb bare_skin(const Look &look, Vec3 p) {
  const double tone = turbulence(p * 11, look.key), pores = noise(p * 120, look.key + 3);
  const Rgb flushed = product(look.skin, {1.10, 0.90, 0.86});
  return mix(look.skin, flushed, tone) * (0.80 + 0.30 * tone + 0.10 * pores);
}

// Cloth with soft folds and the weave of the mesh that sportswear is made of.
Rgb fabric(const Look &look, Rgb dye, Vec3 p) {
  const double folds = turbulence({p.x * 9, p.y * 4.5, p.z * 9}, look.key + 11);
  const double weave = noise(p * 210, look.key + 17);
  // Valleys between the folds of the figure see less of the surroundings' light.
  const double depth = look.fine ? 1.20 - 0.62 * cloth_fold(p, look.key) : 1;
  return dye * (0.62 + 0.50 * folds + 0.16 * weave) * depth;
}

double ellipse(double x, double y, double rx, double ry) {
  return (std::sqrt(x * x / (rx * rx) + y * y / (ry * ry)) - 1) * std::min(rx, ry);
}

// The same for a face that has sockets and lips of its own: what is painted only adds colour to them.
void paint_fine_face(const Look &look, Vec3 p, Rgb &colour) {
  const double x = std::abs(p.x), y = p.y;
  const double cheeks =
      std::exp(-0.5 * ((x - 0.045) * (x - 0.045) + (y - 1.722) * (y - 1.722)) / (0.018 * 0.018));
  colour = mix(colour, product(colour, {1.12, 0.86, 0.82}), 0.5 * cheeks);
  const double beard =
      smoothstep(1.728, 1.695, y) * smoothstep(0.00, 0.05, p.z) * (look.key & 1 ? 0.45 : 0.10);
  colour =
      mix(colour, product(colour, Rgb{0.50, 0.46, 0.45}), beard * (0.6 + 0.4 * noise(p * 160, look.key + 5)));
  const Rgb dark{0.012, 0.010, 0.010};
  colour = mix(colour, colour * 0.62, paint(ellipse(x - 0.033, y - 1.757, 0.024, 0.013), 0.009));
  colour = mix(colour, {0.46, 0.44, 0.42}, paint(ellipse(x - 0.033, y - 1.753, 0.0145, 0.0058)));
  colour = mix(colour, {0.035, 0.020, 0.012}, paint(ellipse(x - 0.032, y - 1.7535, 0.0062, 0.0062)));
  colour = mix(colour, colour * 0.22, paint(ellipse(x - 0.033, y - 1.7595, 0.017, 0.0022))); // lashes
  colour =
      mix(colour, look.hair * 0.8,
          0.85 * paint(ellipse(x - 0.036, y - 1.777 + 5 * (x - 0.034) * (x - 0.034), 0.022, 0.0045), 0.003));
  const Rgb lips = product(look.skin, {0.80, 0.50, 0.46});
  colour = mix(colour, lips, 0.7 * paint(ellipse(p.x, y - 1.689, 0.024, 0.010), 0.003));
  colour = mix(colour, dark, 0.8 * paint(ellipse(p.x, y - 1.6895 + 3 * x * x, 0.023, 0.0015)));
  colour = mix(colour, dark, 0.7 * paint(ellipse(x - 0.009, y - 1.717, 0.0055, 0.0035), 0.002));
}

void paint_face(const Look &look, Vec3 p, Rgb &colour) {
  const double x = std::abs(p.x);
  const double beard =
      smoothstep(1.735, 1.70, p.y) * smoothstep(0.00, 0.04, p.z) * (look.key & 1 ? 0.55 : 0.12);
  colour =
      mix(colour, product(colour, Rgb{0.45, 0.42, 0.42}), beard * (0.5 + 0.5 * noise(p * 160, look.key + 5)));
  const Rgb lips = product(look.skin, {0.80, 0.45, 0.42}), dark{0.012, 0.010, 0.010};
  colour = mix(colour, colour * 0.55, paint(ellipse(x - 0.034, p.y - 1.752, 0.026, 0.018), 0.008));
  colour = mix(colour, {0.80, 0.79, 0.76}, paint(ellipse(x - 0.034, p.y - 1.753, 0.018, 0.0095)));
  colour = mix(colour, dark, paint(ellipse(x - 0.034, p.y - 1.753, 0.0085, 0.0085)));
  colour = mix(colour, look.hair,
               paint(ellipse(x - 0.036, p.y - 1.779 + 4 * (x - 0.036) * (x - 0.036), 0.025, 0.0065)));
  colour = mix(colour, lips, paint(ellipse(p.x, p.y - 1.690, 0.030, 0.011)));
  colour = mix(colour, dark, paint(ellipse(p.x, p.y - 1.690, 0.024, 0.0022)));
  colour = mix(colour, colour * 0.5, paint(ellipse(x - 0.010, p.y - 1.715, 0.007, 0.005), 0.003));
}

// A row of blocks that reads as letters from where the cameras stand; 1 where there is paint.
double lettering(double x, double y, int letters, double height, uint32_t key) {
  const double advance = height * 0.85, column = x / advance + 0.5 * letters;
  const int letter = int(std::floor(column));
  if (letter < 0 || letter >= letters || std::abs(y) > 0.5 * height) return 0;
  const int i = int(std::floor((column - letter) * 4)), j = int(std::floor((y / height + 0.5) * 5));
  if (i == 3) return 0;
  return i == 0 || cell_value(letter, i, j, key) > 0.5 ? 1 : 0;
}

// |x| beyond which an arm is bare.
double armhole(double y) {
  return 0.135 + 0.085 * (1 - smoothstep(1.33, 1.46, y));
}

// Height above which the jersey ends at the neck.
double neckline(Vec3 p) {
  const double x = p.x / 0.088, front = smoothstep(-0.05, 0.03, p.z);
  return std::abs(x) > 1 ? 1e9 : 1.525 - 0.075 * front + (0.06 + 0.05 * front) * x * x;
}

Reflectance head_reflectance(const Look &look, Vec3 p) {
  Rgb colour = bare_skin(look, p);
  if (p.y < 1.62) return {colour, 0.05};
  if (p.z > 0.02) look.fine ? paint_fine_face(look, p, colour) : paint_face(look, p, colour);
  // As in the figure (body.cpp): hair lies behind a plane that rises towards the face.
  const double behind = -0.62 * (p.y - 1.815) + 0.78 * (p.z - 0.072);
  const bool ear =
      look.style == Hair::short_cut && std::abs(p.x) > 0.081 && p.y < 1.785 && std::abs(p.z + 0.008) < 0.034;
  const double edge = 0.006 * noise(p * 90, look.key + 9);
  if (behind < edge && p.y > 1.695 + edge && !ear) {
    const double strands = look.style == Hair::afro ? noise(p * 75, look.key + 13)
                                                    : noise({p.x * 150, p.y * 40, p.z * 40}, look.key + 13);
    colour = look.hair * (0.5 + 1.3 * strands);
    if (look.fine) {
      // Skin shines through near the hairline, and locks differ in tone and gloss.
      const double rim = smoothstep(-0.010, 0.002, behind - edge) * noise(p * 130, look.key + 15);
      const double locks = noise(p * 28, look.key + 16);
      const Rgb scalp = bare_skin(look, p) * 0.6;
      const double band_at = p.y - 1.812 + 0.12 * p.z;
      if (!look.headband || std::abs(band_at) >= 0.019)
        return {mix(colour * (0.6 + 0.8 * locks), scalp, 0.7 * rim), 0.03 + 0.12 * strands * locks};
    }
  }
  const double band = p.y - 1.812 + 0.12 * p.z;
  if (look.headband && std::abs(band) < 0.019) colour = fabric(look, look.trim, p);
  return {colour, 0.05};
}

Reflectance jersey_reflectance(const Look &look, Vec3 p) {
  Rgb dye = look.cloth;
  const double side = std::abs(p.z) - 0.045 + 0.20 * std::max(0.0, p.y - 1.15);
  if (std::abs(p.x) > 0.10 && p.y < 1.36) {
    dye = mix(dye, look.trim, paint(side));
    dye = mix(dye, look.cloth * 0.35, paint(std::abs(side) - 0.006));
  }
  const double to_neck = (neckline(p) - p.y) * 0.7, to_arm = armhole(p.y) - std::abs(p.x);
  const double border = p.y > 1.30 ? std::min(to_neck, to_arm) : 1;
  dye = mix(dye, look.trim, paint(border - 0.018));
  const bool front = p.z > 0;
  const double u = front ? p.x : -p.x, height = front ? 0.17 : 0.20;
  if (std::abs(p.z) > 0.03 && p.y > 0.99) {
    const double d = number_distance(look.number, u / height, (p.y - 1.225) / height) * height;
    dye = mix(dye, look.cloth * 0.25, paint(d - 0.026));
    dye = mix(dye, look.trim, paint(d - 0.018));
    const double letters =
        lettering(u, p.y - 1.385, front ? 5 : 6, front ? 0.040 : 0.034, look.key + (front ? 21 : 22));
    dye = mix(dye, look.trim, letters);
  }
  dye = mix(dye, look.trim, paint(std::abs(p.y - 0.955) - 0.008));
  return {fabric(look, dye, p), 0.015};
}

Reflectance arm_reflectance(const Look &look, Vec3 p) {
  const int side = p.x > 0 ? 1 : -1;
  const Vec3 along = rest_arm(side), from = p - rest_joints()[side > 0 ? left_upper_arm : right_upper_arm];
  const double s = dot(from, along);
  Rgb colour = bare_skin(look, p);
  colour = mix(colour, colour * 0.72,
               0.6 * std::max(0.0, 1 - std::abs(s - 0.30) * 20) * smoothstep(0, -0.03, p.z));
  if (s > 0.66 && !look.fine) { // lines between the fingers
    const double finger = (from.z + 0.045) / 0.0225;
    const double line = std::abs(finger - std::floor(finger + 0.5)) * 0.0225;
    colour = mix(colour, colour * 0.45, paint(line - 0.0025, 0.002) * smoothstep(0.66, 0.69, s));
  }
  const bool sleeve = (look.key & 4) != 0 && side > 0;
  if (sleeve && s > 0.15 && s < 0.52)
    return {fabric(look, s < 0.17 || s > 0.50 ? look.trim : look.cloth * 0.5, p), 0.02};
  if (!sleeve && side < 0 && s > 0.49 && s < 0.545) return {fabric(look, look.trim, p), 0};
  return {colour, 0.06};
}

// Shorts, leg, sock and shoe.
Reflectance leg_reflectance(const Look &look, Vec3 p) {
  const int side = p.x > 0 ? 1 : -1;
  const Vec3 along = rest_leg(side), from = p - rest_joints()[side > 0 ? left_thigh : right_thigh];
  const double s = dot(from, along);
  if (s < 0.381) {
    Rgb dye = look.cloth;
    const double stripe = std::abs(p.z + 0.004) - 0.028;
    if (side * (from.x - along.x * s) > 0.05) {
      dye = mix(dye, look.trim, paint(stripe));
      dye = mix(dye, look.cloth * 0.35, paint(std::abs(stripe) - 0.006));
    }
    dye = mix(dye, look.trim, paint(std::abs(s - 0.355) - 0.011));
    return {fabric(look, dye, p), 0.015};
  }
  if (p.y < 0.148 - 0.25 * std::max(0.0, p.z - 0.05)) {
    if (p.y < 0.024) return {Rgb{0.72, 0.70, 0.66} * (0.85 + 0.2 * noise(p * 70, look.key + 31)), 0.02};
    Rgb leather = look.shoe * (0.80 + 0.25 * turbulence(p * 18, look.key + 33));
    const double swoosh = std::abs(p.y - 0.045 - 0.30 * (p.z - 0.02)) - 0.010;
    if (std::abs(from.x - rest_leg(side).x * 0.89) > 0.028) leather = mix(leather, look.cloth, paint(swoosh));
    const double lace = std::abs(std::fmod(p.z + 1, 0.022) - 0.011) - 0.004;
    if (p.z > 0.03 && p.y > 0.06) leather = mix(leather, look.trim, paint(lace));
    return {leather, 0.12};
  }
  if (s > 0.70) {
    const bool striped = std::abs(s - 0.725) < 0.008 || std::abs(s - 0.75) < 0.008;
    return {fabric(look, striped ? look.cloth : Rgb{0.80, 0.80, 0.79}, p), 0};
  }
  Rgb colour = bare_skin(look, p);
  colour = mix(colour, colour * 0.70,
               0.5 * std::max(0.0, 1 - std::abs(s - 0.455) * 16) * smoothstep(0, 0.04, p.z));
  if ((look.key & 2) != 0 && side < 0 && s > 0.40 && s < 0.52)
    return {fabric(look, {0.03, 0.03, 0.035}, p), 0.02}; // knee pad
  return {colour, 0.06};
}

struct Team {
  Rgb cloth, trim, shoe; // display values
};
constexpr Team teams[] = {{{0.80, 0.13, 0.14}, {0.95, 0.94, 0.90}, {0.90, 0.90, 0.90}},
                          {{0.13, 0.26, 0.66}, {0.98, 0.80, 0.20}, {0.92, 0.92, 0.95}},
                          {{0.94, 0.93, 0.90}, {0.10, 0.42, 0.28}, {0.12, 0.12, 0.14}},
                          {{0.12, 0.45, 0.30}, {0.96, 0.95, 0.92}, {0.95, 0.85, 0.25}},
                          {{0.95, 0.72, 0.15}, {0.30, 0.14, 0.48}, {0.90, 0.90, 0.92}},
                          {{0.14, 0.14, 0.17}, {0.92, 0.35, 0.12}, {0.85, 0.25, 0.15}}};
constexpr Rgb skins[] = {{0.86, 0.66, 0.53}, {0.76, 0.55, 0.41}, {0.62, 0.42, 0.30}, {0.48, 0.32, 0.23}};
constexpr Rgb hairs[] = {{0.12, 0.09, 0.08}, {0.22, 0.14, 0.09}, {0.38, 0.25, 0.14}};

template <size_t n> uint32_t pick(Random &random, const Rgb (&)[n]) {
  return random.below(uint32_t(n));
}

} // namespace

std::array<Look, 2> make_looks(Random &random) {
  constexpr uint32_t team_count = sizeof teams / sizeof teams[0];
  const uint32_t first_team = random.below(team_count);
  const uint32_t team[2] = {first_team, (first_team + 1 + random.below(team_count - 1)) % team_count};
  const uint32_t first_skin = pick(random, skins);
  const uint32_t tone[2] = {first_skin, (first_skin + 1 + random.below(3)) % 4};
  std::array<Look, 2> looks;
  for (size_t i = 0; i < 2; i++) {
    Look &look = looks[i];
    const Team &t = teams[team[i]];
    look.skin = render::to_linear(skins[tone[i]]);
    look.hair = render::to_linear(hairs[pick(random, hairs)]);
    look.cloth = render::to_linear(t.cloth);
    look.trim = render::to_linear(t.trim);
    look.shoe = render::to_linear(t.shoe);
    look.style = i == 0 ? Hair::short_cut : Hair::afro;
    look.headband = random.below(2) == 0;
    look.number = int(random.below(100));
    look.key = uint32_t(random.next());
  }
  if (looks[1].number == looks[0].number) looks[1].number = (looks[0].number + 17) % 100;
  return looks;
}

render::Reflectance player_reflectance(const Look &look, Vec3 p) {
  if (p.y > 1.62) return head_reflectance(look, p);
  if (p.y > 1.00 && std::abs(p.x) > armhole(p.y)) return arm_reflectance(look, p);
  if (p.y > neckline(p)) return head_reflectance(look, p);
  if (p.y > jersey_end) return jersey_reflectance(look, p);
  return leg_reflectance(look, p);
}

render::Reflectance ball_reflectance(Vec3 p, uint32_t key) {
  // Two great circles, and a pair of curves around the ends of the x axis.
  const double curve = p.x * p.x - 0.62 * p.y * p.y - 0.30;
  const double slope = 2 * std::sqrt(p.x * p.x + 0.62 * 0.62 * p.y * p.y) + 1e-9;
  const double seam = std::min(std::min(std::abs(p.y), std::abs(p.z)), std::abs(curve) / slope);
  const double pebbles = noise(p * 42, key), stain = turbulence(p * 3, key + 7);
  const Rgb leather = render::to_linear(Rgb{0.85, 0.43, 0.14}) * (0.70 + 0.25 * pebbles + 0.30 * stain);
  const Rgb rubber{0.012, 0.010, 0.010};
  return {mix(rubber, leather, smoothstep(0.030, 0.055, seam)), 0.10};
}

double number_distance(int number, double x, double y) {
  // Each digit is one line through points of a grid, written as column 0..2 and row 0..4.
  static constexpr const char *lines[10] = {
      "0004242000",   "0314100020",   "042422020020", "04242202222000", "0402222420",
      "240402222000", "240400202202", "042410",       "00042420000222", "002024040222"};
  double nearest = 1e9;
  for (int place = number < 10 ? 1 : 0; place < 2; place++) {
    const double middle = number < 10 ? 0 : place == 0 ? -0.40 : 0.40;
    const auto point = [&](const char *at) {
      return Vec3{middle + (at[0] - '1') * 0.25, (at[1] - '2') * 0.25, 0};
    };
    for (const char *at = lines[place == 0 ? number / 10 : number % 10]; at[2] != 0; at += 2) {
      const Vec3 span = point(at + 2) - point(at), from = Vec3{x, y, 0} - point(at);
      const double t = std::clamp(dot(from, span) / dot(span, span), 0.0, 1.0);
      nearest = std::min(nearest, length(from - span * t));
    }
  }
  return nearest;
}

} // namespace fvv::synth
