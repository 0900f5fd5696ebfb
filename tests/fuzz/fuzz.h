// What a fuzz target is made of: how it registers, how it takes its input apart, and how it reports that a
// property does not hold. A target is one file in targets/; libfuzzer.cpp, replay.cpp and amplification.cpp
// run them.
#pragma once

#include "fvv/types.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace fuzz {

using Bytes = std::vector<uint8_t>;

// How inputs are mutated. stream: chunks are changed, and their sizes, CRCs and tables repaired. png, glb:
// the same for the chunks of such a file. bytes: as libFuzzer has it.
enum class Form { bytes, stream, png, glb };

struct Target {
  const char *name;
  Form form;
  void (*run)(const uint8_t *data, size_t size);
};

// In order of registration, which is not determined.
const std::vector<Target> &targets();
const Target *find_target(const std::string &name);

struct Register {
  Register(const char *name, Form form, void (*run)(const uint8_t *data, size_t size));
};

// FVV_FUZZ_TARGET(name, form) { ... } defines a target whose body has `data` and `size`.
#define FVV_FUZZ_TARGET(target, form)                                                                        \
  static void run_##target(const uint8_t *data, size_t size);                                                \
  static const fuzz::Register register_##target(#target, form, run_##target);                                \
  static void run_##target(const uint8_t *data, size_t size)

// Ends the process: a property of the library does not hold. Not an assertion, which NDEBUG would remove.
[[noreturn]] inline void broken(const char *what) {
  std::fprintf(stderr, "fuzz: this does not hold: %s\n", what);
  std::abort();
}
inline void expect(bool holds, const char *what) {
  if (!holds) broken(what);
}

// Takes an input apart from the front. Beyond its end everything is zero or empty.
class Input {
public:
  Input(const uint8_t *data, size_t size) : data_(data), left_(size) {}

  size_t left() const { return left_; }

  template <class T> T number() {
    T value = {};
    const size_t taken = sizeof value < left_ ? sizeof value : left_;
    if (taken) std::memcpy(&value, data_, taken);
    skip(taken);
    return value;
  }
  uint8_t u8() { return number<uint8_t>(); }
  uint16_t u16() { return number<uint16_t>(); }
  uint32_t u32() { return number<uint32_t>(); }
  int64_t i64() { return number<int64_t>(); }
  double f64() { return number<double>(); }
  // 0 to count - 1.
  uint32_t below(uint32_t count) { return count > 256 ? u16() % count : u8() % count; }

  // In a block of exactly this size, so that a sanitizer sees any access beyond it.
  Bytes bytes(size_t size) {
    const size_t taken = size < left_ ? size : left_;
    const Bytes out(data_, data_ + taken);
    skip(taken);
    return out;
  }
  // A length in two bytes, and the bytes.
  Bytes part() { return bytes(u16()); }
  Bytes rest() { return bytes(left_); }

private:
  void skip(size_t size) {
    data_ += size;
    left_ -= size;
  }
  const uint8_t *data_;
  size_t left_;
};

// Pseudorandom numbers of a seed, the same everywhere.
struct Random {
  uint64_t state;
  explicit Random(uint64_t seed) : state(seed * 2 + 1) {}
  uint32_t next() {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return uint32_t(state >> 33);
  }
  uint32_t below(uint32_t count) { return count ? next() % count : 0; }
};

// A number that follows from the input, where an input has no room for choices of a target.
inline uint32_t digest(const uint8_t *data, size_t size) {
  return fvv_crc32c(0x5eed, data, size);
}

// For fvv_input.
struct Memory {
  const uint8_t *data;
  size_t size;
  static fvv_status read_at(void *user, uint64_t offset, void *out, size_t count) {
    const Memory &memory = *static_cast<const Memory *>(user);
    expect(offset <= memory.size && count <= memory.size - offset, "no read beyond the input");
    if (count) std::memcpy(out, memory.data + offset, count);
    return FVV_OK;
  }
  fvv_input input() { return {read_at, this, size}; }
};

// For fvv_output.
inline fvv_status append(void *user, const void *data, size_t size) {
  Bytes &out = *static_cast<Bytes *>(user);
  const uint8_t *from = static_cast<const uint8_t *>(data);
  out.insert(out.end(), from, from + size);
  return FVV_OK;
}

// Frees on destruction; for payloads of encoders.
struct Payload {
  fvv_bytes bytes = {};
  Payload() = default;
  Payload(const Payload &) = delete;
  ~Payload() { fvv_bytes_free(&bytes); }
};

// Whatever a decoder says, it must say it in its own terms.
inline void expect_status(fvv_status status) {
  expect(status != FVV_ERROR_BUG, "the library never reports its own bug");
  expect(status != FVV_ERROR_MEMORY, "memory suffices");
}

} // namespace fuzz
