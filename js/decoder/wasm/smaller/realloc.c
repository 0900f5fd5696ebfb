/* In place of the allocator's own, which knows ways to grow where a block stands and is five times as large:
 * lists double when they grow, and are kept from frame to frame. */
#include <malloc.h>
#include <stdlib.h>
#include <string.h>

void *realloc(void *pointer, size_t size) {
  void *larger = malloc(size);
  if (larger && pointer) {
    const size_t had = malloc_usable_size(pointer);
    memcpy(larger, pointer, had < size ? had : size);
    free(pointer);
  }
  return larger;
}
