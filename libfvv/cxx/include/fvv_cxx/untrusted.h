// What readers of untrusted files share: limits, checked size arithmetic, little-endian numbers.
#pragma once

#include "fvv/types.h"

#include <algorithm>
#include <cstring>

namespace fvv {

// limits NULL: the defaults; fields that the caller's older structure lacks have their defaults.
inline fvv_limits limits_or_default(const fvv_limits *limits) {
  fvv_limits result;
  fvv_limits_default(&result);
  if (limits) {
    std::memcpy(&result, limits, std::min<size_t>(limits->struct_size, sizeof result));
    result.struct_size = sizeof result;
  }
  return result;
}

// Return false on overflow.
inline bool checked_add(uint64_t a, uint64_t b, uint64_t *result) {
  *result = a + b;
  return *result >= a;
}
inline bool checked_multiply(uint64_t a, uint64_t b, uint64_t *result) {
  *result = a * b;
  return !a || *result / a == b;
}

inline uint16_t load_u16(const uint8_t *p) {
  return static_cast<uint16_t>(p[0] | p[1] << 8);
}
inline uint32_t load_u32(const uint8_t *p) {
  return p[0] | uint32_t(p[1]) << 8 | uint32_t(p[2]) << 16 | uint32_t(p[3]) << 24;
}
inline int64_t load_i64(const uint8_t *p) {
  const uint64_t bits = load_u32(p) | uint64_t(load_u32(p + 4)) << 32;
  int64_t value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}
inline void store_u16(uint8_t *p, uint16_t value) {
  for (int i = 0; i < 2; i++) p[i] = static_cast<uint8_t>(value >> (8 * i));
}
inline void store_u32(uint8_t *p, uint32_t value) {
  for (int i = 0; i < 4; i++) p[i] = static_cast<uint8_t>(value >> (8 * i));
}
inline void store_u64(uint8_t *p, uint64_t value) {
  for (int i = 0; i < 8; i++) p[i] = static_cast<uint8_t>(value >> (8 * i));
}
inline void store_f64(uint8_t *p, double value) {
  uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  store_u32(p, static_cast<uint32_t>(bits));
  store_u32(p + 4, static_cast<uint32_t>(bits >> 32));
}

// Reads forward; the first read past the end sets failed, and everything after it returns nothing.
struct Cursor {
  const uint8_t *data;
  size_t size, position = 0;
  bool failed = false;

  // NULL when fewer than count bytes are left.
  const uint8_t *take(size_t count) {
    if (failed || count > size - position) {
      failed = true;
      return nullptr;
    }
    const uint8_t *p = data + position;
    position += count;
    return p;
  }
  // Unsigned LEB128 in its shortest form, below 2^64; otherwise 0.
  uint64_t uleb() {
    uint64_t value = 0;
    for (int shift = 0; shift < 70; shift += 7) {
      const uint8_t *p = take(1);
      if (!p) return 0;
      if ((shift == 63 && *p > 1) || (shift && *p == 0)) break;
      value |= uint64_t(*p & 127) << shift;
      if (*p < 128) return value;
    }
    failed = true;
    return 0;
  }
  // Zigzag: 0 1 2 3 4 ... become 0 -1 1 -2 2 ...
  int64_t zigzag() {
    const uint64_t coded = uleb(), bits = coded >> 1 ^ (coded & 1 ? UINT64_MAX : 0);
    int64_t value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
};

} // namespace fvv
