// What the two players and the ball do: a closed cycle of dribbling, stepping, passing and catching. Metres,
// seconds, y up.
#pragma once

#include "fvv_render/vector.h"
#include "fvvsynth/body/skeleton.h"
#include "fvvsynth/random.h"

#include <array>
#include <vector>

namespace fvv::synth {

using render::Mat3;
using render::Vec3;

constexpr double ball_radius = 0.12;
// Each player handles the ball for half of a cycle: dribbles, gathers it and passes it by way of the floor.
constexpr double half_cycle = 2.0, cycle = 2 * half_cycle;

// Times within a half cycle, from the moment when the handler's hand meets the rising ball.
struct Timing {
  double push_end = 0.20; // the ball leaves the hand downwards
  double gather = 0;      // it is back at the hand; follows from the fall
  double pass = 1.00;     // it leaves both hands
  double bounce = 1.32;   // it meets the floor
  double take = 1.70;     // the other player catches it
};

// A player's own axes on the floor.
struct Place {
  Vec3 home, left, forward;
  Vec3 at(Vec3 left_up_forward) const {
    return home + left * left_up_forward.x + Vec3{0, left_up_forward.y, 0} + forward * left_up_forward.z;
  }
  Vec3 direction(Vec3 left_up_forward) const { return at(left_up_forward) - home; }
};

// What is filmed: two players and a ball. It repeats.
class Action {
public:
  virtual ~Action() = default;
  virtual double duration() const = 0; // seconds until it repeats
  virtual Vec3 ball_position(double time) const = 0;
  virtual Mat3 ball_rotation(double time) const = 0;
  // Of player 0 or 1 at a time in seconds, any.
  virtual Posture posture(int player, double time) const = 0;
  virtual double scale(int player) const = 0; // of a player against the rest figure
};

class BallPath {
public:
  explicit BallPath(const std::array<Place, 2> &places);
  const Timing &timing() const { return times; }
  Vec3 position(double time) const;
  Mat3 rotation(double time) const;

private:
  struct Span { // of one kind of motion
    double start, duration;
    bool flight;
    Vec3 from, velocity_from, to, velocity_to;
    double spin; // radians per second
  };
  const Span &span(double time_in_cycle) const;
  void add_half(const Place &handler, const Place &receiver, double start);
  void fly(double start, double duration, Vec3 from, Vec3 to, double spin);
  void hold(double start, double duration, Vec3 from, Vec3 velocity_from, Vec3 to, Vec3 velocity_to);

  Timing times;
  std::vector<Span> spans;
  Vec3 spin_axis;
};

class Play : public Action {
public:
  // Where they stand, how tall they are and how they sway follow from random.
  explicit Play(Random &random);
  const BallPath &ball() const { return path; }
  double duration() const override { return cycle; }
  Vec3 ball_position(double time) const override { return path.position(time); }
  Mat3 ball_rotation(double time) const override { return path.rotation(time); }
  Posture posture(int player, double time) const override;
  double scale(int player) const override { return manner[size_t(player)].scale; }

private:
  struct Manner {
    double scale, crouch, sway, sway_phase;
  };
  std::array<Place, 2> places;
  std::array<Manner, 2> manner;
  BallPath path;
};

} // namespace fvv::synth
