#include "memory.h"

#include <cstdlib>
#include <cstring>
#include <new>

namespace memory {

State state = {0, 0, -1, 0, false};

void reset(int64_t fail_after, size_t least, bool once) {
  state.peak = state.live;
  state.countdown = fail_after;
  state.least = least;
  state.once = once;
}

// The size precedes the block; 16 bytes keep it aligned.
static const size_t head = 16;

static void *take(size_t size) {
  if (size >= state.least && state.countdown == 0) {
    if (state.once) state.countdown = -1;
    return nullptr;
  }
  if (size >= state.least && state.countdown > 0) state.countdown--;
  if (size > SIZE_MAX - head) return nullptr;
  char *block = static_cast<char *>(std::malloc(size + head));
  if (!block) return nullptr;
  std::memcpy(block, &size, sizeof size);
  state.live += size;
  if (state.live > state.peak) state.peak = state.live;
  return block + head;
}

static void give(void *pointer) {
  if (!pointer) return;
  char *block = static_cast<char *>(pointer) - head;
  size_t size;
  std::memcpy(&size, block, sizeof size);
  state.live -= size;
  std::free(block);
}

static void *resize(void *, void *pointer, size_t old_size, size_t new_size) {
  void *moved = new_size ? take(new_size) : nullptr;
  if (new_size && !moved) return nullptr;
  if (pointer && moved) std::memcpy(moved, pointer, old_size < new_size ? old_size : new_size);
  if (pointer) {
    size_t size;
    std::memcpy(&size, static_cast<char *>(pointer) - head, sizeof size);
    // A caller that misremembers the size of its block is a bug no test may overlook.
    if (size != old_size) std::abort();
  }
  give(pointer);
  return moved;
}

fvv_allocator allocator() {
  return {resize, nullptr};
}

} // namespace memory

void *operator new(size_t size) {
  if (void *pointer = memory::take(size)) return pointer;
  throw std::bad_alloc();
}
void *operator new[](size_t size) {
  return operator new(size);
}
// A sanitizer brings its own of these two, which would not go through the ones above.
void *operator new(size_t size, const std::nothrow_t &) noexcept {
  return memory::take(size);
}
void *operator new[](size_t size, const std::nothrow_t &) noexcept {
  return memory::take(size);
}
void operator delete(void *pointer) noexcept {
  memory::give(pointer);
}
void operator delete[](void *pointer) noexcept {
  memory::give(pointer);
}
void operator delete(void *pointer, size_t) noexcept {
  memory::give(pointer);
}
void operator delete[](void *pointer, size_t) noexcept {
  memory::give(pointer);
}
