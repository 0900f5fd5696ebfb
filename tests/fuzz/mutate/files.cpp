#include "mutate.h"

extern "C" {
#include "base/bytes.h"
}

#include <algorithm>

namespace fuzz {

namespace {

// CRC-32 of PNG (ISO 3309), bit by bit: its inputs are short.
uint32_t crc32(const uint8_t *data, size_t size) {
  uint32_t crc = 0xffffffff;
  for (size_t i = 0; i < size; i++) {
    crc ^= data[i];
    for (int bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc;
}

uint32_t big_endian(const uint8_t *p) {
  return uint32_t(p[0]) << 24 | uint32_t(p[1]) << 16 | uint32_t(p[2]) << 8 | p[3];
}
void put_big_endian(uint8_t *p, uint32_t value) {
  for (int i = 0; i < 4; i++) p[i] = uint8_t(value >> (24 - 8 * i));
}

Bytes mutate_whole(const Bytes &file, size_t capacity, MutateBytes mutate) {
  Bytes out = file;
  out.resize(std::max(capacity, file.size()));
  out.resize(mutate(out.data(), file.size(), capacity));
  return out;
}

Random own_random(1);

} // namespace

Bytes mutate_png(const Bytes &file, size_t capacity, Random &random, MutateBytes mutate) {
  Bytes out = mutate_whole(file, capacity, mutate);
  if (!random.below(8)) return out;
  static const uint8_t signature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (out.size() < 8 + 12) return out;
  std::copy(signature, signature + 8, out.begin());
  for (size_t at = 8; at + 12 <= out.size();) {
    const size_t left = out.size() - at - 12;
    uint32_t size = big_endian(out.data() + at);
    // A size beyond the end becomes what is left: else one changed byte hides the rest of the file.
    if (size > left) put_big_endian(out.data() + at, size = uint32_t(left));
    put_big_endian(out.data() + at + 8 + size, crc32(out.data() + at + 4, 4 + size_t(size)));
    at += 12 + size_t(size);
  }
  return out;
}

Bytes mutate_glb(const Bytes &file, size_t capacity, Random &random, MutateBytes mutate) {
  Bytes out = mutate_whole(file, capacity, mutate);
  // glTF as JSON is left as it is.
  if (out.size() < 20 || std::memcmp(out.data(), "glTF", 4) || !random.below(8)) return out;
  out.resize(out.size() / 4 * 4);
  fvv_put_u32(out.data() + 8, uint32_t(out.size()));
  const uint32_t left = uint32_t(out.size() - 20),
                 json = std::min(fvv_get_u32(out.data() + 12) / 4 * 4, left);
  fvv_put_u32(out.data() + 12, json);
  const size_t second = 20 + size_t(json);
  if (second + 8 <= out.size()) fvv_put_u32(out.data() + second, uint32_t(out.size() - second - 8));
  return out;
}

void seed_mutations(uint64_t seed) {
  own_random = Random(seed);
}

size_t mutate_bytes(uint8_t *data, size_t size, size_t capacity) {
  Random &random = own_random;
  for (uint32_t edits = 1 + random.below(4); edits; edits--) {
    const uint32_t what = random.below(8);
    if (!size || (what == 0 && size < capacity)) {
      if (size == capacity) return size;
      const size_t at = random.below(uint32_t(size) + 1);
      std::memmove(data + at + 1, data + at, size - at);
      data[at] = uint8_t(random.below(256));
      size++;
    } else if (what == 1) {
      const size_t at = random.below(uint32_t(size)),
                   count = 1 + random.below(uint32_t(std::min<size_t>(size - at, 16)));
      std::memmove(data + at, data + at + count, size - at - count);
      size -= count;
    } else if (what == 2) {
      const size_t from = random.below(uint32_t(size)), to = random.below(uint32_t(size));
      std::memmove(data + to, data + from, std::min<size_t>(size - std::max(from, to), 1 + random.below(16)));
    } else if (what == 3) {
      static const uint8_t odd[] = {0, 1, 0x7f, 0x80, 0xff};
      data[random.below(uint32_t(size))] = odd[random.below(5)];
    } else {
      data[random.below(uint32_t(size))] ^= uint8_t(1 << random.below(8));
    }
  }
  return size;
}

Bytes mutate(Form form, const Bytes &input, size_t capacity, Random &random, MutateBytes mutate) {
  switch (form) {
  case Form::stream:
    return mutate_stream(input, capacity, random, mutate);
  case Form::png:
    return mutate_png(input, capacity, random, mutate);
  case Form::glb:
    return mutate_glb(input, capacity, random, mutate);
  case Form::bytes:
    break;
  }
  return mutate_whole(input, capacity, mutate);
}

} // namespace fuzz
