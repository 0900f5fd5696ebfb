// Random numbers and noise that are the same on every machine: integers, and one multiplication for the
// double.
#pragma once

#include "fvv_render/vector.h"

#include <cstdint>

namespace fvv::synth {

using render::Vec3;

// SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014).
class Random {
public:
  explicit Random(uint64_t seed) : state(seed) {}
  uint64_t next();
  double uniform() { return double(next() >> 11) * 0x1p-53; } // [0, 1)
  double between(double low, double high) { return low + (high - low) * uniform(); }
  uint32_t below(uint32_t n) { return uint32_t(uniform() * n); }

private:
  uint64_t state;
};

// Value noise on the integer lattice, smooth, 0..1; key chooses one of 2^32 fields.
double noise(Vec3 p, uint32_t key);
// Three octaves of it, 0..1.
double turbulence(Vec3 p, uint32_t key);
// A number 0..1 for a cell of a pattern.
double cell_value(int32_t x, int32_t y, int32_t z, uint32_t key);

// 0 below low, 1 above high, smooth between.
double smoothstep(double low, double high, double x);

} // namespace fvv::synth
