/* What has to be known about Draco's entropy coding to find the end of a coded part. Raw symbols say their
 * size; tagged ones do not: a rANS-coded tag for each tuple says how many bits each of its values has, so the
 * tags are decoded and added up. Nothing is allocated. */
#include "mesh/draco_symbols.h"

/* Raw symbols are below 2^18 in every stream of Draco's encoder; the tags are numbers of bits, 0 to 32.
 * Draco's decoder checks neither and would hold 768 bytes for each byte of such a table. */
#define RAW_ALPHABET_MAX ((uint64_t)1 << 18)
#define TAG_ALPHABET_MAX 33

/* Probabilities of tags and of edgebreaker symbols have 12 bits, the least that Draco uses. */
#define SMALL_PRECISION_BITS 12
#define SMALL_PRECISION (1u << SMALL_PRECISION_BITS)

static int fail(fvv_cursor *cursor) {
  cursor->failed = 1;
  return 0;
}

int fvv_draco_skip_bits(fvv_cursor *cursor) {
  fvv_cursor_take(cursor, 1); /* probability of a zero */
  const uint64_t size = fvv_cursor_uleb(cursor);
  if (!size || size > SIZE_MAX) return fail(cursor);
  return fvv_cursor_take(cursor, (size_t)size) != NULL;
}

/* Reads a probability table; probabilities, when not NULL, has room for most entries. The two low bits of an
 * entry's first byte count the bytes that follow, 3 says that the other six count further zeros. */
static int read_alphabet(fvv_cursor *cursor, uint64_t most, uint32_t precision, uint32_t *probabilities) {
  const uint64_t count = fvv_cursor_uleb(cursor);
  if (!count || count > most) return fail(cursor);
  uint64_t sum = 0;
  for (uint64_t i = 0; i < count; i++) {
    const uint8_t *first = fvv_cursor_take(cursor, 1);
    if (!first) return 0;
    const unsigned token = *first & 3;
    uint32_t value = *first >> 2;
    if (token == 3) {
      if (value >= count - i) return fail(cursor);
      i += value;
      continue;
    }
    for (unsigned b = 0; b < token; b++) {
      const uint8_t *more = fvv_cursor_take(cursor, 1);
      if (!more) return 0;
      value |= (uint32_t)*more << (8 * (b + 1) - 2);
    }
    sum += value;
    if (probabilities) probabilities[i] = value;
  }
  return sum == precision || fail(cursor);
}

/* rANS, read from the back (J. Duda, arXiv:1311.2540). */
typedef struct rans {
  const uint8_t *bytes;
  size_t left;
  uint32_t state;
} rans;

/* The two high bits of the last byte say in how many bytes the initial state lies. */
static int open_rans(fvv_cursor *cursor, unsigned precision_bits, rans *coder) {
  const uint64_t size = fvv_cursor_uleb(cursor);
  if (!size || size > SIZE_MAX) return fail(cursor);
  const uint8_t *bytes = fvv_cursor_take(cursor, (size_t)size);
  if (!bytes) return 0;
  const unsigned length = (bytes[size - 1] >> 6) + 1u;
  if (size < length) return fail(cursor);
  uint32_t state = bytes[size - 1] & 63;
  for (unsigned i = 2; i <= length; i++) state = state << 8 | bytes[size - i];
  const uint32_t base = 4u << precision_bits;
  coder->bytes = bytes;
  coder->left = (size_t)size - length;
  coder->state = state + base;
  return coder->state < base << 8 || fail(cursor);
}

/* A coder of tags or edgebreaker symbols with its tables. */
typedef struct small_coder {
  rans input;
  uint32_t probability[TAG_ALPHABET_MAX];
  uint32_t start[TAG_ALPHABET_MAX];
  uint8_t value_at[SMALL_PRECISION];
} small_coder;

static int open_small(fvv_cursor *cursor, uint64_t alphabet, small_coder *coder) {
  memset(coder, 0, sizeof *coder);
  if (!read_alphabet(cursor, alphabet, SMALL_PRECISION, coder->probability)) return 0;
  uint32_t sum = 0;
  for (unsigned value = 0; value < TAG_ALPHABET_MAX; value++) {
    coder->start[value] = sum;
    memset(coder->value_at + sum, (int)value, coder->probability[value]);
    sum += coder->probability[value];
  }
  return open_rans(cursor, SMALL_PRECISION_BITS, &coder->input);
}

static unsigned next_small(small_coder *coder) {
  rans *input = &coder->input;
  while (input->state < 4 * SMALL_PRECISION && input->left)
    input->state = input->state << 8 | input->bytes[--input->left];
  const uint32_t rest = input->state % SMALL_PRECISION;
  const unsigned value = coder->value_at[rest];
  input->state = input->state / SMALL_PRECISION * coder->probability[value] + rest - coder->start[value];
  return value;
}

