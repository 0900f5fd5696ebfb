#include "fvvsynth/game/player.h"

#include "fvvsynth/random.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace fvv::synth {

namespace {

constexpr Vec3 front{0, 0, 1};

bool in_hand(const Part &part) {
  return part.bone == left_hand || part.bone == right_hand;
}

// A bump that is 1 at the middle and fades over the radii.
double bump(double x, double y, double rx, double ry) {
  return std::exp(-0.5 * (x * x / (rx * rx) + y * y / (ry * ry)));
}

// Metres that folds take off cloth: most at the waist, at hems and below the arms.
double cloth_depth(Layer layer, Vec3 p, uint32_t key) {
  const double fold = cloth_fold(p, key);
  if (layer == shorts) return fold * (0.007 + 0.014 * smoothstep(0.85, 0.60, p.y));
  const double waist = bump(p.y - 1.03, 0, 0.07, 1), arm = bump(p.y - 1.32, std::abs(p.x) - 0.17, 0.06, 0.05);
  return fold * (0.005 + 0.016 * waist + 0.012 * arm);
}

std::vector<Part> trunk_parts(Hair hair) {
  std::vector<Part> parts;
  for (Part part : make_parts(hair)) {
    if (part.bone == head || in_hand(part)) continue;
    if (part.layer == shorts && (part.bone == left_thigh || part.bone == right_thigh)) {
      part.radius_a = 0.116; // wide legs
      part.radius_b = 0.136;
    }
    if (part.layer == jersey && part.bone == pelvis) part.radius_a = 0.198;
    parts.push_back(part);
  }
  parts.push_back({chest, skin, {0, 1.54, -0.020}, {0, 1.58, -0.014}, 0.064, 0.050}); // below the head's neck
  for (const int side : {1, -1}) {
    const Joint foot = side > 0 ? left_foot : right_foot;
    const Vec3 ankle = rest_joints()[foot];
    parts.push_back({foot,
                     shoes,
                     {ankle.x, 0.016, ankle.z - 0.048},
                     {ankle.x + side * 0.008, 0.016, ankle.z + 0.142},
                     0.050,
                     0.056,
                     {0, 1, 0},
                     0.40}); // the sole
  }
  return parts;
}

std::vector<Part> head_parts(Hair hair_style) {
  std::vector<Part> parts;
  for (const Part &part : make_parts(hair_style))
    if (part.bone == head && part.layer == skin) parts.push_back(part);
  for (const double side : {1.0, -1.0}) {
    parts.push_back(
        {head, skin, {side * 0.012, 1.784, 0.082}, {side * 0.048, 1.782, 0.064}, 0.013, 0.012}); // brow
    parts.push_back(
        {head, skin, {side * 0.046, 1.728, 0.056}, {side * 0.056, 1.735, 0.030}, 0.022, 0.020}); // cheek
    parts.push_back(
        {head, skin, {side * 0.054, 1.700, 0.005}, {side * 0.024, 1.656, 0.062}, 0.022, 0.020}); // jaw
    parts.push_back(
        {head, skin, {side * 0.011, 1.724, 0.102}, {side * 0.013, 1.723, 0.096}, 0.009, 0.009}); // nostril
  }
  parts.push_back({head, skin, {0, 1.648, 0.066}, {0, 1.652, 0.074}, 0.020, 0.016}); // chin
  const Vec3 line = normalised(Vec3{0, -0.62, 0.78});
  const double offset = dot(line, Vec3{0, 1.815, 0.072});
  const bool curls = hair_style == Hair::afro;
  parts.push_back(
      {head, hair, {0, 1.775, -0.022}, {0, 1.785, 0.004}, 0.105, 0.101, {1, 0, 0}, 0.80, line, offset});
  if (curls)
    parts.push_back(
        {head, hair, {0, 1.835, -0.045}, {0, 1.845, 0.000}, 0.088, 0.084, {1, 0, 0}, 0.95, line, offset});
  return parts;
}

double head_depth(Layer layer, Vec3 p, Hair style, uint32_t key) {
  if (layer == hair) {
    // Curls, or strands that part: up to twice as much is taken off the rim.
    const double deep = style == Hair::afro ? 0.016 : 0.006;
    const double n =
        style == Hair::afro ? noise(p * 55, key + 51) : noise({p.x * 90, p.y * 40, p.z * 40}, key + 52);
    return deep * (n - 0.25) + 0.006 * (noise(p * 24, key + 53) - 0.5);
  }
  if (layer != skin || p.z < 0.02) return 0;
  const double x = std::abs(p.x), y = p.y;
  double depth = 0.007 * bump(x - 0.034, y - 1.754, 0.015, 0.010); // sockets
  depth -= 0.0035 * bump(x - 0.034, y - 1.753, 0.009, 0.006);      // eyes
  depth += 0.004 * bump(x - 0.017, y - 1.758, 0.006, 0.012);       // beside the nose
  depth -= 0.0045 * bump(p.x, y - 1.697, 0.020, 0.0045);           // upper lip
  depth -= 0.0050 * bump(p.x, y - 1.682, 0.017, 0.0050);           // lower lip
  depth += 0.0030 * bump(p.x, y - 1.669, 0.018, 0.006);            // above the chin
  return depth;
}

std::vector<Part> hand_parts(int side) {
  const Joint palm_bone = side > 0 ? left_hand : right_hand, finger = side > 0 ? left_fingers : right_fingers,
              tip = Joint(finger + 1), thumb = Joint(finger + 2);
  const Vec3 wrist = rest_joints()[palm_bone], along = rest_arm(side), palm = rest_palm(side);
  std::vector<Part> parts;
  parts.push_back({palm_bone, skin, wrist - along * 0.030, wrist + along * 0.012, 0.024, 0.026, palm, 0.85});
  constexpr double lengths[4] = {0.074, 0.083, 0.077, 0.060};
  for (int i = 0; i < 4; i++) {
    const double across = 0.0315 - 0.021 * i;
    const Vec3 knuckle = wrist + along * (0.092 - 0.006 * std::abs(i - 1.2)) + front * across - palm * 0.002;
    const Vec3 way = normalised(along + front * (across * 3.6));
    parts.push_back({palm_bone, skin, wrist + along * 0.020 + front * (across * 0.55), knuckle, 0.017, 0.0125,
                     palm, 0.92});
    const double size = lengths[i];
    const Vec3 middle = knuckle + way * (size * 0.52) + palm * 0.002,
               end = knuckle + way * size + palm * 0.007;
    parts.push_back({finger, skin, knuckle, middle, 0.0110, 0.0098});
    parts.push_back({tip, skin, middle, end, 0.0098, 0.0085});
  }
  // The ball of the thumb, and the thumb.
  const Vec3 root = wrist + along * 0.032 + front * 0.026 + palm * 0.006,
             joint = wrist + along * 0.066 + front * 0.053 + palm * 0.014;
  parts.push_back(
      {palm_bone, skin, wrist + along * 0.024 + front * 0.012 + palm * 0.006, root, 0.018, 0.016});
  parts.push_back({thumb, skin, root, joint, 0.0150, 0.0118});
  parts.push_back({thumb, skin, joint, wrist + along * 0.098 + front * 0.068 + palm * 0.022, 0.0118, 0.0092});
  return parts;
}

void append(Body &body, const Body &more) {
  const uint32_t first = uint32_t(body.rest.vertices.size());
  body.rest.vertices.insert(body.rest.vertices.end(), more.rest.vertices.begin(), more.rest.vertices.end());
  for (const uint32_t v : more.rest.faces) body.rest.faces.push_back(first + v);
  body.influences.insert(body.influences.end(), more.influences.begin(), more.influences.end());
  body.exposure.insert(body.exposure.end(), more.exposure.begin(), more.exposure.end());
}

} // namespace

