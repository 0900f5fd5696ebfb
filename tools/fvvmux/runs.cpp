#include "fvvmux/runs.h"

#include <algorithm>

namespace fvv::mux {

namespace {

// Runs filled to most from the front, each leaving one weight at least for every run behind it; the last one
// takes what is left.
std::vector<size_t> filled(const std::vector<uint64_t> &weights, size_t count, uint64_t most) {
  std::vector<size_t> ends;
  size_t at = 0;
  for (size_t run = 0; run < count; run++) {
    const size_t last = weights.size() - (count - 1 - run); // one past what it may take
    uint64_t sum = weights[at++];
    while (at < last && sum + weights[at] <= most) sum += weights[at++];
    ends.push_back(at);
  }
  return ends;
}

} // namespace

std::vector<size_t> balanced_runs(const std::vector<uint64_t> &weights, size_t count) {
  uint64_t low = *std::max_element(weights.begin(), weights.end()), high = 0;
  for (const uint64_t weight : weights) high += weight;
  while (low < high) {
    const uint64_t middle = low + (high - low) / 2;
    if (filled(weights, count, middle).back() == weights.size())
      high = middle;
    else
      low = middle + 1;
  }
  return filled(weights, count, high);
}

} // namespace fvv::mux
