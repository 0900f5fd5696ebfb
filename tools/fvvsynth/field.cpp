// The parts list of a player and the arithmetic of implicit surfaces.
#include "fvvsynth/field.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fvv::synth {

namespace {

constexpr double blend[layer_count] = {0.030, 0.015, 0.030, 0.045,
                                       0.025}; // metres over which parts flow together
constexpr double layer_blend = 0.006;          // cloth lies on skin with a visible edge
constexpr double far_away = 1e3;

double part_distance(const Part &part, Vec3 p) {
  Vec3 from = p - part.a;
  const Vec3 span = part.b - part.a;
  if (part.squash != 1) from += part.squash_axis * (dot(part.squash_axis, from) * (1 / part.squash - 1));
  const double size = dot(span, span);
  const double t = size > 0 ? std::clamp(dot(from, span) / size, 0.0, 1.0) : 0;
  double d = length(from - span * t) - (part.radius_a + (part.radius_b - part.radius_a) * t);
  d *= 0.5 * (1 + part.squash); // keeps the slope near 1 on average over the thin and the wide side
  return std::max(d, dot(part.cut_normal, p) - part.cut_offset);
}

// Polynomial smooth minimum: min, lowered by at most k / 4 where the two are within k.
double smooth_minimum(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k * 0.25;
}

void add_head(std::vector<Part> &parts, Hair style) {
  parts.push_back({head, skin, {0, 1.765, -0.015}, {0, 1.775, 0.010}, 0.098, 0.094, {1, 0, 0}, 0.80});
  parts.push_back({head, skin, {0, 1.700, 0.034}, {0, 1.674, 0.060}, 0.064, 0.041, {1, 0, 0}, 0.95});
  parts.push_back({head, skin, {0, 1.765, 0.094}, {0, 1.730, 0.105}, 0.009, 0.016});
  for (const int side : {1, -1})
    parts.push_back({head,
                     skin,
                     {side * 0.083, 1.765, -0.012},
                     {side * 0.080, 1.73, -0.006},
                     0.026,
                     0.018,
                     {1, 0, 0},
                     0.45});
  parts.push_back({head, skin, {0, 1.54, -0.020}, {0, 1.69, -0.004}, 0.068, 0.060});
  // Hair ends at the hairline: a plane that rises towards the face.
  const Vec3 line = normalised(Vec3{0, -0.62, 0.78});
  const double offset = dot(line, {0, 1.815, 0.072});
  if (style == Hair::afro)
    parts.push_back(
        {head, hair, {0, 1.80, -0.028}, {0, 1.82, -0.01}, 0.122, 0.118, {1, 0, 0}, 0.92, line, offset});
  else
    parts.push_back(
        {head, hair, {0, 1.775, -0.022}, {0, 1.785, 0.004}, 0.105, 0.101, {1, 0, 0}, 0.80, line, offset});
}

void add_torso(std::vector<Part> &parts) {
  const Vec3 front{0, 0, 1};
  // Skin at the top, where the jersey leaves it free.
  parts.push_back({chest, skin, {-0.15, 1.465, -0.015}, {0.15, 1.465, -0.015}, 0.060, 0.060});
  for (const int side : {1, -1}) {
    parts.push_back({chest, skin, {side * 0.02, 1.565, -0.02}, {side * 0.16, 1.485, -0.02}, 0.048, 0.046});
    parts.push_back(
        {chest, jersey, {side * 0.075, 1.38, 0.030}, {side * 0.085, 1.37, 0.030}, 0.095, 0.090, front, 0.85});
  }
  parts.push_back({chest, jersey, {0, 1.30, -0.012}, {0, 1.405, -0.015}, 0.178, 0.172, front, 0.64});
  parts.push_back({spine, jersey, {0, 1.14, -0.005}, {0, 1.28, -0.010}, 0.158, 0.174, front, 0.70});
  // The loose end of the jersey over the shorts.
  parts.push_back(
      {pelvis, jersey, {0, 0.94, 0}, {0, 1.12, -0.003}, 0.188, 0.162, front, 0.76, {0, -1, 0}, -0.925});
  parts.push_back({pelvis, shorts, {-0.07, 0.965, 0}, {0.07, 0.965, 0}, 0.108, 0.108, front, 1.05});
  parts.push_back({pelvis, shorts, {-0.06, 0.95, -0.045}, {0.06, 0.95, -0.045}, 0.090, 0.090});
}

void add_arm(std::vector<Part> &parts, int side) {
  const auto &joint = rest_joints();
  const size_t upper = side > 0 ? left_upper_arm : right_upper_arm;
  const Joint bone[3] = {Joint(upper), Joint(upper + 1), Joint(upper + 2)};
  const Vec3 shoulder = joint[upper], elbow = joint[upper + 1], wrist = joint[upper + 2],
             along = rest_arm(side);
  const Vec3 front{0, 0, 1}, palm = rest_palm(side);
  parts.push_back({bone[0], skin, shoulder + along * 0.02, elbow, 0.060, 0.041});
  parts.push_back({bone[0], skin, shoulder + along * 0.12 + front * 0.010,
                   elbow - along * 0.08 + front * 0.008, 0.050, 0.044});
  parts.push_back({bone[1], skin, elbow, wrist, 0.041, 0.029});
  parts.push_back({bone[1], skin, elbow + along * 0.05, elbow + along * 0.13, 0.045, 0.040});
  parts.push_back({bone[2], skin, wrist + along * 0.035, wrist + along * 0.085, 0.036, 0.043, palm, 0.60});
  parts.push_back({bone[2], skin, wrist + along * 0.09 + palm * 0.004, wrist + along * 0.165 + palm * 0.016,
                   0.043, 0.036, palm, 0.60});
  parts.push_back({bone[2], skin, wrist + along * 0.035 + front * 0.022,
                   wrist + along * 0.085 + front * 0.060 + palm * 0.012, 0.021, 0.020});
}

void add_leg(std::vector<Part> &parts, int side) {
  const auto &joint = rest_joints();
  const size_t thigh = side > 0 ? left_thigh : right_thigh;
  const Joint bone[3] = {Joint(thigh), Joint(thigh + 1), Joint(thigh + 2)};
  const Vec3 hip = joint[thigh], knee = joint[thigh + 1], ankle = joint[thigh + 2], along = rest_leg(side);
  const Vec3 front{0, 0, 1};
  parts.push_back({bone[0],
                   shorts,
                   hip + along * 0.02,
                   hip + along * 0.40,
                   0.112,
                   0.118,
                   {1, 0, 0},
                   1,
                   along,
                   dot(along, hip) + 0.385});
  parts.push_back({bone[0], skin, hip + along * 0.10, knee, 0.092, 0.060});
  parts.push_back({bone[1], skin, knee, ankle, 0.057, 0.038});
  parts.push_back({bone[1], skin, knee + along * 0.08 - front * 0.018, knee + along * 0.20 - front * 0.014,
                   0.056, 0.046});
  const Vec3 ground{ankle.x, 0, ankle.z};
  parts.push_back(
      {bone[2], shoes, ankle + Vec3{0, 0.025, -0.008}, ankle + Vec3{0, -0.02, -0.01}, 0.047, 0.052});
  parts.push_back({bone[2], shoes, ground + Vec3{0, 0.038, -0.045}, ground + Vec3{side * 0.008, 0.030, 0.115},
                   0.046, 0.050});
  parts.push_back({bone[2], shoes, ground + Vec3{0, 0.055, 0.02}, ground + Vec3{side * 0.005, 0.028, 0.150},
                   0.044, 0.042});
}

} // namespace

