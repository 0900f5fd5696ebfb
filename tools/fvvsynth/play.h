// What the two players do: a closed cycle of dribbling, stepping, passing and catching, from keyed values and
// the path of the ball. Knows skeletons and the ball; knows no meshes and no pictures.
#pragma once

#include "fvvsynth/ball_path.h"
#include "fvvsynth/random.h"
#include "fvvsynth/skeleton.h"

namespace fvv::synth {

class Play {
public:
  // Where they stand, how tall they are and how they sway follow from random.
  explicit Play(Random &random);
  const BallPath &ball() const { return path; }
  // Of player 0 or 1 at a time in seconds, any.
  Posture posture(int player, double time) const;
  double scale(int player) const { return manner[size_t(player)].scale; }

private:
  struct Manner {
    double scale, crouch, sway, sway_phase;
  };
  std::array<Place, 2> places;
  std::array<Manner, 2> manner;
  BallPath path;
};

} // namespace fvv::synth
