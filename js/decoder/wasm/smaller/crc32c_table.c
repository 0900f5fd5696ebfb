/* Computes the tables when the instance is made. */
#include "base/crc32c_table.h"

uint32_t crc_table[8][256];

__attribute__((constructor)) static void fill(void) {
  for (uint32_t n = 0; n < 256; n++) {
    uint32_t crc = n;
    for (int i = 0; i < 8; i++) crc = crc & 1 ? crc >> 1 ^ 0x82f63b78u : crc >> 1;
    crc_table[0][n] = crc;
  }
  for (int k = 1; k < 8; k++)
    for (int n = 0; n < 256; n++)
      crc_table[k][n] = crc_table[k - 1][n] >> 8 ^ crc_table[0][crc_table[k - 1][n] & 255];
}
