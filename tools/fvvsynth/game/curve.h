// Smooth curves through keys: cubic splines with continuous acceleration.
#pragma once

#include "fvv_render/vector.h"

#include <optional>
#include <vector>

namespace fvv::synth {

using render::Vec3;

class Curve {
public:
  struct Key {
    double time; // seconds, rising
    Vec3 value;
  };
  // Closed: the value repeats after period seconds. At least two keys.
  Curve(std::vector<Key> keys, double period);
  // From the first key to the last, with these velocities there; constant velocity outside.
  Curve(std::vector<Key> keys, Vec3 first_velocity, Vec3 last_velocity);
  Vec3 at(double time) const;

private:
  void solve();

  std::vector<Key> keys;
  std::vector<Vec3> slopes;
  std::optional<double> period;
};

} // namespace fvv::synth
