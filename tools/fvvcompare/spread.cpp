#include "fvvcompare/spread.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace fvv::compare {

namespace {

constexpr int dropped_bits = 52 - 10;

} // namespace

void Histogram::add(double value) {
  uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  bins[uint32_t(bits >> dropped_bits)]++;
  total++;
}

void Histogram::add(const Histogram &other) {
  for (const auto &[bin, count] : other.bins) bins[bin] += count;
  total += other.total;
}

double Histogram::quantile(double share) const {
  const uint64_t rank = std::max<uint64_t>(1, uint64_t(std::ceil(share * double(total))));
  uint64_t seen = 0;
  for (const auto &[bin, count] : bins)
    if ((seen += count) >= rank) {
      const uint64_t bits = uint64_t(bin) << dropped_bits;
      double value;
      std::memcpy(&value, &bits, sizeof value);
      return value;
    }
  return 0;
}

void Spread::add(double value) {
  sum += value;
  squares += value * value;
  largest = std::max(largest, value);
  bins.add(value);
}

Figures Spread::figures() const {
  const double n = double(bins.count());
  if (n == 0) return {};
  return {std::sqrt(squares / n), sum / n, bins.quantile(0.99), largest};
}

} // namespace fvv::compare
