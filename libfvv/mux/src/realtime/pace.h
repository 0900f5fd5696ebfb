// Whether a stream keeps up with its frames, by what its groups took, and which effort it can afford.
#pragma once

#include <cstddef>

namespace fvv::mux {

class Pace {
public:
  // steps: of effort; 0 is the most.
  explicit Pace(size_t steps) : lowest(steps - 1) {}

  // After each group. Seconds: that encoding and writing took, that its frames cover, and that its last frame
  // waited before.
  void add(double taken, double covered, double waited);
  size_t step() const { return current; }
  double load() const { return last_load; } // of the last group; 1: as fast as frames come

private:
  const size_t lowest;
  size_t current = 0;
  double last_load = 0;
  int easy = 0;         // groups in a row that leave room for more
  int enough = 4;       // of these before effort rises; more after each rise that was too early
  int since_raised = 0; // groups
  bool raised = false;
};

} // namespace fvv::mux
