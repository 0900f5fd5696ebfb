// Solid textures by region of the rest figure. Lengths in metres; a pixel of the usual pictures covers 14 mm,
// so what is finer serves larger pictures.
#include "fvvsynth/look.h"

#include <algorithm>
#include <cmath>

namespace fvv::synth {

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
  return dye * (0.62 + 0.50 * folds + 0.16 * weave);
}

double ellipse(double x, double y, double rx, double ry) {
  return (std::sqrt(x * x / (rx * rx) + y * y / (ry * ry)) - 1) * std::min(rx, ry);
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
  if (p.z > 0.02) paint_face(look, p, colour);
  // As in the figure (body.cpp): hair lies behind a plane that rises towards the face.
  const double behind = -0.62 * (p.y - 1.815) + 0.78 * (p.z - 0.072);
  const bool ear =
      look.style == Hair::short_cut && std::abs(p.x) > 0.081 && p.y < 1.785 && std::abs(p.z + 0.008) < 0.034;
  const double edge = 0.006 * noise(p * 90, look.key + 9);
  if (behind < edge && p.y > 1.695 + edge && !ear) {
    const double strands = look.style == Hair::afro ? noise(p * 75, look.key + 13)
                                                    : noise({p.x * 150, p.y * 40, p.z * 40}, look.key + 13);
    colour = look.hair * (0.5 + 1.3 * strands);
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
  if (s > 0.66) { // lines between the fingers
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
