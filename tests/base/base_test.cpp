// base/: CRC, text, numbers, diagnostics, and the range coder.
#include "fvv_catch.h"

#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

extern "C" {
#include "base/bytes.h"
#include "base/checked.h"
#include "base/crc32c.h"
#include "base/diagnostic.h"
#include "base/memory.h"
#include "base/range_coder.h"
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

TEST_CASE("checked arithmetic reports overflow") {
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

// ---- base/range_coder: what goes in comes out, at about the entropy, and the end is exact.

namespace {

struct Decision {
  int context; // -1: even odds
  int bit;
};

std::vector<uint8_t> encoded(const std::vector<Decision> &decisions) {
  fvv_bytes bytes = {};
  bytes.allocator = {[](void *, void *p, size_t, size_t size) -> void * {
                       if (size) return realloc(p, size);
                       free(p);
                       return nullptr;
                     },
                     nullptr};
  std::vector<fvv_probability> contexts(16);
  for (fvv_probability &p : contexts) fvv_probability_reset(&p);
  fvv_range_encoder encoder;
  fvv_range_encoder_init(&encoder, &bytes);
  for (const Decision &d : decisions)
    if (d.context < 0)
      fvv_range_encode_even(&encoder, d.bit);
    else
      fvv_range_encode(&encoder, &contexts[size_t(d.context)], d.bit);
  REQUIRE(fvv_range_encoder_finish(&encoder) == FVV_OK);
  const std::vector<uint8_t> out(bytes.data, bytes.data + bytes.size);
  fvv_bytes_free(&bytes);
  return out;
}

// Decodes from a block of exactly that size; returns how it ended.
struct Decoded {
  size_t wrong = 0;
  bool failed = false, finished = false;
};
Decoded decoded(const std::vector<uint8_t> &bytes, const std::vector<Decision> &expected) {
  const std::unique_ptr<uint8_t[]> block(new uint8_t[bytes.size()]);
  std::copy(bytes.begin(), bytes.end(), block.get());
  std::vector<fvv_probability> contexts(16);
  for (fvv_probability &p : contexts) fvv_probability_reset(&p);
  fvv_range_decoder decoder;
  fvv_range_decoder_init(&decoder, block.get(), bytes.size());
  Decoded out;
  for (const Decision &d : expected)
    out.wrong += size_t(d.bit != (d.context < 0 ? fvv_range_decode_even(&decoder)
                                                : fvv_range_decode(&decoder, &contexts[size_t(d.context)])));
  out.failed = fvv_range_decoder_failed(&decoder);
  out.finished = fvv_range_decoder_finished(&decoder);
  return out;
}

std::vector<Decision> random_decisions(double one, size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Decision> out(count);
  for (Decision &d : out) d = {0, random() < one * 4294967296.0};
  return out;
}

} // namespace

TEST_CASE("decisions of any probability take little more than their entropy") {
  for (const double one : {0.002, 0.01, 0.1, 0.3, 0.5, 0.8, 0.97, 0.998}) {
    const auto decisions = random_decisions(one, 200000, 7);
    const auto bytes = encoded(decisions);
    const double entropy = -(one * std::log2(one) + (1 - one) * std::log2(1 - one));
    const double spent = 8.0 * double(bytes.size()) / 200000;
    INFO(one << ": " << spent << " bits, entropy " << entropy);
    // The fast estimate costs some 2 %, and where 1s are rare each of them moves it far.
    CHECK(spent < 1.03 * entropy + 0.006);
    CHECK(spent > 0.97 * entropy);
    const Decoded all = decoded(bytes, decisions);
    CHECK(all.wrong == 0);
    CHECK(all.finished);
  }
}

TEST_CASE("estimates follow what changes") {
  std::vector<Decision> decisions = random_decisions(0.02, 2000, 1);
  for (const Decision &d : random_decisions(0.98, 2000, 2)) decisions.push_back(d);
  CHECK(8 * encoded(decisions).size() < 900); // 566 at best, 4000 with one fixed estimate
}

TEST_CASE("mixed contexts and even decisions of any number come back, with an exact end") {
  std::mt19937 random(3);
  for (size_t count = 0; count < 400; count++) {
    std::vector<Decision> decisions(count);
    for (Decision &d : decisions) {
      d.context = int(random() % 17) - 1;
      d.bit = random() % 16 < unsigned(d.context + 1);
    }
    const auto bytes = encoded(decisions);
    const Decoded all = decoded(bytes, decisions);
    CHECK(all.wrong == 0);
    CHECK(all.finished);
    auto longer = bytes;
    longer.push_back(0);
    CHECK(!decoded(longer, decisions).finished);
    auto shorter = bytes;
    shorter.pop_back();
    CHECK(!decoded(shorter, decisions).finished);
  }
}

TEST_CASE("carries run through long rows of 255") {
  // The upper half of the range over and over gives bytes of 255; the last decisions carry or not.
  for (const int last : {0, 1}) {
    std::vector<Decision> decisions(400, Decision{-1, 0});
    for (int i = 0; i < 40; i++) decisions.push_back({-1, last});
    decisions.push_back({1, 0});
    const auto bytes = encoded(decisions);
    const Decoded all = decoded(bytes, decisions);
    CHECK(all.wrong == 0);
    CHECK(all.finished);
  }
  std::mt19937 random(5);
  for (int round = 0; round < 2000; round++) {
    std::vector<Decision> decisions;
    for (int i = 0; i < 120; i++) decisions.push_back({random() % 8 ? -1 : 2, random() % 32 == 0});
    CHECK(decoded(encoded(decisions), decisions).wrong == 0);
  }
}

TEST_CASE("a decoder that runs out of bytes takes zeros, reports it, and reads nothing else") {
  const auto decisions = random_decisions(0.5, 4000, 9);
  const auto bytes = encoded(decisions);
  for (size_t cut = 0; cut + 1 < bytes.size(); cut += 3) {
    const Decoded part = decoded({bytes.begin(), bytes.begin() + long(cut)}, decisions);
    CHECK(part.failed);
    CHECK(!part.finished);
  }
}

TEST_CASE("estimates stay within the documented range") {
  for (const int bit : {0, 1}) {
    fvv_probability p;
    fvv_probability_reset(&p);
    for (int i = 0; i < 100000; i++) fvv_probability_update(&p, bit);
    CHECK(fvv_probability_of_one(&p) == (bit ? 4091u : 4u));
    CHECK(p.fast == (bit ? 65521 : 15));
  }
}
