/* What the C library does in loops, by the instructions that engines have for it. */
#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t size) {
  return __builtin_memcpy(to, from, size);
}
void *memmove(void *to, const void *from, size_t size) {
  return __builtin_memmove(to, from, size);
}
void *memset(void *to, int value, size_t size) {
  return __builtin_memset(to, value, size);
}
