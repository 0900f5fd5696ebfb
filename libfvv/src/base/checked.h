/* base/checked.h: size arithmetic that says when it overflows, in 64 bits on every platform. */
#ifndef FVV_BASE_CHECKED_H
#define FVV_BASE_CHECKED_H

#include <stdint.h>

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

#endif
