#include "fvvmux/neighbours.h"

#include "fvvmux/moving.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace fvv::mux {

namespace {

constexpr double same = 1e-6; // cosines, and distances by their ratio: what calibrations are good for

// How far apart two cameras, or the most distant of two sets, are.
struct Apart {
  double turned = 0, distance = 0; // 1 - cosine between the optical axes; between the centres, metres

  bool operator<(const Apart &other) const {
    return std::abs(turned - other.turned) > same ? turned < other.turned
                                                  : distance < (1 - same) * other.distance;
  }
};

Apart apart(const fvv_camera &a, const fvv_camera &b) {
  double cosine = 0, squares = 0;
  for (int i = 0; i < 3; i++) {
    double gap = 0; // of the centres: -R^T t
    for (int k = 0; k < 3; k++)
      gap += b.rotation[3 * k + i] * b.translation[k] - a.rotation[3 * k + i] * a.translation[k];
    cosine += a.rotation[6 + i] * b.rotation[6 + i]; // the third rows: the optical axes
    squares += gap * gap;
  }
  return {1 - cosine, std::sqrt(squares)};
}

} // namespace

std::vector<std::vector<size_t>> neighbours(const capture::Capture &capture,
                                            const std::vector<size_t> &cameras, size_t count) {
  std::vector<fvv_camera> seen;
  std::vector<std::vector<size_t>> sets;
  for (const size_t index : cameras) {
    sets.push_back({seen.size()});
    seen.push_back(described(capture, capture.cameras[index]));
  }
  const auto between = [&](const std::vector<size_t> &a, const std::vector<size_t> &b) {
    Apart most;
    for (const size_t i : a)
      for (const size_t k : b) most = std::max(most, apart(seen[i], seen[k]));
    return most;
  };
  while (sets.size() > std::max<size_t>(count, 1)) {
    std::pair<size_t, size_t> nearest = {0, 1};
    Apart least = between(sets[0], sets[1]);
    for (size_t i = 0; i < sets.size(); i++)
      for (size_t k = i + 1; k < sets.size(); k++) {
        const Apart found = between(sets[i], sets[k]);
        if (found < least) std::tie(least, nearest) = std::make_tuple(found, std::make_pair(i, k));
      }
    std::vector<size_t> &set = sets[nearest.first], &other = sets[nearest.second];
    set.insert(set.end(), other.begin(), other.end());
    std::sort(set.begin(), set.end());
    sets.erase(sets.begin() + std::ptrdiff_t(nearest.second));
  }
  return sets;
}

} // namespace fvv::mux
