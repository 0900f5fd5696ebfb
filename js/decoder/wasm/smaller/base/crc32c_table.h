/* In place of base/crc32c_table.h, whose 8 KiB of random bytes no compressor makes smaller. */
#ifndef FVV_BASE_CRC32C_TABLE_H
#define FVV_BASE_CRC32C_TABLE_H

#include <stdint.h>

extern uint32_t crc_table[8][256];

#endif
