// fvvcompare/spread.h: how values of 0 or more are spread: means exactly, quantiles to a thousandth. Knows
// numbers only.
#pragma once

#include <cstdint>
#include <map>

namespace fvv::compare {

struct Figures {
  double rms = 0, mean = 0, p99 = 0, max = 0;
};

// Counts in bins whose width is at most 2^-10 of their values (the first bits of a double), so that those of
// many frames can be added in any order and kept in little memory.
class Histogram {
public:
  void add(double value); // 0 or more, finite
  void add(const Histogram &other);
  uint64_t count() const { return total; }
  // The smallest value that is not below a share of all (nearest rank), or up to 2^-10 of it less: the lower
  // bound of its bin. 0 when there are none.
  double quantile(double share) const;

private:
  std::map<uint32_t, uint64_t> bins;
  uint64_t total = 0;
};

class Spread {
public:
  void add(double value);  // 0 or more, finite
  Figures figures() const; // all 0 without values
  const Histogram &histogram() const { return bins; }

private:
  double sum = 0, squares = 0, largest = 0;
  Histogram bins;
};

} // namespace fvv::compare
