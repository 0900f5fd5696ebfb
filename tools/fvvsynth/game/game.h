// The action of the scene "game", 10 s that repeat: a player dribbles and passes; the other one catches,
// dribbles past him with a change of hands and shoots; the ball falls through the net, and the first one
// catches it and dribbles on. Metres, seconds, y up; the hoop is at +x.
#pragma once

#include "fvvsynth/body/skeleton.h"
#include "fvvsynth/game/curve.h"
#include "fvvsynth/play.h"
#include "fvvsynth/random.h"

#include <array>
#include <optional>
#include <vector>

namespace fvv::synth {

// The ring that the ball falls through, and the net below it.
constexpr Vec3 ring_centre{1.55, 2.60, 0};
constexpr double ring_radius = 0.225, net_length = 0.42;

class Game : public Action {
public:
  // Heights of the players follow from random.
  explicit Game(Random &random);
  double duration() const override;
  Vec3 ball_position(double time) const override;
  Mat3 ball_rotation(double time) const override;
  Posture posture(int player, double time) const override;
  double scale(int player) const override { return scales[size_t(player)]; }

  // Whether a hand (0 left, 1 right) holds the ball.
  bool holds(int player, int hand, double time) const;
  // Whether a foot carries weight: it is on the floor and does not move.
  bool planted(int player, int foot, double time) const;
  // The moments, within duration(), at which the ball meets the floor, is in the net, and feet land.
  const std::vector<double> &bounces() const { return floor_times; }
  double net_time() const;
  std::vector<double> landings() const;

private:
  struct Foot {
    Vec3 ankle;
    double heading;
    double weight; // 1: on the floor
    double pitch;  // toes down, radians
  };
  // Where a player is, and where he looks: horizontal axes.
  struct Stand {
    Vec3 centre; // on the floor, below the pelvis
    double heading;
    Vec3 left, forward;
  };
  struct Span {
    double start, duration;
    bool flight;
    Vec3 from, velocity; // of a flight
    std::optional<Curve> curve;
    double spin; // radians per second
  };

  Foot foot(int player, int side, double time) const;
  Stand stand(int player, double time) const;
  Vec3 in_front(int player, double time, Vec3 left_up_forward) const;
  void build_ball();
  void fly(double start, double end, Vec3 from, Vec3 to, double spin);
  const Span &span(double &time) const; // time: wrapped into the spans'
  HandGoal hand_goal(int player, int side, double time, const Posture &posture, const Stand &at) const;

  std::array<double, 2> scales;
  std::vector<Span> spans;
  std::vector<double> floor_times;
  double spin_factor = 1;
};

} // namespace fvv::synth
