/* base/checked.h: integer arithmetic that C does not define: sums and products that report overflow, and
 * division by powers of two that rounds down. */
#ifndef FVV_BASE_CHECKED_H
#define FVV_BASE_CHECKED_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* 1 and *result on success, else 0. */
static inline int fvv_add_u64(uint64_t a, uint64_t b, uint64_t *result) {
  *result = a + b;
  return *result >= a;
}
static inline int fvv_multiply_u64(uint64_t a, uint64_t b, uint64_t *result) {
  *result = a * b;
  return !a || *result / a == b;
}
/* The next multiple of 8; size must be below 2^63. */
static inline uint64_t fvv_padded(uint64_t size) {
  return (size + 7) & ~(uint64_t)7;
}

/* floor(value / 2^bits), bits 0 to 63. */
static inline int64_t fvv_shift_right(int64_t value, int bits) {
  return value < 0 ? ~(~value >> bits) : value >> bits;
}

#ifdef __cplusplus
}
#endif
#endif
