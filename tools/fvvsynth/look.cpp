// Teams, the choice of looks, the ball, and the whole player from his regions.
#include "fvvsynth/look.h"

#include "fvvsynth/look_regions.h"

#include <algorithm>
#include <cmath>

namespace fvv::synth {

namespace {

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
