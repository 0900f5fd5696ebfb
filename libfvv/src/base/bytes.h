/* base/bytes.h: little-endian numbers at unaligned places, and a cursor that never reads past its end. */
#ifndef FVV_BASE_BYTES_H
#define FVV_BASE_BYTES_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Shifts, not casts: compilers turn them into one load or store, and big-endian machines get the same bytes.
 */
static inline uint16_t fvv_get_u16(const uint8_t *p) {
  return (uint16_t)(p[0] | p[1] << 8);
}
static inline uint32_t fvv_get_u32(const uint8_t *p) {
  return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}
static inline uint64_t fvv_get_u64(const uint8_t *p) {
  return fvv_get_u32(p) | (uint64_t)fvv_get_u32(p + 4) << 32;
}
static inline int64_t fvv_get_i64(const uint8_t *p) {
  const uint64_t u = fvv_get_u64(p);
  int64_t value;
  memcpy(&value, &u, sizeof value);
  return value;
}
static inline double fvv_get_f64(const uint8_t *p) {
  const uint64_t u = fvv_get_u64(p);
  double value;
  memcpy(&value, &u, sizeof value);
  return value;
}

static inline void fvv_put_u16(uint8_t *p, uint16_t v) {
  p[0] = (uint8_t)v;
  p[1] = (uint8_t)(v >> 8);
}
static inline void fvv_put_u32(uint8_t *p, uint32_t v) {
  for (int i = 0; i < 4; i++) p[i] = (uint8_t)(v >> (8 * i));
}
static inline void fvv_put_u64(uint8_t *p, uint64_t v) {
  for (int i = 0; i < 8; i++) p[i] = (uint8_t)(v >> (8 * i));
}
static inline void fvv_put_i64(uint8_t *p, int64_t v) {
  fvv_put_u64(p, (uint64_t)v);
}
static inline void fvv_put_f64(uint8_t *p, double v) {
  uint64_t u;
  memcpy(&u, &v, sizeof u);
  fvv_put_u64(p, u);
}

static inline int fvv_all_zero(const uint8_t *p, size_t size) {
  for (size_t i = 0; i < size; i++)
    if (p[i]) return 0;
  return 1;
}

/* Unsigned LEB128, at most 10 bytes, shortest form. Returns the bytes written. */
static inline size_t fvv_put_uleb(uint8_t *p, uint64_t v) {
  size_t n = 0;
  do {
    p[n] = (uint8_t)((v & 127) | (v > 127 ? 128 : 0));
    n++;
  } while (v >>= 7);
  return n;
}

/* Zigzag: 0 -1 1 -2 2 ... become 0 1 2 3 4 ... */
static inline uint64_t fvv_zigzag(int64_t v) {
  return (uint64_t)v << 1 ^ (v < 0 ? UINT64_MAX : 0);
}
static inline int64_t fvv_unzigzag(uint64_t u) {
  const uint64_t v = u >> 1 ^ (u & 1 ? UINT64_MAX : 0);
  int64_t value;
  memcpy(&value, &v, sizeof value);
  return value;
}

/* Reads forward; the first read past the end sets failed, and everything after it yields 0. */
typedef struct fvv_cursor {
  const uint8_t *data;
  size_t size, position;
  int failed;
} fvv_cursor;

static inline const uint8_t *fvv_cursor_take(fvv_cursor *cursor, size_t size) {
  if (cursor->failed || size > cursor->size - cursor->position) {
    cursor->failed = 1;
    return NULL;
  }
  const uint8_t *p = cursor->data + cursor->position;
  cursor->position += size;
  return p;
}
/* Only the shortest form of numbers below 2^64 is accepted. */
static inline uint64_t fvv_cursor_uleb(fvv_cursor *cursor) {
  uint64_t value = 0;
  for (int shift = 0; shift < 70; shift += 7) {
    const uint8_t *p = fvv_cursor_take(cursor, 1);
    if (!p) return 0;
    if ((shift == 63 && *p > 1) || (shift && *p == 0)) break;
    value |= (uint64_t)(*p & 127) << shift;
    if (*p < 128) return value;
  }
  cursor->failed = 1;
  return 0;
}

#endif
