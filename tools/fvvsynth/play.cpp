// Parabolas in the air, cubic Hermite curves in the hands.
#include "fvvsynth/play.h"

#include "fvvsynth/body/skeleton.h"

#include <algorithm>
#include <cmath>

namespace fvv::synth {

namespace {

constexpr double gravity = 9.81;
constexpr double push_speed = 2.6, rebound_speed = 3.9; // m/s at the hand and off the floor
constexpr double dribble_height = 0.86;

double wrapped(double time) {
  return time - std::floor(time / cycle) * cycle;
}

// Velocity with which a throw reaches a place after a time.
Vec3 launch(Vec3 from, Vec3 to, double duration) {
  return (to - from) * (1 / duration) + Vec3{0, 0.5 * gravity * duration, 0};
}
Vec3 fallen(Vec3 velocity, double duration) {
  return velocity - Vec3{0, gravity * duration, 0};
}

} // namespace

BallPath::BallPath(const std::array<Place, 2> &places)
    : spin_axis(normalised(cross({0, 1, 0}, places[0].forward) + Vec3{0, 0.25, 0})) {
  add_half(places[0], places[1], 0);
  add_half(places[1], places[0], half_cycle);
}

void BallPath::add_half(const Place &handler, const Place &receiver, double start) {
  const double drop = dribble_height - ball_radius;
  const double down = (std::sqrt(push_speed * push_speed + 2 * gravity * drop) - push_speed) / gravity;
  const double speed_at_hand = std::sqrt(rebound_speed * rebound_speed - 2 * gravity * drop);
  const double up = (rebound_speed - speed_at_hand) / gravity;
  times.gather = times.push_end + down + up;

  const Vec3 dribble{-0.30, dribble_height, 0.40}, floor_below{-0.31, ball_radius, 0.46};
  const Vec3 meet = handler.at(dribble), below = handler.at(floor_below);
  const Vec3 throw_from = handler.at({0, 1.12, 0.60}), take_at = receiver.at({0.02, 1.04, 0.52});
  const double share = (times.bounce - times.pass) / (times.take - times.pass);
  Vec3 bounce_at = mix(throw_from, take_at, share);
  bounce_at.y = ball_radius;

  const Vec3 rising{0, speed_at_hand, 0};
  const Vec3 thrown = launch(throw_from, bounce_at, times.bounce - times.pass);
  const Vec3 caught =
      fallen(launch(bounce_at, take_at, times.take - times.bounce), times.take - times.bounce);
  hold(start, times.push_end, meet, rising, meet, launch(meet, below, down));
  fly(start + times.push_end, down, meet, below, -4);
  fly(start + times.push_end + down, up, below, meet, -3);
  hold(start + times.gather, times.pass - times.gather, meet, rising, throw_from, thrown);
  fly(start + times.pass, times.bounce - times.pass, throw_from, bounce_at, -9);
  fly(start + times.bounce, times.take - times.bounce, bounce_at, take_at, 14);
  hold(start + times.take, half_cycle - times.take, take_at, caught * 0.6, receiver.at(dribble), rising);
}

void BallPath::fly(double start, double duration, Vec3 from, Vec3 to, double spin) {
  const Vec3 velocity = launch(from, to, duration);
  spans.push_back({start, duration, true, from, velocity, to, fallen(velocity, duration), spin});
}

void BallPath::hold(double start, double duration, Vec3 from, Vec3 velocity_from, Vec3 to, Vec3 velocity_to) {
  spans.push_back({start, duration, false, from, velocity_from, to, velocity_to, 0});
}

const BallPath::Span &BallPath::span(double time) const {
  size_t i = spans.size() - 1;
  while (i > 0 && spans[i].start > time) i--;
  return spans[i];
}

Vec3 BallPath::position(double time) const {
  const double now = wrapped(time);
  const Span &s = span(now);
  const double t = now - s.start;
  if (s.flight) return s.from + s.velocity_from * t - Vec3{0, 0.5 * gravity * t * t, 0};
  const double u = t / s.duration, v = 1 - u;
  return s.from * (v * v * (1 + 2 * u)) + s.velocity_from * (s.duration * u * v * v) +
         s.to * (u * u * (1 + 2 * v)) - s.velocity_to * (s.duration * v * u * u);
}

Mat3 BallPath::rotation(double time) const {
  double turned = 0, turned_in_cycle = 0;
  const double now = wrapped(time);
  for (const Span &s : spans) {
    turned_in_cycle += s.spin * s.duration;
    if (now > s.start) turned += s.spin * std::fmin(now - s.start, s.duration);
  }
  return rotation_about(spin_axis, turned + turned_in_cycle * std::floor(time / cycle));
}

namespace {

constexpr double pi = 3.14159265358979323846;

// Trunk: height of the pelvis, lean forwards and turn to the left in radians.
struct TrunkKey {
  double time;
  Vec3 height_lean_turn;
};
constexpr TrunkKey trunk_keys[] = {
    {0.00, {0.90, 0.38, -0.22}}, {0.25, {0.84, 0.50, -0.30}}, {0.65, {0.89, 0.40, -0.20}},
    {0.90, {0.91, 0.12, -0.05}}, {1.05, {0.88, 0.36, 0.08}},  {1.35, {0.92, 0.24, 0.04}},
    {2.00, {0.93, 0.15, 0.00}},  {2.60, {0.91, 0.20, 0.10}},  {3.20, {0.87, 0.30, 0.06}},
    {3.65, {0.88, 0.26, -0.02}}, {3.80, {0.89, 0.28, -0.08}}};

// A free hand: wrist, direction of the fingers, direction of the palm; of the left hand, the right one
// mirrors.
struct HandKey {
  double time;
  Vec3 wrist, fingers, palm;
};
constexpr HandKey left_keys[] = {{0.00, {0.40, 1.02, 0.26}, {0.10, 0.15, 0.90}, {-0.80, -0.50, 0.10}},
                                 {0.35, {0.43, 1.08, 0.34}, {0.15, 0.35, 0.90}, {-0.70, -0.50, 0.20}},
                                 {0.70, {0.36, 1.02, 0.36}, {0.00, 0.40, 0.90}, {-0.90, -0.20, 0.10}},
                                 {1.15, {0.24, 1.26, 0.62}, {0.05, -0.25, 0.95}, {0.25, -0.90, 0.10}},
                                 {1.60, {0.36, 1.00, 0.30}, {0.00, -0.20, 0.95}, {-0.95, -0.20, 0.00}},
                                 {2.30, {0.37, 0.96, 0.18}, {0.05, -0.60, 0.80}, {-0.95, -0.10, 0.00}},
                                 {2.95, {0.30, 1.12, 0.38}, {0.05, 0.50, 0.85}, {-0.50, -0.40, 0.50}},
                                 {3.50, {0.22, 1.12, 0.48}, {-0.10, 0.80, 0.50}, {-0.50, -0.20, 0.80}}};
constexpr HandKey right_keys[] = {{0.40, {0.33, 0.98, 0.34}, {0.00, -0.15, 0.95}, {-0.10, -1.00, 0.00}},
                                  {0.60, {0.32, 1.02, 0.34}, {0.00, -0.10, 0.95}, {-0.10, -1.00, 0.00}},
                                  {1.15, {0.24, 1.26, 0.62}, {0.05, -0.25, 0.95}, {0.25, -0.90, 0.10}},
                                  {1.65, {0.37, 0.98, 0.26}, {0.00, -0.30, 0.95}, {-0.95, -0.20, 0.00}},
                                  {2.40, {0.38, 0.95, 0.16}, {0.05, -0.65, 0.75}, {-0.95, -0.10, 0.00}},
                                  {2.95, {0.32, 1.08, 0.36}, {0.05, 0.45, 0.85}, {-0.50, -0.40, 0.50}},
                                  {3.50, {0.22, 1.12, 0.48}, {-0.10, 0.80, 0.50}, {-0.50, -0.20, 0.80}}};

// A step: the foot leaves at time and stands at (left, forward) after duration. Steps of a foot are in order
// of time; the last one brings it to where the cycle begins.
struct Step {
  double time, duration, left, forward;
};
constexpr Step left_steps[] = {{0.40, 0.30, 0.17, 0.16},
                               {0.86, 0.26, 0.15, 0.44},
                               {2.10, 0.32, 0.24, 0.10},
                               {2.85, 0.28, 0.12, -0.04},
                               {3.62, 0.26, 0.23, 0.02}};
constexpr Step right_steps[] = {{0.08, 0.30, -0.33, 0.02},
                                {1.35, 0.30, -0.22, 0.14},
                                {2.48, 0.30, -0.27, -0.10},
                                {3.22, 0.28, -0.34, -0.06},
                                {3.90, 0.10, -0.25, -0.06}};

// How much a hand is at the ball: from the moment of start to that of end entirely, before and after it comes
// and goes.
struct Grip {
  double share;
  double moment; // of the ball's path that the hand is at, in the player's time
};
constexpr double reach_time = 0.24;

double in_cycle(double time) {
  return time - std::floor(time / cycle) * cycle;
}

Grip grip(double time, double start, double end) {
  // Intervals may run over the end of the cycle: look at the time before and after one turn too.
  for (const double t : {time, time + cycle, time - cycle}) {
    if (t < start - reach_time || t > end + reach_time) continue;
    const double share =
        smoothstep(start - reach_time, start, t) * (1 - smoothstep(end, end + reach_time, t));
    return {share, std::clamp(t, start, end)};
  }
  return {0, start};
}

// Smooth periodic interpolation through keys: cubic Hermite with slopes of the neighbours (Catmull and Rom).
template <class Key, size_t n, class Value> Vec3 keyed(const Key (&keys)[n], double time, Value value) {
  size_t i = n - 1;
  while (i > 0 && keys[i].time > time) i--;
  if (keys[i].time > time) i = n - 1; // before the first key: the span that runs over the end of the cycle
  const auto at = [&](size_t k) -> const Key & { return keys[k % n]; };
  const auto span = [&](size_t a, size_t b) {
    const double d = at(b).time - at(a).time;
    return d > 0 ? d : d + cycle;
  };
  const Vec3 p0 = value(at(i + n - 1)), p1 = value(at(i)), p2 = value(at(i + 1)), p3 = value(at(i + 2));
  const double before = span(i + n - 1, i), d = span(i, i + 1), after = span(i + 1, i + 2);
  const Vec3 m1 = (p2 - p0) * (d / (before + d)), m2 = (p3 - p1) * (d / (d + after));
  double u = time - at(i).time;
  u = (u < 0 ? u + cycle : u) / d;
  const double v = 1 - u;
  return p1 * (v * v * (1 + 2 * u)) + m1 * (u * v * v) + p2 * (u * u * (1 + 2 * v)) - m2 * (v * u * u);
}

struct Footing {
  double left, forward, lift; // lift: 0 on the floor, 1 at the top of a step
};
template <size_t n> Footing footing(const Step (&steps)[n], double time) {
  Footing foot{steps[n - 1].left, steps[n - 1].forward, 0};
  for (const Step &step : steps) {
    if (time <= step.time) break;
    const double t = std::min((time - step.time) / step.duration, 1.0), u = smoothstep(0, 1, t);
    foot = {foot.left + (step.left - foot.left) * u, foot.forward + (step.forward - foot.forward) * u,
            std::sin(pi * t) * std::sin(pi * t)};
  }
  return foot;
}

Vec3 mirrored(Vec3 v, int side) {
  return {side * v.x, v.y, v.z};
}

// How a hand lies at the ball: where on the ball (unit vector from its centre), fingers and palm.
struct Contact {
  Vec3 where, fingers;
};
Contact beside(int side) {
  return {{side * 0.80, 0.10, -0.58}, {side * -0.15, 0.55, 0.80}};
}
Contact above(int side) {
  return {{side * 0.12, 0.95, -0.22}, {side * -0.10, 0.05, 1.00}};
}

} // namespace

Play::Play(Random &random)
    : places([&] {
        const double distance = random.between(1.36, 1.46), turn = random.between(-0.12, 0.12);
        const Vec3 forward = normalised(Vec3{1, 0, turn});
        const auto place = [&](Vec3 f) { return Place{f * -distance, cross({0, 1, 0}, f), f}; };
        return std::array<Place, 2>{place(forward), place(-forward)};
      }()),
      manner([&] {
        const auto one = [&] {
          Manner m;
          m.scale = random.between(0.97, 1.04);
          m.crouch = random.between(-0.015, 0.015);
          m.sway = random.between(0.010, 0.020);
          m.sway_phase = random.between(0, 2 * pi);
          return m;
        };
        const Manner first = one();
        return std::array<Manner, 2>{first, one()};
      }()),
      path(places) {}

Posture Play::posture(int player, double time) const {
  const Place &place = places[size_t(player)];
  const Manner &how = manner[size_t(player)];
  const double shift = player * half_cycle; // player's time = time - shift
  const double now = in_cycle(time - shift), s = how.scale;
  const Mat3 base = facing(place.forward, {0, 1, 0});

  Posture posture;
  posture.scale = s;
  const Footing feet[2] = {footing(left_steps, now), footing(right_steps, now)};
  for (int i = 0; i < 2; i++) {
    const int side = i == 0 ? 1 : -1;
    const double ankle_height = rest_joints()[left_foot].y;
    posture.foot[i].ankle =
        place.at(Vec3{feet[i].left, ankle_height + 0.09 * feet[i].lift, feet[i].forward} * s);
    posture.foot[i].rotation =
        base * rotation_about({0, 1, 0}, side * 0.22) * rotation_about({1, 0, 0}, 0.40 * feet[i].lift);
    posture.knee_towards[i] = place.direction({side * 0.30, 0, 1});
    posture.elbow_towards[i] = place.direction({side * 0.60, -0.75, -0.45});
  }

  const Vec3 trunk = keyed(trunk_keys, now, [](const TrunkKey &k) { return k.height_lean_turn; });
  const double lean = trunk.y, turn = trunk.z;
  const double sway = how.sway * std::sin(2 * pi * 2 * time / cycle + how.sway_phase);
  const Vec3 trunk_at{0.5 * (feet[0].left + feet[1].left) + sway, trunk.x + how.crouch,
                      0.5 * (feet[0].forward + feet[1].forward) - 0.22 * std::sin(lean)};
  posture.pelvis = place.at(trunk_at * s);
  const Mat3 upright = base * rotation_about({0, 1, 0}, turn);
  posture.pelvis_rotation =
      base * rotation_about({0, 1, 0}, 0.4 * turn) * rotation_about({1, 0, 0}, 0.45 * lean);
  posture.chest_rotation = upright * rotation_about({1, 0, 0}, lean) * rotation_about({0, 0, 1}, -2 * sway);

  const Vec3 eyes = posture.pelvis + posture.chest_rotation * Vec3{0, 0.72, 0} * s;
  const Vec3 to_ball = normalised(path.position(time) - eyes);
  const Vec3 to_other = normalised(place.direction({0, -0.1, 1}));
  posture.head_rotation =
      facing(upright.z * 0.5 + to_ball * 0.6 + to_other * 0.6, posture.chest_rotation.y + Vec3{0, 1, 0});

  // Hands at rest in the air move with the trunk, hands at the ball with the ball.
  const Timing &t = path.timing();
  const double take = half_cycle + t.take;
  for (int i = 0; i < 2; i++) {
    const int side = i == 0 ? 1 : -1;
    const auto key = [&](auto member) {
      const auto value = [&](const HandKey &k) { return k.*member; };
      return mirrored(i == 0 ? keyed(left_keys, now, value) : keyed(right_keys, now, value), side);
    };
    const Vec3 drift{trunk_at.x, trunk_at.y - 0.89, trunk_at.z};
    const Vec3 free_wrist = place.at((key(&HandKey::wrist) + drift) * s);
    const Vec3 free_fingers = place.direction(key(&HandKey::fingers)),
               free_palm = place.direction(key(&HandKey::palm));

    const bool right = i == 1;
    const Grip after_take = grip(now, take, right ? cycle + t.push_end : take + 0.16);
    const Grip gathering = grip(now, right ? t.gather : t.gather + 0.10, t.pass);
    const bool gathers = gathering.share > after_take.share;
    const Grip &held = gathers ? gathering : after_take;
    // The dribbling hand turns from beside the ball to above it after the catch, and back for the pass.
    const double top = !right    ? 0
                       : gathers ? 1 - smoothstep(t.gather, t.gather + 0.2, held.moment)
                                 : smoothstep(take + 0.02, take + 0.26, held.moment);
    const Vec3 where = normalised(place.direction(mix(beside(side).where, above(side).where, top)));
    const Vec3 fingers = normalised(place.direction(mix(beside(side).fingers, above(side).fingers, top)));
    const Vec3 centre = path.position(held.moment + shift);
    const Vec3 at_ball = centre + where * (ball_radius + 0.026 * s) - fingers * (0.09 * s);

    const Mat3 grasp = facing(mix(free_fingers, fingers, held.share), mix(free_palm, -where, held.share));
    posture.hand[i] = {mix(free_wrist, at_ball, held.share), grasp.z, grasp.y};
  }
  return posture;
}

} // namespace fvv::synth