double cloth_fold(Vec3 p, uint32_t key) {
  // Ridges of noise: long ones down the cloth, and slanting ones.
  const auto ridge = [&](Vec3 at, uint32_t field) { return std::abs(2 * noise(at, field) - 1); };
  const double down = ridge({p.x * 15, p.y * 4.5, p.z * 15}, key + 61);
  const double slanting = ridge({(p.x + p.y) * 8, (p.y - 0.5 * p.x) * 8, p.z * 11}, key + 62);
  return std::min(1.0, 0.6 * down + 0.6 * slanting);
}

Body make_player(Hair style, uint32_t key) {
  constexpr double trunk_cell = 0.0178, head_cell = 0.0086, hand_cell = 0.0064;
  const Figure trunk(trunk_parts(style), [key](Layer layer, Vec3 p) {
    return layer == shorts || layer == jersey ? cloth_depth(layer, p, key) : 0.0;
  });
  Body body = make_body(trunk, {{-0.80, -0.06, -0.30}, {0.80, 1.72, 0.32}, trunk_cell, 26});

  const Figure face(
      head_parts(style), [=](Layer layer, Vec3 p) { return head_depth(layer, p, style, key); }, 0.6);
  Body top = make_body(face, {{-0.17, 1.42, -0.21}, {0.17, 2.02, 0.18}, head_cell, 0});
  for (size_t i = 0; i < top.influences.size(); i++) {
    // The neck bends between chest and head.
    const double weight = smoothstep(1.50, 1.64, top.rest.vertices[i].y);
    top.influences[i] = {{head, chest, pelvis, pelvis}, {float(weight), float(1 - weight), 0, 0}};
  }
  append(body, top);
  for (const int side : {1, -1}) {
    const Vec3 wrist = rest_joints()[side > 0 ? left_hand : right_hand];
    const Vec3 middle = wrist + rest_arm(side) * 0.07 + Vec3{0, 0, 0.01}, half{0.15, 0.15, 0.12};
    append(body, make_body(Figure(hand_parts(side), {}, 0.2), {middle - half, middle + half, hand_cell, 3}));
  }
  return body;
}

} // namespace fvv::synth
