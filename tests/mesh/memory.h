// Counts what is allocated, by operator new anywhere in the process (Draco) and by an fvv_allocator, and
// makes the n-th allocation fail.
#ifndef FVV_TESTS_MESH_MEMORY_H
#define FVV_TESTS_MESH_MEMORY_H

#include <cstddef>
#include <cstdint>

#include "fvv/types.h"

namespace memory {
struct State {
  size_t live;       // bytes
  size_t peak;       // bytes, since the last reset
  int64_t countdown; // allocations until one fails; negative: none fails
  size_t least;      // bytes: smaller allocations neither count nor fail
  bool once;         // only that one fails, those after it do not
};
extern State state;

// Resets the peak; after this number of allocations every further one fails until the next reset, or only
// the next one.
void reset(int64_t fail_after = -1, size_t least = 0, bool once = false);
fvv_allocator allocator();
} // namespace memory

#endif
