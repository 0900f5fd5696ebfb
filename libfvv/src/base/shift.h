/* base/shift.h: division by powers of two that rounds down. C leaves the shift of a negative number to the
 * compiler. */
#ifndef FVV_BASE_SHIFT_H
#define FVV_BASE_SHIFT_H

#include <stdint.h>

/* floor(value / 2^bits), bits 0 to 63. */
static inline int64_t fvv_shift_right(int64_t value, int bits) {
  return value < 0 ? ~(~value >> bits) : value >> bits;
}

#endif