Figure::Figure(Hair style) {
  add_head(parts, style);
  add_torso(parts);
  for (const int side : {1, -1}) {
    add_arm(parts, side);
    add_leg(parts, side);
  }
}

double Figure::distance(Vec3 p) const {
  std::array<double, layer_count> nearest;
  nearest.fill(far_away);
  for (const Part &part : parts) {
    double &d = nearest[part.layer];
    d = smooth_minimum(d, part_distance(part, p), blend[part.layer]);
  }
  double d = far_away;
  for (const double layer : nearest) d = smooth_minimum(d, layer, layer_blend);
  return std::max(d, -p.y); // soles are flat
}

Vec3 Figure::outwards(Vec3 p) const {
  constexpr double h = 1e-3;
  return normalised(Vec3{distance({p.x + h, p.y, p.z}) - distance({p.x - h, p.y, p.z}),
                         distance({p.x, p.y + h, p.z}) - distance({p.x, p.y - h, p.z}),
                         distance({p.x, p.y, p.z + h}) - distance({p.x, p.y, p.z - h})});
}

Joint Figure::bone(Vec3 p) const {
  const auto nearer = [&](const Part &a, const Part &b) { return part_distance(a, p) < part_distance(b, p); };
  return std::min_element(parts.begin(), parts.end(), nearer)->bone;
}

} // namespace fvv::synth
