#include "mux/src/realtime/pace.h"

#include <algorithm>

namespace fvv::mux {

namespace {

// Above it a group more often waits for the one before, and the next frames are read more slowly.
constexpr double most_load = 0.85;
// Below it the step above keeps up: the steps differ by less than half.
constexpr double easy_load = 0.5;
constexpr int most_patience = 64; // groups, half a minute

} // namespace

void Pace::add(double taken, double covered, double waited) {
  last_load = covered > 0 ? taken / covered : 0;
  const bool behind = last_load > most_load || waited > covered;
  since_raised++;
  if (behind) {
    easy = 0;
    if (raised && since_raised <= enough) enough = std::min(2 * enough, most_patience);
    raised = false;
    current = std::min(current + 1, lowest);
    return;
  }
  easy = last_load < easy_load && waited < covered / 2 ? easy + 1 : 0;
  if (easy < enough || !current) return;
  easy = 0;
  current--;
  raised = true;
  since_raised = 0;
}

} // namespace fvv::mux
