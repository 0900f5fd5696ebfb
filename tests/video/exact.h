// A heap block of exactly the given size, so that AddressSanitizer detects any read beyond it.
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
