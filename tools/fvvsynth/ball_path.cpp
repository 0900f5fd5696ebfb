// Parabolas in the air, cubic Hermite curves in the hands.
#include "fvvsynth/ball_path.h"

#include "fvvsynth/skeleton.h"

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

} // namespace fvv::synth
