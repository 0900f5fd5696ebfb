/* base/crc32c.h: fvv_crc32c is public (fvv/types.h); these are its two implementations, for tests. */
#ifndef FVV_BASE_CRC32C_H
#define FVV_BASE_CRC32C_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Slicing by 8 tables, for any machine. */
uint32_t fvv_crc32c_portable(uint32_t crc, const void *bytes, size_t size);
/* 1 and *result when this machine has an instruction for it, else 0. */
int fvv_crc32c_hardware(uint32_t crc, const void *bytes, size_t size, uint32_t *result);

#ifdef __cplusplus
}
#endif
#endif
