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

namespace {

uint32_t cell_bits(uint32_t x, uint32_t y, uint32_t z, uint32_t key) {
  uint32_t h = x * 0x8da6b343u ^ y * 0xd8163841u ^ z * 0xcb1ab31fu ^ key * 0x9e3779b9u;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return h ^ (h >> 15);
}

double unit(uint32_t bits) {
  return double(bits) * 0x1p-32;
}

} // namespace

double cell_value(int32_t x, int32_t y, int32_t z, uint32_t key) {
  return unit(cell_bits(uint32_t(x), uint32_t(y), uint32_t(z), key));
}

namespace {

// The values at the corners of a cell of the lattice. Those used lately are kept: the samples of a pixel
// mostly lie in the same cell.
struct Cell {
  int32_t x, y, z;
  uint32_t key;
  bool known;
  uint32_t corners[8]; // x changes first
};

const Cell &cell_at(int32_t x, int32_t y, int32_t z, uint32_t key) {
  constexpr int bits = 10;
  static thread_local Cell recent[1 << bits];
  const uint32_t hash =
      (uint32_t(x) * 0x9e3779b1u ^ uint32_t(y) * 0x85ebca77u ^ uint32_t(z) * 0xc2b2ae3du ^ key) * 0x27d4eb2fu;
  Cell &cell = recent[hash >> (32 - bits)];
  if (cell.known && cell.x == x && cell.y == y && cell.z == z && cell.key == key) return cell;
  cell = {x, y, z, key, true, {}};
  for (uint32_t i = 0; i < 8; i++)
    cell.corners[i] =
        cell_bits(uint32_t(x) + (i & 1), uint32_t(y) + (i >> 1 & 1), uint32_t(z) + (i >> 2), key);
  return cell;
}

// Not std::floor: without SSE4.1 it is a call of a function.
int32_t whole_below(double at) {
  const int32_t whole = int32_t(at);
  return double(whole) > at ? whole - 1 : whole;
}

} // namespace

double noise(Vec3 p, uint32_t key) {
  const int32_t x = whole_below(p.x), y = whole_below(p.y), z = whole_below(p.z);
  const auto fade = [](double t) { return t * t * (3 - 2 * t); };
  const double u = fade(p.x - x), v = fade(p.y - y), w = fade(p.z - z);
  const Cell &cell = cell_at(x, y, z, key);
  const auto row = [&](int j, int k) {
    const uint32_t *corner = cell.corners + 2 * j + 4 * k;
    const double a = unit(corner[0]), b = unit(corner[1]);
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
