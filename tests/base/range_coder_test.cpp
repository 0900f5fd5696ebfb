// base/range_coder: what goes in comes out, at about the entropy, and the end is exact.
#include "fvv_catch.h"

#include <cmath>
#include <memory>
#include <random>
#include <vector>

extern "C" {
#include "base/range_coder.h"
}

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

// Decodes from a block of exactly that size; the answer says how it ended.
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

TEST_CASE("a decoder that runs out of bytes takes zeros, says so, and reads nothing else") {
  const auto decisions = random_decisions(0.5, 4000, 9);
  const auto bytes = encoded(decisions);
  for (size_t cut = 0; cut + 1 < bytes.size(); cut += 3) {
    const Decoded part = decoded({bytes.begin(), bytes.begin() + long(cut)}, decisions);
    CHECK(part.failed);
    CHECK(!part.finished);
  }
}

TEST_CASE("estimates stay within what the header says") {
  for (const int bit : {0, 1}) {
    fvv_probability p;
    fvv_probability_reset(&p);
    for (int i = 0; i < 100000; i++) fvv_probability_update(&p, bit);
    CHECK(fvv_probability_of_one(&p) == (bit ? 4091u : 4u));
    CHECK(p.fast == (bit ? 65521 : 15));
  }
}
