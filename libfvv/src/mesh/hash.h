/* mesh/hash.h: mixing of three 32-bit numbers for open-addressing tables and fingerprints. */
#ifndef FVV_MESH_HASH_H
#define FVV_MESH_HASH_H

#include <stdint.h>

/* Finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): every input bit reaches every output bit. */
static inline uint64_t fvv_mix(uint64_t x) {
  x += UINT64_C(0x9e3779b97f4a7c15);
  x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
  x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
  return x ^ x >> 31;
}
static inline uint64_t fvv_hash3(uint32_t a, uint32_t b, uint32_t c) {
  return fvv_mix(fvv_mix((uint64_t)a << 32 | b) ^ c);
}

/* Slots of a table for count entries: a power of two, at least twice as many, so that probing stays short. */
static inline uint64_t fvv_hash_slots(uint64_t count) {
  uint64_t slots = 16;
  while (slots < 2 * count) slots *= 2;
  return slots;
}

#endif