static int skip_tagged(fvv_cursor *cursor, uint64_t count, uint32_t components) {
  small_coder tags;
  if (!open_small(cursor, TAG_ALPHABET_MAX, &tags)) return 0;
  uint64_t bits = 0;
  for (uint64_t i = 0; i < count / components; i++) bits += (uint64_t)components * next_small(&tags);
  const uint64_t size = bits / 8 + (bits % 8 != 0);
  if (size > SIZE_MAX) return fail(cursor);
  return fvv_cursor_take(cursor, (size_t)size) != NULL;
}

/* Raw symbols begin with a number of bits, which decides the precision; 0 when it is out of range. */
static unsigned read_precision(fvv_cursor *cursor) {
  const uint8_t *bits = fvv_cursor_take(cursor, 1);
  if (!bits) return 0;
  if (*bits < 1 || *bits > 18) {
    cursor->failed = 1;
    return 0;
  }
  const unsigned wanted = 3u * *bits / 2;
  return wanted < SMALL_PRECISION_BITS ? SMALL_PRECISION_BITS : wanted > 20 ? 20 : wanted;
}

static int skip_raw(fvv_cursor *cursor) {
  const unsigned precision_bits = read_precision(cursor);
  if (!precision_bits) return 0;
  rans coder;
  return read_alphabet(cursor, RAW_ALPHABET_MAX, 1u << precision_bits, NULL) &&
         open_rans(cursor, precision_bits, &coder);
}

int fvv_draco_skip_symbols(fvv_cursor *cursor, uint64_t count, uint32_t components) {
  if (!count) return 1;
  const uint8_t *scheme = fvv_cursor_take(cursor, 1);
  if (!scheme) return 0;
  switch (*scheme) {
  case 0:
    return skip_tagged(cursor, count, components);
  case 1:
    return skip_raw(cursor);
  default:
    return fail(cursor);
  }
}

/* Bits from the low end of each byte on; 0 behind the end, where position goes on counting. */
typedef struct bit_reader {
  const uint8_t *bytes;
  uint64_t size;
  uint64_t position;
} bit_reader;

static unsigned read_bits(bit_reader *reader, unsigned count) {
  unsigned value = 0;
  for (unsigned i = 0; i < count; i++, reader->position++)
    if (reader->position / 8 < reader->size)
      value |= (unsigned)(reader->bytes[reader->position / 8] >> (reader->position % 8) & 1) << i;
  return value;
}

static int read_tagged(fvv_cursor *cursor, uint32_t count, uint8_t *symbols) {
  small_coder tags;
  /* Five symbols have at most three bits. */
  if (!open_small(cursor, 4, &tags)) return 0;
  bit_reader reader = {cursor->data + cursor->position, cursor->size - cursor->position, 0};
  for (uint32_t i = 0; i < count; i++) {
    symbols[i] = (uint8_t)read_bits(&reader, next_small(&tags));
    if (symbols[i] >= FVV_DRACO_SYMBOLS) return fail(cursor);
  }
  const uint64_t size = (reader.position + 7) / 8;
  if (size > reader.size) return fail(cursor);
  return fvv_cursor_take(cursor, (size_t)size) != NULL;
}

static int read_raw(fvv_cursor *cursor, uint32_t count, uint8_t *symbols) {
  small_coder coder;
  if (read_precision(cursor) != SMALL_PRECISION_BITS) return fail(cursor);
  if (!open_small(cursor, FVV_DRACO_SYMBOLS, &coder)) return 0;
  for (uint32_t i = 0; i < count; i++) symbols[i] = (uint8_t)next_small(&coder);
  return 1;
}

int fvv_draco_read_symbols(fvv_cursor *cursor, uint32_t count, uint8_t *symbols) {
  if (!count) return 1;
  const uint8_t *scheme = fvv_cursor_take(cursor, 1);
  if (!scheme) return 0;
  switch (*scheme) {
  case 0:
    return read_tagged(cursor, count, symbols);
  case 1:
    return read_raw(cursor, count, symbols);
  default:
    return fail(cursor);
  }
}

int fvv_draco_read_standard(fvv_cursor *cursor, uint32_t count, uint8_t *symbols) {
  const uint64_t size = fvv_cursor_uleb(cursor);
  const uint8_t *bytes = size > SIZE_MAX ? NULL : fvv_cursor_take(cursor, (size_t)size);
  if (!bytes) return fail(cursor);
  bit_reader reader = {bytes, size, 0};
  /* Draco reads zeros, which are C, behind the end: symbols for which nobody paid. */
  for (uint32_t i = 0; i < count; i++) {
    if (reader.position >= 8 * size) return fail(cursor);
    symbols[i] = (uint8_t)(read_bits(&reader, 1) ? FVV_DRACO_S + read_bits(&reader, 2) : FVV_DRACO_C);
  }
  return (reader.position + 7) / 8 == size || fail(cursor);
}
