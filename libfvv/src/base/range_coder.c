#include "base/range_coder.h"

#include "base/memory.h"

void fvv_range_decoder_init(fvv_range_decoder *decoder, const uint8_t *data, size_t size) {
  decoder->next = data;
  decoder->end = size ? data + size : data; /* NULL + 0 is undefined */
  decoder->range = UINT32_MAX;
  decoder->code = 0;
  decoder->missing = 0;
  for (int i = 0; i < 4; i++)
    decoder->code = decoder->code << 8 |
                    (decoder->next < decoder->end ? *decoder->next++ : fvv_range_decoder_missing(decoder));
}

uint32_t fvv_range_decoder_missing(fvv_range_decoder *decoder) {
  if (decoder->missing < UINT32_MAX) decoder->missing++;
  return 0;
}

int fvv_range_decoder_finished(const fvv_range_decoder *decoder) {
  return decoder->next == decoder->end && decoder->missing == FVV_RANGE_IMPLIED;
}

void fvv_range_encoder_init(fvv_range_encoder *encoder, fvv_bytes *bytes) {
  encoder->bytes = bytes;
  encoder->begin = bytes->size;
  encoder->low = 0;
  encoder->range = UINT32_MAX;
  encoder->status = FVV_OK;
}

/* All that is written and low + range stay below 1 as a binary fraction: a carry never leaves the first byte.
 */
static void carry(fvv_range_encoder *e) {
  if (!(e->low >> 32)) return;
  size_t at = e->bytes->size;
  while (at > e->begin && ++e->bytes->data[--at] == 0) {}
  e->low &= UINT32_MAX;
}

static void put_byte(fvv_range_encoder *e) {
  carry(e);
  const uint8_t byte = (uint8_t)(e->low >> 24);
  const fvv_status status = fvv_bytes_append(e->bytes, &byte, 1);
  if (status != FVV_OK) e->status = status;
  e->low = e->low << 8 & UINT32_MAX;
}

static void renew(fvv_range_encoder *e) {
  while (e->range < UINT32_C(1) << 24) {
    e->range <<= 8;
    put_byte(e);
  }
}

void fvv_range_encode(fvv_range_encoder *encoder, fvv_probability *p, int bit) {
  const uint32_t bound = (encoder->range >> FVV_RANGE_BITS) * fvv_probability_of_one(p);
  if (bit) {
    encoder->range = bound;
  } else {
    encoder->low += bound;
    encoder->range -= bound;
  }
  fvv_probability_update(p, bit);
  renew(encoder);
}

void fvv_range_encode_even(fvv_range_encoder *encoder, int bit) {
  encoder->range >>= 1;
  if (!bit) encoder->low += encoder->range;
  renew(encoder);
}

/* A range of 2^24 or more contains a multiple of 2^24: one byte, and three zeros that are not written. */
fvv_status fvv_range_encoder_finish(fvv_range_encoder *encoder) {
  encoder->low = (encoder->low + encoder->range - 1) >> 24 << 24;
  put_byte(encoder);
  return encoder->status;
}
