/* base/range_coder.h: adaptive binary range coder. Decisions in, bytes out, and back; exact integers on every
 * machine (clause 2.4).
 *
 * Sources: G. N. N. Martin, "Range encoding" (1979); the 32-bit range with late carry is that of LZMA (Igor
 * Pavlov, LZMA specification); the mean of a fast and a slow estimate is M. Mahoney's, and that of AV1 and
 * VVC. */
#ifndef FVV_BASE_RANGE_CODER_H
#define FVV_BASE_RANGE_CODER_H

#include <stddef.h>
#include <stdint.h>

#include "fvv/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How probable a 1 is in one context: two estimates in 2^-16, one that follows fast and one that follows
 * slowly. Neither ever reaches 0 or 2^16: they stay within 15 and 65521. */
typedef struct fvv_probability {
  uint16_t fast, slow;
} fvv_probability;

enum {
  FVV_RANGE_FAST = 4, /* an estimate moves by 2^-4 of the way to what was seen */
  FVV_RANGE_SLOW = 7,
  FVV_RANGE_BITS = 12,  /* precision of the probability that divides the range */
  FVV_RANGE_IMPLIED = 3 /* zero bytes that an encoder leaves out at the end */
};

/* Even odds. */
static inline void fvv_probability_reset(fvv_probability *p) {
  p->fast = p->slow = 1 << 15;
}
/* Of a 1, in 2^-12: 4 to 4091. */
static inline uint32_t fvv_probability_of_one(const fvv_probability *p) {
  return ((uint32_t)p->fast + p->slow) >> (17 - FVV_RANGE_BITS);
}
static inline void fvv_probability_update(fvv_probability *p, int bit) {
  if (bit) {
    p->fast = (uint16_t)(p->fast + ((65536u - p->fast) >> FVV_RANGE_FAST));
    p->slow = (uint16_t)(p->slow + ((65536u - p->slow) >> FVV_RANGE_SLOW));
  } else {
    p->fast = (uint16_t)(p->fast - (p->fast >> FVV_RANGE_FAST));
    p->slow = (uint16_t)(p->slow - (p->slow >> FVV_RANGE_SLOW));
  }
}

/* ---- decoder -------------------------------------------------------------------------------------- */

/* Never reads beyond its block: it takes zeros there and counts them. */
typedef struct fvv_range_decoder {
  const uint8_t *next, *end;
  uint32_t range, code;
  uint32_t missing; /* zeros taken beyond the end, counted up to 2^32 - 1 */
} fvv_range_decoder;

void fvv_range_decoder_init(fvv_range_decoder *decoder, const uint8_t *data, size_t size);

/* The next byte, or a counted zero. Out of line: it is the rare case. */
uint32_t fvv_range_decoder_missing(fvv_range_decoder *decoder);

static inline void fvv_range_decoder_renew(fvv_range_decoder *d) {
  while (d->range < UINT32_C(1) << 24) {
    d->range <<= 8;
    d->code = d->code << 8 | (d->next < d->end ? *d->next++ : fvv_range_decoder_missing(d));
  }
}

/* Returns 0 or 1 and adapts p to it. */
static inline int fvv_range_decode(fvv_range_decoder *d, fvv_probability *p) {
  const uint32_t bound = (d->range >> FVV_RANGE_BITS) * fvv_probability_of_one(p);
  const int bit = d->code < bound;
  if (bit) {
    d->range = bound;
  } else {
    d->code -= bound;
    d->range -= bound;
  }
  fvv_probability_update(p, bit);
  fvv_range_decoder_renew(d);
  return bit;
}

/* A decision of even odds, one bit of the stream. */
static inline int fvv_range_decode_even(fvv_range_decoder *d) {
  d->range >>= 1;
  const int bit = d->code < d->range;
  if (!bit) d->code -= d->range;
  fvv_range_decoder_renew(d);
  return bit;
}

/* 1 once more zeros were taken than an encoder leaves out: what was decoded since is invalid. */
static inline int fvv_range_decoder_failed(const fvv_range_decoder *d) {
  return d->missing > FVV_RANGE_IMPLIED;
}

/* 1 when the decoder has read all bytes and exactly the implied zeros after them. Valid after the
 * last decision. */
int fvv_range_decoder_finished(const fvv_range_decoder *decoder);

/* ---- encoder -------------------------------------------------------------------------------------- */

/* Appends to bytes, which the caller owns. A failed allocation is kept and reported by finish. */
typedef struct fvv_range_encoder {
  fvv_bytes *bytes;
  size_t begin; /* bytes->size at init */
  uint64_t low; /* 33 bits: bit 32 is a carry that has not yet reached the bytes */
  uint32_t range;
  fvv_status status;
} fvv_range_encoder;

void fvv_range_encoder_init(fvv_range_encoder *encoder, fvv_bytes *bytes);
void fvv_range_encode(fvv_range_encoder *encoder, fvv_probability *p, int bit);
void fvv_range_encode_even(fvv_range_encoder *encoder, int bit);
/* Appends the last byte. FVV_OK or FVV_ERROR_MEMORY. */
FVV_MUST_USE fvv_status fvv_range_encoder_finish(fvv_range_encoder *encoder);

#ifdef __cplusplus
}
#endif
#endif
