#include "fvv_media/srgb.h"

#include <cmath>
#include <cstring>

namespace fvv::media {
namespace {

float float_of(uint32_t bits) {
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

/* Whether the curve at x (not negative) is at least (2 code - 1) / (2 largest). */
bool reaches(double x, uint32_t code, uint32_t largest) {
  const double odd = 2.0 * code - 1, both = 2.0 * largest;
  // 12.92 x up to 0.04045: 12.92 = 323 / 25, and all of this is exact.
  if (odd <= 0.04045 * both) return x * 323 * both >= odd * 25;
  // ((v + 0.055) / 1.055)^2.4 behind it.
  const double root = (odd * 1000 + both * 55) / (both * 1055);
  const double square = root * root, fourth = square * square;
  return x * x * x * x * x >= fourth * fourth * fourth;
}

} // namespace

std::vector<float> srgb_thresholds(uint32_t largest) {
  constexpr uint32_t one = 0x3f800000; // bits of 1.0f; those of positive floats are in their order
  std::vector<float> thresholds;
  thresholds.reserve(largest);
  uint32_t below = 0;
  for (uint32_t code = 1; code <= largest; code++) {
    uint32_t reached = one;
    while (reached - below > 1) {
      const uint32_t middle = below + (reached - below) / 2;
      (reaches(double(float_of(middle)), code, largest) ? reached : below) = middle;
    }
    thresholds.push_back(float_of(reached));
    below = reached - 1; // the next threshold may be the same float, were codes that fine
  }
  return thresholds;
}

std::vector<float> linear_of_codes(uint32_t largest) {
  std::vector<float> values;
  values.reserve(size_t(largest) + 1);
  for (uint32_t code = 0; code <= largest; code++) {
    const double v = double(code) / largest;
    if (v <= 0.04045) {
      values.push_back(float(v / 12.92));
      continue;
    }
    // x^5 = root^12 by Newton's method, from above.
    const double root = (v + 0.055) / 1.055, square = root * root, fourth = square * square;
    const double twelfth = fourth * fourth * fourth;
    double x = 1;
    for (;;) {
      const double x4 = x * x * x * x, next = x - (x4 * x - twelfth) / (5 * x4);
      if (!(next < x)) break;
      x = next;
    }
    values.push_back(float(x));
  }
  return values;
}

double srgb_of_linear(double linear) {
  const double x = std::fabs(linear);
  const double v = x <= 0.0031308 ? x * 12.92 : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return std::copysign(v, linear);
}

double linear_of_srgb(double display) {
  const double v = std::fabs(display);
  const double x = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  return std::copysign(x, display);
}

} // namespace fvv::media
