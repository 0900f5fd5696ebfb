#include "fvvsynth/random.h"

#include <algorithm>
#include <cmath>

namespace fvv::synth {

uint64_t Random::next() {
  uint64_t z = state += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

double cell_value(int32_t x, int32_t y, int32_t z, uint32_t key) {
  uint32_t h =
      uint32_t(x) * 0x8da6b343u ^ uint32_t(y) * 0xd8163841u ^ uint32_t(z) * 0xcb1ab31fu ^ key * 0x9e3779b9u;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return double(h ^ (h >> 15)) * 0x1p-32;
}

double noise(Vec3 p, uint32_t key) {
  const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const int32_t x = int32_t(fx), y = int32_t(fy), z = int32_t(fz);
  const auto fade = [](double t) { return t * t * (3 - 2 * t); };
  const double u = fade(p.x - fx), v = fade(p.y - fy), w = fade(p.z - fz);
  const auto row = [&](int32_t j, int32_t k) {
    const double a = cell_value(x, y + j, z + k, key), b = cell_value(x + 1, y + j, z + k, key);
    return a + (b - a) * u;
  };
  const double near_side = row(0, 0) + (row(1, 0) - row(0, 0)) * v;
  const double far_side = row(0, 1) + (row(1, 1) - row(0, 1)) * v;
  return near_side + (far_side - near_side) * w;
}

double turbulence(Vec3 p, uint32_t key) {
  return (4 * noise(p, key) + 2 * noise(p * 2.03, key + 1) + noise(p * 4.11, key + 2)) / 7;
}

double smoothstep(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

} // namespace fvv::synth
