// SHA-256 of FIPS 180-4, byte by byte, so that it is the same on every machine.
#include "openssl/evp.h"

#include <cstdint>
#include <cstring>
#include <vector>

namespace {

constexpr uint32_t constants[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

uint32_t turned(uint32_t value, int bits) {
  return value >> bits | value << (32 - bits);
}

void add_block(const uint8_t *block, uint32_t state[8]) {
  uint32_t words[64], now[8];
  for (int i = 0; i < 16; i++)
    words[i] = uint32_t(block[4 * i]) << 24 | uint32_t(block[4 * i + 1]) << 16 |
               uint32_t(block[4 * i + 2]) << 8 | block[4 * i + 3];
  for (int i = 16; i < 64; i++) {
    const uint32_t a = words[i - 15], b = words[i - 2];
    words[i] = words[i - 16] + words[i - 7] + (turned(a, 7) ^ turned(a, 18) ^ a >> 3) +
               (turned(b, 17) ^ turned(b, 19) ^ b >> 10);
  }
  std::memcpy(now, state, sizeof now);
  for (int i = 0; i < 64; i++) {
    const uint32_t e = now[4], a = now[0];
    const uint32_t first = now[7] + (turned(e, 6) ^ turned(e, 11) ^ turned(e, 25)) +
                           ((e & now[5]) ^ (~e & now[6])) + constants[i] + words[i];
    const uint32_t second =
        (turned(a, 2) ^ turned(a, 13) ^ turned(a, 22)) + ((a & now[1]) ^ (a & now[2]) ^ (now[1] & now[2]));
    for (int k = 7; k; k--) now[k] = now[k - 1];
    now[4] += first;
    now[0] = first + second;
  }
  for (int i = 0; i < 8; i++) state[i] += now[i];
}

int value_of(unsigned char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : c == '=' ? 0 : -1;
}

} // namespace

const EVP_MD *EVP_sha256() {
  return nullptr;
}

int EVP_Digest(const void *bytes, size_t size, unsigned char *digest, unsigned *, const EVP_MD *, void *) {
  uint32_t state[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                       0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  const auto *p = static_cast<const uint8_t *>(bytes);
  const size_t whole = size / 64 * 64;
  for (size_t at = 0; at < whole; at += 64) add_block(p + at, state);
  std::vector<uint8_t> rest(p + whole, p + size);
  rest.push_back(0x80);
  while (rest.size() % 64 != 56) rest.push_back(0);
  for (int i = 7; i >= 0; i--) rest.push_back(uint8_t(uint64_t(size) * 8 >> 8 * i));
  for (size_t at = 0; at < rest.size(); at += 64) add_block(rest.data() + at, state);
  for (int i = 0; i < 32; i++) digest[i] = static_cast<unsigned char>(state[i / 4] >> (24 - 8 * (i % 4)));
  return 1;
}

int EVP_DecodeBlock(unsigned char *out, const unsigned char *text, int size) {
  for (int i = 0; i < size; i += 4) {
    uint32_t bits = 0;
    for (int k = 0; k < 4; k++) {
      const int value = value_of(text[i + k]);
      if (value < 0) return -1;
      bits = bits << 6 | uint32_t(value);
    }
    for (int k = 2; k >= 0; k--) *out++ = static_cast<unsigned char>(bits >> 8 * k);
  }
  return size / 4 * 3;
}
