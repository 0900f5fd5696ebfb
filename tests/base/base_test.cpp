// base/: CRC, text, numbers, diagnostics.
#include "fvv_catch.h"

#include <cstring>
#include <string>
#include <vector>

extern "C" {
#include "base/bytes.h"
#include "base/checked.h"
#include "base/crc32c.h"
#include "base/diagnostic.h"
#include "base/memory.h"
#include "base/text.h"
}

TEST_CASE("CRC-32C gives the values of RFC 3720 B.4") {
  uint8_t zeros[32] = {}, ones[32], rising[32];
  memset(ones, 0xff, sizeof ones);
  for (int i = 0; i < 32; i++) rising[i] = (uint8_t)i;
  CHECK(fvv_crc32c(0, zeros, 32) == 0x8a9136aau);
  CHECK(fvv_crc32c(0, ones, 32) == 0x62a8ab43u);
  CHECK(fvv_crc32c(0, rising, 32) == 0x46dd794eu);
  CHECK(fvv_crc32c(0, "123456789", 9) == 0xe3069283u);
}

TEST_CASE("CRC-32C is the same with and without the instruction, in one piece and in many") {
  std::vector<uint8_t> bytes(1000);
  uint32_t state = 1;
  for (auto &b : bytes) b = (uint8_t)((state = state * 1664525 + 1013904223) >> 24);
  for (size_t size : {size_t(0), size_t(1), size_t(7), size_t(8), size_t(9), size_t(64), size_t(1000)}) {
    const uint32_t portable = fvv_crc32c_portable(0, bytes.data(), size);
    uint32_t hardware = portable;
    if (!fvv_crc32c_hardware(0, bytes.data(), size, &hardware)) WARN("no CRC instruction here: not compared");
    CHECK(hardware == portable);
    uint32_t split = 0;
    for (size_t i = 0; i < size; i += 3)
      split = fvv_crc32c(split, bytes.data() + i, size - i < 3 ? size - i : 3);
    CHECK(split == portable);
  }
}

TEST_CASE("text is well-formed UTF-8 without NUL") {
  const auto valid = [](const char *text, size_t size) {
    return fvv_text_valid(reinterpret_cast<const uint8_t *>(text), size, nullptr) == 1;
  };
  CHECK(valid("", 0));
  CHECK(valid("cam\xc3\xa9ra \xe2\x82\xac \xf0\x9f\x8f\x80", 16));
  CHECK_FALSE(valid("a\0b", 3));
  CHECK_FALSE(valid("\xc0\x80", 2));         // overlong
  CHECK_FALSE(valid("\xe0\x80\x80", 3));     // overlong
  CHECK_FALSE(valid("\xed\xa0\x80", 3));     // surrogate
  CHECK_FALSE(valid("\xf4\x90\x80\x80", 4)); // beyond U+10FFFF
  CHECK_FALSE(valid("\xe2\x82", 2));         // cut
  size_t bad = 0;
  CHECK_FALSE(fvv_text_valid(reinterpret_cast<const uint8_t *>("ab\xff"), 3, &bad));
  CHECK(bad == 2);
}

TEST_CASE("LEB128 and zigzag come back, and only in the shortest form") {
  const int64_t values[] = {0, 1, -1, 63, 64, -65, 1 << 20, INT64_MAX, INT64_MIN};
  for (const int64_t value : values) {
    uint8_t bytes[10];
    const size_t size = fvv_put_uleb(bytes, fvv_zigzag(value));
    fvv_cursor cursor = {bytes, size, 0, 0};
    CHECK(fvv_unzigzag(fvv_cursor_uleb(&cursor)) == value);
    CHECK(!cursor.failed);
    CHECK(cursor.position == size);
    fvv_cursor cut = {bytes, size - 1, 0, 0};
    fvv_cursor_uleb(&cut);
    CHECK(cut.failed);
  }
  const uint8_t longer[] = {0x81, 0x00};
  fvv_cursor cursor = {longer, 2, 0, 0};
  fvv_cursor_uleb(&cursor);
  CHECK(cursor.failed);
  const uint8_t big[] = {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x02};
  cursor = {big, 10, 0, 0};
  fvv_cursor_uleb(&cursor);
  CHECK(cursor.failed);
}

TEST_CASE("checked arithmetic says when it overflows") {
  uint64_t result;
  CHECK(fvv_multiply_u64(1u << 31, 3, &result));
  CHECK(result == UINT64_C(6442450944));
  CHECK_FALSE(fvv_multiply_u64(UINT64_C(1) << 33, UINT64_C(1) << 31, &result));
  CHECK_FALSE(fvv_add_u64(UINT64_MAX, 1, &result));
  CHECK(fvv_padded(0) == 0);
  CHECK(fvv_padded(1) == 8);
  CHECK(fvv_padded(8) == 8);
}

TEST_CASE("the first error of a diagnostic wins and prints as one line") {
  fvv_diagnostic diagnostic;
  memset(&diagnostic, 0, sizeof diagnostic);
  CHECK(fvv_fail(&diagnostic, FVV_ERROR_INVALID, 3005, FVV_CHUNK_MESH, 0x10, "index %d of %d vertices", 7,
                 5) == FVV_ERROR_INVALID);
  CHECK(fvv_fail(&diagnostic, FVV_ERROR_DAMAGED, 1, 0, 0, "later") == FVV_ERROR_DAMAGED);
  fvv_diagnostic_rebase(&diagnostic, 0x100, FVV_CHUNK_SCENE);
  char line[300];
  const size_t length = fvv_diagnostic_format(&diagnostic, "a.fvv", line, sizeof line);
  CHECK(std::string(line) == "a.fvv: 0x110: MESH: index 7 of 5 vertices [FVV-3005]");
  CHECK(length == strlen(line));
  char cut[8];
  CHECK(fvv_diagnostic_format(&diagnostic, "a.fvv", cut, sizeof cut) == length);
  CHECK(std::string(cut) == "a.fvv: ");
}

TEST_CASE("a block refuses sizes that overflow") {
  fvv_bytes bytes = {nullptr, 0, 0, fvv_allocator_or_default(nullptr)};
  CHECK(fvv_bytes_append(&bytes, "abc", 3) == FVV_OK);
  CHECK(fvv_bytes_reserve(&bytes, SIZE_MAX - 1) == FVV_ERROR_MEMORY);
  CHECK(bytes.size == 3);
  fvv_bytes_free(&bytes);
  CHECK(bytes.data == nullptr);
}
