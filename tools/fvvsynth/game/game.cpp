// The script of the game, and the motion that follows from it: feet make steps, the trunk goes where the feet
// are, hands go to the ball, eyes follow it.
#include "fvvsynth/game/game.h"

#include <algorithm>
#include <cmath>

namespace fvv::synth {

namespace {

constexpr double pi = 3.14159265358979323846, degree = pi / 180;
constexpr double gravity = 9.81;
constexpr double length_of_game = 10;

double wrapped(double time) {
  return time - std::floor(time / length_of_game) * length_of_game;
}

// ---- the script ------------------------------------------------------------------------------------------

enum Side { L, R };
enum Kind { step, hop };

// A foot leaves the floor at time and lands after duration where it belongs when the player is at (x, z) and
// looks along heading (degrees, 0 to the hoop at +x, to the left positive): out metres to its side of the
// middle and forward metres to the front.
struct Step {
  double time, duration;
  Side side;
  double x, z, heading, out, forward;
  Kind kind = step;
};

const std::vector<Step> steps[2] = {
    {{0.20, 0.30, L, 0.88, 0.00, 180, 0.16, 0.14},  {0.62, 0.30, R, 0.80, 0.00, 180, 0.20, -0.06},
     {1.05, 0.30, L, 0.70, 0.00, 180, 0.16, 0.14},  {1.36, 0.26, R, 0.64, 0.00, 180, 0.20, -0.10},
     {1.62, 0.26, L, 0.62, 0.00, 180, 0.14, 0.36},  {2.12, 0.30, R, 0.50, 0.00, 180, 0.24, 0.02},
     {2.50, 0.28, L, 0.48, 0.00, 180, 0.26, 0.05},  {2.95, 0.24, R, 0.48, -0.20, 180, 0.27, 0.00},
     {3.22, 0.24, L, 0.48, -0.24, 182, 0.25, 0.02}, {3.66, 0.24, L, 0.50, -0.20, 196, 0.25, 0.02},
     {3.92, 0.26, R, 0.52, -0.24, 222, 0.20, 0.00}, {4.22, 0.26, L, 0.52, -0.26, 246, 0.18, 0.04},
     {4.54, 0.28, R, 0.52, -0.26, 258, 0.17, 0.00}, {4.92, 0.26, L, 0.52, -0.22, 262, 0.17, 0.04},
     {5.78, 0.28, L, 0.60, -0.22, 298, 0.16, 0.02}, {6.06, 0.28, R, 0.70, -0.18, 330, 0.16, 0.02},
     {6.36, 0.28, L, 0.86, -0.10, 348, 0.16, 0.04}, {6.68, 0.28, R, 0.98, -0.03, 360, 0.17, 0.00},
     {7.00, 0.24, L, 1.00, 0.00, 360, 0.17, 0.06},  {7.76, 0.28, R, 1.00, 0.00, 322, 0.17, 0.00},
     {8.08, 0.28, L, 1.00, 0.00, 280, 0.17, 0.00},  {8.40, 0.28, R, 1.00, 0.00, 236, 0.17, 0.00},
     {8.72, 0.28, L, 1.00, 0.00, 200, 0.17, 0.02},  {9.04, 0.26, R, 1.00, 0.00, 180, 0.20, -0.05},
     {9.40, 0.26, L, 1.00, 0.00, 180, 0.17, 0.12}},
    {{0.35, 0.30, L, -1.86, 0.00, 0, 0.20, 0.06},       {0.95, 0.30, R, -1.84, 0.00, 0, 0.22, 0.00},
     {1.62, 0.26, L, -1.82, 0.00, 0, 0.20, 0.12},       {2.18, 0.26, R, -1.80, 0.00, 0, 0.22, -0.06},
     {2.62, 0.28, L, -1.50, -0.10, 6, 0.20, 0.10},      {2.92, 0.28, R, -1.25, -0.12, 6, 0.16, 0.00},
     {3.20, 0.28, L, -1.02, -0.14, 6, 0.24, 0.06},      {3.54, 0.30, R, -0.70, 0.30, -22, 0.22, 0.00},
     {3.86, 0.28, L, -0.38, 0.60, -14, 0.14, 0.00},     {4.14, 0.28, R, -0.06, 0.72, 0, 0.10, -0.02},
     {4.42, 0.28, L, 0.14, 0.72, 14, 0.15, 0.02},       {4.70, 0.26, R, 0.20, 0.70, 24, 0.16, 0.00},
     {4.96, 0.20, L, 0.20, 0.70, 24, 0.16, 0.04},       {5.40, 0.46, L, 0.26, 0.67, 24, 0.16, 0.03, hop},
     {5.40, 0.46, R, 0.26, 0.67, 24, 0.16, -0.02, hop}, {6.85, 0.32, R, 0.02, 0.60, 16, 0.16, 0.00},
     {7.22, 0.32, L, -0.28, 0.50, 10, 0.16, 0.00},      {7.58, 0.32, R, -0.56, 0.38, 6, 0.16, 0.00},
     {7.94, 0.32, L, -0.86, 0.26, 2, 0.16, 0.00},       {8.30, 0.32, R, -1.14, 0.14, 0, 0.16, 0.00},
     {8.66, 0.32, L, -1.44, 0.05, 0, 0.17, 0.00},       {9.02, 0.32, R, -1.70, 0.00, 0, 0.18, 0.00},
     {9.38, 0.28, L, -1.86, 0.00, 0, 0.18, 0.04},       {9.70, 0.26, R, -1.86, 0.00, 0, 0.20, 0.00}}};

// Height of the pelvis in metres, lean forwards and turn of the chest to the left in radians.
const std::vector<Curve::Key> trunk_keys[2] = {
    {{0.00, {0.88, 0.34, -0.20}},
     {0.45, {0.86, 0.40, -0.24}},
     {1.14, {0.88, 0.34, -0.18}},
     {1.45, {0.91, 0.16, 0.00}},
     {1.75, {0.87, 0.30, 0.06}},
     {2.10, {0.88, 0.26, 0.00}},
     {2.60, {0.82, 0.32, 0.00}},
     {3.20, {0.81, 0.34, 0.00}},
     {3.60, {0.82, 0.32, 0.10}},
     {4.20, {0.87, 0.26, 0.10}},
     {4.90, {0.90, 0.14, 0.00}},
     {5.45, {0.93, 0.02, 0.05}},
     {6.00, {0.92, 0.06, 0.00}},
     {6.80, {0.90, 0.14, 0.00}},
     {7.32, {0.87, 0.22, 0.00}},
     {7.70, {0.90, 0.16, -0.08}},
     {8.40, {0.91, 0.14, -0.08}},
     {9.00, {0.89, 0.28, -0.16}},
     {9.60, {0.87, 0.36, -0.22}}},
    {{0.00, {0.90, 0.18, 0.00}},  {1.00, {0.89, 0.22, 0.05}},  {1.80, {0.87, 0.26, 0.00}},
     {2.12, {0.88, 0.24, 0.00}},  {2.50, {0.86, 0.30, 0.10}},  {3.00, {0.84, 0.40, 0.15}},
     {3.40, {0.80, 0.44, 0.15}},  {3.75, {0.82, 0.42, -0.15}}, {4.20, {0.86, 0.34, -0.12}},
     {4.70, {0.86, 0.26, -0.05}}, {5.00, {0.83, 0.24, 0.00}},  {5.22, {0.82, 0.22, 0.00}},
     {5.40, {0.94, 0.08, 0.00}},  {5.63, {1.16, 0.00, -0.05}}, {5.86, {0.93, 0.06, 0.00}},
     {6.02, {0.84, 0.18, 0.00}},  {6.30, {0.90, 0.12, 0.00}},  {6.80, {0.92, 0.08, 0.00}},
     {7.50, {0.90, 0.14, 0.00}},  {9.00, {0.90, 0.15, 0.00}},  {9.60, {0.90, 0.17, 0.00}}}};

// A hand that is free: wrist, directions of the fingers and of the palm, of the left hand; the right one
// mirrors. Metres to the left, up and forward.
struct Pose {
  Vec3 wrist, fingers, palm;
};
constexpr Pose relaxed{{0.30, 0.88, 0.10}, {0.02, -0.95, 0.25}, {-0.95, 0.00, 0.10}},
    ahead{{0.27, 1.02, 0.30}, {-0.10, 0.00, 0.95}, {-0.95, -0.10, 0.00}},
    behind{{0.31, 0.96, -0.10}, {0.00, -0.70, 0.60}, {-0.95, 0.00, 0.00}},
    guard{{0.42, 1.06, 0.32}, {0.12, 0.30, 0.90}, {-0.75, -0.50, 0.20}},
    ready{{0.22, 1.12, 0.46}, {-0.10, 0.80, 0.50}, {-0.50, -0.20, 0.80}},
    wide{{0.62, 1.08, 0.22}, {0.75, 0.45, 0.35}, {0.10, -0.20, 0.95}},
    contest{{0.24, 1.94, 0.30}, {0.00, 0.95, 0.20}, {0.00, -0.25, 0.95}},
    thrown{{0.24, 1.26, 0.62}, {0.05, -0.25, 0.95}, {0.25, -0.90, 0.10}},
    follow{{0.15, 1.96, 0.36}, {0.00, -0.20, 0.95}, {0.00, -0.95, -0.20}},
    beckon{{0.27, 1.24, 0.44}, {-0.10, 0.85, 0.35}, {-0.30, -0.10, 0.90}};

struct PoseKey {
  double time;
  Pose left, right;
};
const std::vector<PoseKey> pose_keys[2] = {
    {{0.00, guard, ahead},
     {0.60, guard, ahead},
     {1.15, ready, ahead},
     {1.95, thrown, thrown},
     {2.25, ready, ready},
     {2.60, wide, wide},
     {3.40, wide, wide},
     {4.00, wide, ahead},
     {4.60, ahead, ahead},
     {5.00, beckon, relaxed},
     {5.42, contest, ahead},
     {5.75, contest, ahead},
     {6.20, ahead, relaxed},
     {6.60, relaxed, ahead},
     {7.00, ready, ready},
     {7.60, ready, ready},
     {8.60, ready, ready},
     {9.05, guard, ahead},
     {9.50, guard, ahead}},
    {{0.00, relaxed, relaxed}, {0.60, ahead, relaxed}, {1.30, beckon, beckon}, {1.90, ready, ready},
     {2.60, ready, ready},     {3.00, ahead, guard},   {3.45, ahead, guard},   {3.85, guard, ahead},
     {4.20, guard, ahead},     {4.60, guard, ahead},   {5.20, ready, ready},   {5.75, beckon, follow},
     {6.15, ahead, follow},    {6.50, relaxed, ahead}, {7.05, ahead, behind},  {7.40, behind, ahead},
     {7.76, ahead, behind},    {8.12, behind, ahead},  {8.48, ahead, behind},  {8.84, behind, ahead},
     {9.20, ahead, behind},    {9.55, relaxed, ahead}}};

// How a hand lies at the ball: where on it (from its centre) and where the fingers point.
struct Touch {
  Vec3 where, fingers;
};
constexpr Touch beside{{0.80, 0.10, -0.58}, {-0.15, 0.55, 0.80}},
    above{{0.12, 0.95, -0.22}, {-0.10, 0.05, 1.00}}, below{{0.10, -0.55, -0.83}, {0.00, 0.90, -0.30}},
    guide{{0.97, 0.05, -0.15}, {0.00, 0.95, 0.25}};

struct TouchKey {
  double time;
  Touch touch;
};
struct Hold { // from start to end the hand is at the ball
  double start, end;
  std::vector<TouchKey> touches;
};
const std::vector<Hold> holds_of[2][2] = {
    {{{1.30, 1.75, {{1.30, beside}}}, {7.32, 8.74, {{7.32, beside}}}},
     {{0.36, 0.56, {{0.36, above}}},
      {1.14, 1.75, {{1.14, above}, {1.40, beside}}},
      {7.32, 9.00, {{8.60, beside}, {8.92, above}}},
      {9.58, 9.78, {{9.58, above}}}}},
    {{{2.12, 2.86, {{2.55, beside}, {2.82, above}}},
      {3.42, 3.60, {{3.42, above}}},
      {4.92, 5.56, {{5.12, beside}, {5.36, guide}}}},
     {{2.12, 2.72, {{2.12, beside}}},
      {4.02, 4.20, {{4.02, above}}},
      {4.74, 5.62, {{4.74, above}, {4.94, beside}, {5.14, beside}, {5.36, below}}}}}};
constexpr double reach_time = 0.24; // in which a hand comes to the ball, and leaves it

// The ball in a player's hands: where it is at some times. Left of and before him; heights from the floor.
struct Carry {
  int player;
  struct At {
    double time;
    Vec3 place;
  };
  std::vector<At> way;
  double bounce; // the time at which it meets the floor on its way to the next hands; 0: not
};
const std::vector<Carry> carries = {{0, {{0.36, {-0.30, 0.86, 0.42}}, {0.56, {-0.30, 0.84, 0.44}}}, 0.80},
                                    {0,
                                     {{1.14, {-0.30, 0.86, 0.44}},
                                      {1.38, {-0.08, 1.04, 0.44}},
                                      {1.58, {0.00, 1.16, 0.42}},
                                      {1.75, {0.00, 1.18, 0.62}}},
                                     0},
                                    {1,
                                     {{2.12, {0.00, 1.10, 0.52}},
                                      {2.36, {0.00, 1.02, 0.44}},
                                      {2.66, {0.20, 0.98, 0.46}},
                                      {2.86, {0.32, 0.82, 0.46}}},
                                     3.10},
                                    {1, {{3.42, {0.32, 0.78, 0.42}}, {3.60, {0.26, 0.72, 0.42}}}, 3.78},
                                    {1, {{4.02, {-0.29, 0.78, 0.38}}, {4.20, {-0.36, 0.80, 0.44}}}, 4.44},
                                    {1,
                                     {{4.74, {-0.32, 0.84, 0.48}},
                                      {4.92, {-0.08, 1.00, 0.42}},
                                      {5.14, {-0.06, 1.04, 0.40}},
                                      {5.32, {-0.10, 1.42, 0.38}},
                                      {5.48, {-0.13, 1.98, 0.30}},
                                      {5.62, {-0.13, 2.27, 0.36}}},
                                     6.98},
                                    {0,
                                     {{7.32, {0.00, 1.06, 0.48}},
                                      {7.60, {0.00, 1.10, 0.42}},
                                      {8.20, {0.00, 1.06, 0.42}},
                                      {8.66, {-0.08, 0.98, 0.42}},
                                      {9.00, {-0.30, 0.84, 0.44}}},
                                     9.24},
                                    {0, {{9.58, {-0.30, 0.86, 0.42}}, {9.78, {-0.30, 0.84, 0.44}}}, 10.02}};
constexpr size_t shot = 5; // the carry that ends with it
constexpr double ring_time = 6.32, net_end = 6.50;

// ---- what follows from it
// ----------------------------------------------------------------------------------

constexpr double step_height = 0.09, hop_height = 0.25;

double ankle_height() {
  return rest_joints()[left_foot].y;
}

Vec3 forward_of(double heading) {
  return {std::cos(heading), 0, -std::sin(heading)};
}
Vec3 left_of(double heading) {
  return {-std::sin(heading), 0, -std::cos(heading)};
}

// 0 to 1 with continuous acceleration.
double ease(double t) {
  return t * t * t * (10 + t * (6 * t - 15));
}

struct Footprint {
  Vec3 at;
  double heading;
};
Footprint footprint(const Step &s) {
  const double heading = s.heading * degree;
  const Vec3 at =
      Vec3{s.x, 0, s.z} + left_of(heading) * (s.side == L ? s.out : -s.out) + forward_of(heading) * s.forward;
  return {at, heading};
}

// The step of a foot that began last, and the one before it.
struct Steps {
  const Step *before, *last;
};
Steps steps_of(int player, int side, double now) {
  std::vector<const Step *> own;
  for (const Step &s : steps[player])
    if (s.side == side) own.push_back(&s);
  size_t i = own.size() - 1;
  while (i > 0 && own[i]->time > now) i--;
  if (own[i]->time > now) i = own.size() - 1; // the last of the time before
  return {own[(i + own.size() - 1) % own.size()], own[i]};
}

double since(const Step &s, double now) {
  return wrapped(now - s.time);
}

std::vector<Curve> trunk_curves() {
  return {Curve(trunk_keys[0], length_of_game), Curve(trunk_keys[1], length_of_game)};
}

// Curves of wrist, fingers and palm of a hand.
std::array<Curve, 3> pose_curves(int player, int side) {
  const auto curve = [&](Vec3 Pose::*member) {
    std::vector<Curve::Key> keys;
    for (const PoseKey &key : pose_keys[player]) {
      const Vec3 v = (side == L ? key.left : key.right).*member;
      keys.push_back({key.time, {side == L ? v.x : -v.x, v.y, v.z}});
    }
    return Curve(keys, length_of_game);
  };
  return {curve(&Pose::wrist), curve(&Pose::fingers), curve(&Pose::palm)};
}

// How much a hand is at the ball, and the moment of the ball's path that it is at.
struct Grip {
  double weight = 0, moment = 0;
  const Hold *hold = nullptr;
};
Grip grip(int player, int side, double time) {
  Grip best;
  const double now = wrapped(time);
  for (const Hold &hold : holds_of[player][side])
    for (const double t : {now, now + length_of_game, now - length_of_game}) {
      const double weight = smoothstep(hold.start - reach_time, hold.start, t) *
                            (1 - smoothstep(hold.end, hold.end + reach_time, t));
      if (weight > best.weight) best = {weight, std::clamp(t, hold.start, hold.end), &hold};
    }
  return best;
}

Touch touch_at(const Hold &hold, double time) {
  const auto &keys = hold.touches;
  size_t i = keys.size() - 1;
  while (i > 0 && keys[i].time > time) i--;
  if (i + 1 == keys.size()) return keys[i].touch;
  const double t = ease(std::clamp((time - keys[i].time) / (keys[i + 1].time - keys[i].time), 0.0, 1.0));
  const Touch &a = keys[i].touch, &b = keys[i + 1].touch;
  return {mix(a.where, b.where, t), mix(a.fingers, b.fingers, t)};
}

} // namespace

Game::Game(Random &random) : scales{random.between(0.98, 1.00), random.between(1.00, 1.03)} {
  build_ball();
}

double Game::duration() const {
  return length_of_game;
}

Game::Foot Game::foot(int player, int side, double time) const {
  const double now = wrapped(time);
  const Steps own = steps_of(player, side, now);
  const Footprint from = footprint(*own.before), to = footprint(*own.last);
  const double t = std::min(since(*own.last, now) / own.last->duration, 1.0), u = ease(t);
  const double wave = std::sin(pi * t) * std::sin(pi * t);
  const bool hops = own.last->kind == hop;
  const double lift = hops ? hop_height * 4 * t * (1 - t) : step_height * wave;
  // The heel leaves first, and lands first.
  const double pitch = hops ? 0.6 * std::sin(pi * t) : wave * (0.55 - 0.75 * t);
  Foot out;
  out.ankle = mix(from.at, to.at, u) + Vec3{0, (ankle_height() + lift) * scale(player), 0};
  out.heading = from.heading + (to.heading - from.heading) * u;
  out.weight = hops ? 1 : 1 - wave;
  out.pitch = pitch;
  return out;
}

bool Game::planted(int player, int side, double time) const {
  const double now = wrapped(time);
  const Step &last = *steps_of(player, side, now).last;
  return since(last, now) >= last.duration;
}

// Where the feet are on average, over a moment: so the trunk moves over the foot that is on the floor before
// the other one leaves it.
Game::Stand Game::stand(int player, double time) const {
  constexpr int moments = 9;
  constexpr double inertia = 0.26; // seconds before and after
  constexpr double least = 0.3;    // of the weight of a foot in the air
  Vec3 centre;
  double heading = 0, weights = 0;
  for (int i = -moments; i <= moments; i++) {
    const double away = double(i) / (moments + 1), near = (1 - away * away) * (1 - away * away);
    for (const int side : {L, R}) {
      const Foot at = foot(player, side, time + inertia * away);
      const double weight = near * (least + (1 - least) * at.weight);
      centre += at.ankle * weight;
      heading += at.heading * weight;
      weights += weight;
    }
  }
  Stand out;
  out.centre = centre * (1 / weights);
  out.centre.y = 0;
  out.heading = heading / weights;
  out.left = left_of(out.heading);
  out.forward = forward_of(out.heading);
  return out;
}

Vec3 Game::in_front(int player, double time, Vec3 p) const {
  const Stand at = stand(player, time);
  return at.centre + at.left * p.x + Vec3{0, p.y, 0} + at.forward * p.z;
}

void Game::fly(double start, double end, Vec3 from, Vec3 to, double spin) {
  const double t = end - start;
  spans.push_back({start, t, true, from, (to - from) * (1 / t) + Vec3{0, 0.5 * gravity * t, 0}, {}, spin});
}

void Game::build_ball() {
  // Flights first: they give the velocities at which hands take the ball and let it go.
  const auto end_of = [&](const Carry &carry) {
    return in_front(carry.player, carry.way.back().time, carry.way.back().place);
  };
  std::vector<std::vector<Span>> flights;
  for (size_t i = 0; i < carries.size(); i++) {
    const Carry &carry = carries[i], &next = carries[(i + 1) % carries.size()];
    const double start = carry.way.back().time,
                 end = next.way.front().time + (i + 1 == carries.size() ? length_of_game : 0);
    const Vec3 from = end_of(carry),
               to = in_front(next.player, next.way.front().time, next.way.front().place);
    spans.clear();
    if (i == shot) {
      fly(start, ring_time, from, ring_centre, -11);
      const Vec3 out_of_net = ring_centre + Vec3{0.01, -0.40, 0}, floor{ring_centre.x + 0.01, ball_radius, 0};
      const Span &flight = spans.back();
      const Vec3 into = flight.velocity - Vec3{0, gravity * flight.duration, 0};
      fly(net_end, carry.bounce, out_of_net, floor, -3);
      Span net{ring_time, net_end - ring_time, false, {}, {}, {}, -6};
      net.curve = Curve({{ring_time, ring_centre}, {net_end, out_of_net}}, into, spans.back().velocity);
      spans.insert(spans.end() - 1, net);
      fly(carry.bounce, end, floor, to, 5);
    } else if (carry.bounce > 0) {
      Vec3 floor = mix(from, to, (carry.bounce - start) / (end - start));
      floor.y = ball_radius;
      fly(start, carry.bounce, from, floor, 4);
      fly(carry.bounce, end, floor, to, 4);
    } else {
      fly(start, end, from, to, -9);
    }
    if (carry.bounce > 0) floor_times.push_back(wrapped(carry.bounce));
    flights.push_back(spans);
  }
  std::sort(floor_times.begin(), floor_times.end());
  spans.clear();
  for (size_t i = 0; i < carries.size(); i++) {
    const Span &before = flights[(i + carries.size() - 1) % carries.size()].back();
    std::vector<Curve::Key> keys;
    for (const Carry::At &at : carries[i].way)
      keys.push_back({at.time, in_front(carries[i].player, at.time, at.place)});
    const Vec3 taken = before.velocity - Vec3{0, gravity * before.duration, 0};
    // A catch takes most of the speed of a pass at once; hands meet a dribbled ball at its own.
    const double kept = length(taken) > 3 ? 0.5 : 1;
    const double start = keys.front().time, duration = keys.back().time - start;
    Span span{start, duration, false, {}, {}, {}, 0};
    span.curve = Curve(std::move(keys), taken * kept, flights[i].front().velocity);
    spans.push_back(std::move(span));
    spans.insert(spans.end(), flights[i].begin(), flights[i].end());
  }
  // Whole turns in all, so that the ball's seams are where they were when the game begins again.
  double turned = 0;
  for (const Span &s : spans) turned += s.spin * s.duration;
  const double whole = std::round(turned / (2 * pi)) * 2 * pi;
  spin_factor = turned == 0 ? 0 : whole / turned;
}

const Game::Span &Game::span(double &time) const {
  const double first = spans.front().start;
  time = first + wrapped(time - first);
  size_t i = spans.size() - 1;
  while (i > 0 && spans[i].start > time) i--;
  return spans[i];
}

Vec3 Game::ball_position(double time) const {
  const Span &s = span(time);
  const double t = time - s.start;
  if (s.flight) return s.from + s.velocity * t - Vec3{0, 0.5 * gravity * t * t, 0};
  return s.curve->at(time);
}

Mat3 Game::ball_rotation(double time) const {
  const Span &now = span(time);
  double turned = now.spin * (time - now.start);
  for (const Span &s : spans)
    if (s.start < now.start) turned += s.spin * s.duration;
  return rotation_about(normalised(Vec3{0, 0.25, -1}), turned * spin_factor);
}

double Game::net_time() const {
  return ring_time;
}

std::vector<double> Game::landings() const {
  std::vector<double> out;
  for (const auto &list : steps)
    for (const Step &s : list) out.push_back(wrapped(s.time + s.duration));
  std::sort(out.begin(), out.end());
  return out;
}

bool Game::holds(int player, int hand, double time) const {
  const double now = wrapped(time);
  for (const Hold &hold : holds_of[player][hand])
    if (now >= hold.start && now <= hold.end) return true;
  return false;
}

HandGoal Game::hand_goal(int player, int side, double time, const Posture &posture, const Stand &at) const {
  static const std::array<std::array<Curve, 3>, 4> curves = {pose_curves(0, L), pose_curves(0, R),
                                                             pose_curves(1, L), pose_curves(1, R)};
  const auto &pose = curves[size_t(2 * player + side)];
  const double s = scale(player);
  const auto world = [&](Vec3 v) { return at.left * v.x + Vec3{0, v.y, 0} + at.forward * v.z; };
  // Free hands move with the trunk: the poses are those of a pelvis at this height.
  const Vec3 below = posture.pelvis - Vec3{0, 0.89 * s, 0};
  const Vec3 free_wrist = below + world(pose[0].at(time)) * s;
  const Vec3 free_fingers = world(pose[1].at(time)), free_palm = world(pose[2].at(time));
  const Grip held = grip(player, side, time);
  Vec3 wrist = free_wrist, fingers = free_fingers, palm = free_palm;
  if (held.hold) {
    const Touch touch = touch_at(*held.hold, held.moment);
    const auto mirrored = [&](Vec3 v) { return Vec3{side == L ? v.x : -v.x, v.y, v.z}; };
    const Vec3 where = normalised(world(mirrored(touch.where)));
    Vec3 along = world(mirrored(touch.fingers));
    along = normalised(along - where * dot(along, where));
    const Vec3 at_ball = ball_position(held.moment) + where * (ball_radius + 0.026 * s) - along * (0.09 * s);
    wrist = mix(free_wrist, at_ball, held.weight);
    fingers = mix(free_fingers, along, held.weight);
    palm = mix(free_palm, -where, held.weight);
  }
  const Mat3 grasp = facing(fingers, palm);
  constexpr double loose = 0.45, round_ball = 0.32;
  return {wrist, grasp.z, grasp.y, loose + (round_ball - loose) * held.weight};
}

Posture Game::posture(int player, double time) const {
  static const std::vector<Curve> trunk = trunk_curves();
  const double s = scale(player);
  const Stand at = stand(player, time);
  const Vec3 height_lean_turn = trunk[size_t(player)].at(time);
  const double turn = height_lean_turn.z;

  Posture posture;
  posture.scale = s;
  // Leans into the way it is pushed.
  constexpr double moment = 0.08, per_push = 0.022, most = 0.16;
  const Vec3 push =
      (stand(player, time + moment).centre + stand(player, time - moment).centre - at.centre * 2) *
      (1 / (moment * moment));
  const double tilt = std::clamp(-per_push * dot(push, at.left), -most, most);
  const double lean = height_lean_turn.y + std::clamp(per_push * dot(push, at.forward), -most, most);

  double height = height_lean_turn.x * s;
  const Vec3 over = at.centre - at.forward * (0.22 * std::sin(lean) * s);
  const double leg = 0.880 * s, hip = 0.05 * s; // hips are that much below the pelvis
  for (const int side : {L, R}) {
    const Foot down = foot(player, side, time);
    const double heading = down.heading;
    posture.foot[side].ankle = down.ankle;
    posture.foot[side].rotation = facing(forward_of(heading), {0, 1, 0}) *
                                  rotation_about({0, 1, 0}, side == L ? 0.22 : -0.22) *
                                  rotation_about({1, 0, 0}, down.pitch);
    posture.knee_towards[side] =
        forward_of(0.5 * (heading + at.heading)) + left_of(heading) * (side == L ? 0.30 : -0.30);
    // No lower than both legs reach; the corner of the minimum is rounded.
    const Vec3 hip_at = over + at.left * ((side == L ? 0.095 : -0.095) * s);
    const double dx = down.ankle.x - hip_at.x, dz = down.ankle.z - hip_at.z;
    const double limit = down.ankle.y + std::sqrt(std::max(0.04, leg * leg - dx * dx - dz * dz)) + hip;
    const double round = std::max(0.03 - std::abs(height - limit), 0.0) / 0.03;
    height = std::min(height, limit) - round * round * 0.03 * 0.25;
  }
  posture.pelvis = over + Vec3{0, height, 0};

  const Mat3 base = facing(at.forward, {0, 1, 0});
  const Mat3 upright = base * rotation_about({0, 1, 0}, turn);
  posture.pelvis_rotation = base * rotation_about({0, 1, 0}, 0.4 * turn) *
                            rotation_about({1, 0, 0}, 0.45 * lean) * rotation_about({0, 0, 1}, 0.5 * tilt);
  posture.chest_rotation = upright * rotation_about({1, 0, 0}, lean) * rotation_about({0, 0, 1}, tilt);

  const Vec3 eyes = posture.pelvis + posture.chest_rotation * Vec3{0, 0.72, 0} * s;
  const Vec3 to_ball = normalised(ball_position(time) - eyes);
  // A neck turns by less than a right angle: what is behind is looked at from the corners of the eyes.
  posture.head_rotation =
      facing(upright.z * 0.8 + to_ball * 0.9, posture.chest_rotation.y + Vec3{0, 1, 0} * 1.5);

  for (const int side : {L, R}) {
    posture.hand[side] = hand_goal(player, side, time, posture, at);
    // Elbows hang down and out; of arms that are raised they point forwards.
    const double raised = smoothstep(0.35, 0.75, (posture.hand[side].wrist.y - posture.pelvis.y) / s);
    const Vec3 v = mix(Vec3{0.60, -0.75, -0.45}, Vec3{0.45, -0.45, 0.75}, raised);
    posture.elbow_towards[side] = at.left * (side == L ? v.x : -v.x) + Vec3{0, v.y, 0} + at.forward * v.z;
  }
  return posture;
}

} // namespace fvv::synth
