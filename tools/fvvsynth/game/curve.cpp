#include "fvvsynth/game/curve.h"

#include <cmath>
#include <utility>

namespace fvv::synth {

Curve::Curve(std::vector<Key> through, double repeats)
    : keys(std::move(through)), slopes(keys.size()), period(repeats) {
  solve();
}

Curve::Curve(std::vector<Key> through, Vec3 first_velocity, Vec3 last_velocity)
    : keys(std::move(through)), slopes(keys.size()) {
  slopes.front() = first_velocity;
  slopes.back() = last_velocity;
  solve();
}

// The slopes at which accelerations agree are a diagonally dominant system: each sweep of Gauss and Seidel
// leaves less than a third of the error.
void Curve::solve() {
  constexpr int sweeps = 40;
  const size_t n = keys.size();
  for (int sweep = 0; sweep < sweeps; sweep++)
    for (size_t i = 0; i < n; i++) {
      if (!period && (i == 0 || i + 1 == n)) continue;
      const size_t before = (i + n - 1) % n, after = (i + 1) % n;
      const double h0 = keys[i].time - keys[before].time + (i == 0 ? *period : 0);
      const double h1 = keys[after].time - keys[i].time + (i + 1 == n ? *period : 0);
      const Vec3 bend = (keys[i].value - keys[before].value) * (3 / (h0 * h0)) +
                        (keys[after].value - keys[i].value) * (3 / (h1 * h1));
      slopes[i] =
          (bend - slopes[before] * (1 / h0) - slopes[after] * (1 / h1)) * (1 / (2 * (1 / h0 + 1 / h1)));
    }
}

Vec3 Curve::at(double time) const {
  const size_t n = keys.size();
  if (period) {
    time -= std::floor((time - keys.front().time) / *period) * *period;
  } else {
    if (time <= keys.front().time) return keys.front().value + slopes.front() * (time - keys.front().time);
    if (time >= keys.back().time) return keys.back().value + slopes.back() * (time - keys.back().time);
  }
  size_t i = n - 1;
  while (i > 0 && keys[i].time > time) i--;
  const size_t next = (i + 1) % n;
  const double duration = keys[next].time - keys[i].time + (next == 0 && period ? *period : 0);
  const double u = (time - keys[i].time) / duration, v = 1 - u;
  return keys[i].value * (v * v * (1 + 2 * u)) + slopes[i] * (duration * u * v * v) +
         keys[next].value * (u * u * (1 + 2 * v)) - slopes[next] * (duration * v * u * u);
}

} // namespace fvv::synth
