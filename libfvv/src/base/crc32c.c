#include "base/crc32c.h"

#include "base/bytes.h"
#include "base/crc32c_table.h"
#include "fvv/types.h"

uint32_t fvv_crc32c_portable(uint32_t crc, const void *bytes, size_t size) {
  const uint8_t *p = bytes;
  crc = ~crc;
  for (; size >= 8; p += 8, size -= 8) {
    const uint32_t low = fvv_get_u32(p) ^ crc, high = fvv_get_u32(p + 4);
    crc = crc_table[7][low & 255] ^ crc_table[6][low >> 8 & 255] ^ crc_table[5][low >> 16 & 255] ^
          crc_table[4][low >> 24] ^ crc_table[3][high & 255] ^ crc_table[2][high >> 8 & 255] ^
          crc_table[1][high >> 16 & 255] ^ crc_table[0][high >> 24];
  }
  for (; size; p++, size--) crc = crc >> 8 ^ crc_table[0][(crc ^ *p) & 255];
  return ~crc;
}

#if defined(__x86_64__) && defined(__GNUC__)
#include <nmmintrin.h>

__attribute__((target("sse4.2"))) static uint32_t crc_sse42(uint32_t crc, const uint8_t *p, size_t size) {
  uint64_t state = ~crc;
  for (; size >= 8; p += 8, size -= 8) state = _mm_crc32_u64(state, fvv_get_u64(p));
  uint32_t rest = (uint32_t)state;
  for (; size; p++, size--) rest = _mm_crc32_u8(rest, *p);
  return ~rest;
}

int fvv_crc32c_hardware(uint32_t crc, const void *bytes, size_t size, uint32_t *result) {
  if (!__builtin_cpu_supports("sse4.2")) return 0;
  *result = crc_sse42(crc, bytes, size);
  return 1;
}
#elif defined(__ARM_FEATURE_CRC32)
#include <arm_acle.h>

int fvv_crc32c_hardware(uint32_t crc, const void *bytes, size_t size, uint32_t *result) {
  const uint8_t *p = bytes;
  crc = ~crc;
  for (; size >= 8; p += 8, size -= 8) crc = __crc32cd(crc, fvv_get_u64(p));
  for (; size; p++, size--) crc = __crc32cb(crc, *p);
  *result = ~crc;
  return 1;
}
#else
int fvv_crc32c_hardware(uint32_t crc, const void *bytes, size_t size, uint32_t *result) {
  (void)crc, (void)bytes, (void)size, (void)result;
  return 0;
}
#endif

uint32_t fvv_crc32c(uint32_t crc, const void *bytes, size_t size) {
  uint32_t result;
  return fvv_crc32c_hardware(crc, bytes, size, &result) ? result : fvv_crc32c_portable(crc, bytes, size);
}
