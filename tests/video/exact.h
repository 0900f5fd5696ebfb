// A heap block of exactly the size asked for, so that AddressSanitizer sees a byte read too far.
#ifndef FVV_TESTS_EXACT_H
#define FVV_TESTS_EXACT_H

#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

class exact {
public:
  exact(const std::vector<uint8_t> &bytes, size_t size) : block(size ? new uint8_t[size] : nullptr) {
    if (size) memcpy(block.get(), bytes.data(), size);
  }
  const uint8_t *data() const { return block.get(); }

private:
  std::unique_ptr<uint8_t[]> block;
};

#endif
