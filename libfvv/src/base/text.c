#include "base/text.h"

#include "base/diagnostic.h"

/* Bytes of the sequence at p, 0 when it is ill-formed. */
static size_t sequence(const uint8_t *p, size_t left) {
  const uint8_t c = p[0];
  if (c < 0x80) return c != 0;
  const size_t length = c >= 0xc2 && c <= 0xdf ? 2 : (c & 0xf0) == 0xe0 ? 3 : c >= 0xf0 && c <= 0xf4 ? 4 : 0;
  if (!length || length > left) return 0;
  /* The second byte keeps overlong forms, surrogates and what is beyond U+10FFFF out. */
  const uint8_t low = c == 0xe0 ? 0xa0 : c == 0xf0 ? 0x90 : 0x80;
  const uint8_t high = c == 0xed ? 0x9f : c == 0xf4 ? 0x8f : 0xbf;
  if (p[1] < low || p[1] > high) return 0;
  for (size_t i = 2; i < length; i++)
    if ((p[i] & 0xc0) != 0x80) return 0;
  return length;
}

int fvv_text_valid(const uint8_t *text, size_t size, size_t *bad) {
  for (size_t i = 0; i < size;) {
    const size_t length = sequence(text + i, size - i);
    if (!length) {
      if (bad) *bad = i;
      return 0;
    }
    i += length;
  }
  return 1;
}

fvv_status fvv_text_check(const char *text, size_t size, const char *what, fvv_status status, uint32_t type,
                          uint64_t offset, fvv_diagnostic *diagnostic) {
  size_t bad = 0;
  if (!size || fvv_text_valid((const uint8_t *)text, size, &bad)) return FVV_OK;
  return fvv_fail(diagnostic, status, FVV_ISSUE_TEXT, type, offset + bad,
                  "%s is not UTF-8 without NUL at its byte %zu", what, bad);
}
