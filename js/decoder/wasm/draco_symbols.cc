// Draco's entropy decoder of symbols, in place of its own file symbol_decoding.cc: one decoder for all
// precisions, whose state stays in registers. Draco's has one for each number of bits, with the state in
// memory: it is slower and larger.
#include <limits>
#include <memory>

#include "draco/compression/entropy/symbol_decoding.h"
#include "draco/core/varint_decoding.h"

namespace {

constexpr uint8_t tagged = 0, raw = 1;
constexpr int least_precision_bits = 12, most_precision_bits = 20, most_symbol_bits = 18;
constexpr int tag_symbol_bits = 5;

int precision_bits_of(int symbol_bits) {
  const int bits = 3 * symbol_bits / 2;
  return bits < least_precision_bits  ? least_precision_bits
         : bits > most_precision_bits ? most_precision_bits
                                      : bits;
}

struct Symbol {
  uint32_t probability, start;
};

// rANS, read from the back. Index: the smallest type that has the symbols.
template <typename Index> class Coder {
public:
  Coder(int precision_bits, uint32_t symbol_count)
      : bits_(precision_bits), count_(symbol_count), symbols_(new Symbol[symbol_count]),
        symbol_at_(new Index[size_t(1) << precision_bits]) {}

  // Probabilities, in 1 to 3 bytes each or as a number of zeros.
  bool read_table(draco::DecoderBuffer *buffer) {
    const uint32_t precision = 1u << bits_;
    uint32_t sum = 0;
    for (uint32_t i = 0; i < count_; i++) {
      uint8_t first;
      if (!buffer->Decode(&first)) return false;
      const uint32_t token = first & 3;
      uint32_t probability = first >> 2;
      if (token == 3) {
        if (probability >= count_ - i) return false;
        i += probability;
        continue;
      }
      for (uint32_t b = 0; b < token; b++) {
        uint8_t more;
        if (!buffer->Decode(&more)) return false;
        probability |= uint32_t(more) << (8 * (b + 1) - 2);
      }
      if (probability > precision - sum) return false;
      symbols_[i] = {probability, sum};
      for (uint32_t at = 0; at < probability; at++) symbol_at_[sum + at] = Index(i);
      sum += probability;
    }
    return sum == precision;
  }

  // The two high bits of the last byte are the number of further bytes of the first state.
  bool start(draco::DecoderBuffer *buffer) {
    uint64_t size;
    if (!draco::DecodeVarint(&size, buffer) || size > uint64_t(buffer->remaining_size()) || size < 1)
      return false;
    bytes_ = reinterpret_cast<const uint8_t *>(buffer->data_head());
    buffer->Advance(int64_t(size));
    const uint32_t more = bytes_[size - 1] >> 6;
    if (size < more + 1) return false;
    left_ = uint32_t(size) - 1;
    state_ = bytes_[left_] & 63;
    for (uint32_t i = 0; i < more; i++) state_ = state_ << 8 | bytes_[--left_];
    state_ += 4u << bits_;
    return state_ < 1024u << bits_;
  }

  // next(symbol), which returns false to stop, for each of count symbols.
  template <typename Next> bool read(uint32_t count, const Next &next) const {
    const int bits = bits_;
    const uint32_t base = 4u << bits, mask = (1u << bits) - 1;
    const uint8_t *const bytes = bytes_;
    const Index *const symbol_at = symbol_at_.get();
    const Symbol *const symbols = symbols_.get();
    uint32_t state = state_, left = left_;
    for (uint32_t i = 0; i < count; i++) {
      while (state < base && left) state = state << 8 | bytes[--left];
      const uint32_t rest = state & mask;
      const uint32_t symbol = symbol_at[rest];
      state = (state >> bits) * symbols[symbol].probability + rest - symbols[symbol].start;
      if (!next(i, symbol)) return false;
    }
    return true;
  }

private:
  const int bits_;
  const uint32_t count_;
  const std::unique_ptr<Symbol[]> symbols_;
  const std::unique_ptr<Index[]> symbol_at_;
  const uint8_t *bytes_ = nullptr;
  uint32_t left_ = 0, state_ = 0;
};

template <typename Index>
bool decode_raw(int precision_bits, uint32_t symbol_count, uint32_t count, draco::DecoderBuffer *buffer,
                uint32_t *values) {
  Coder<Index> coder(precision_bits, symbol_count);
  return coder.read_table(buffer) && coder.start(buffer) &&
         coder.read(count, [values](uint32_t i, uint32_t symbol) {
           values[i] = symbol;
           return true;
         });
}

// Tags are numbers of bits; the values of each tuple follow.
bool decode_tagged(uint32_t symbol_count, uint32_t count, uint32_t components, draco::DecoderBuffer *buffer,
                   uint32_t *values) {
  Coder<uint16_t> coder(precision_bits_of(tag_symbol_bits), symbol_count);
  if (!coder.read_table(buffer) || !coder.start(buffer)) return false;
  buffer->StartBitDecoding(false, nullptr);
  const bool complete = coder.read(count / components, [=](uint32_t i, uint32_t bits) {
    for (uint32_t c = 0; c < components; c++)
      if (!buffer->DecodeLeastSignificantBits32(bits, &values[i * components + c])) return false;
    return true;
  });
  if (complete) buffer->EndBitDecoding();
  return complete;
}

} // namespace

// count: a multiple of components.
bool draco::DecodeSymbols(uint32_t count, int components, DecoderBuffer *buffer, uint32_t *values) {
  if (count == 0) return true;
  uint8_t scheme, symbol_bits = tag_symbol_bits;
  if (!buffer->Decode(&scheme) || scheme > raw) return false;
  if (scheme == raw && (!buffer->Decode(&symbol_bits) || symbol_bits < 1 || symbol_bits > most_symbol_bits))
    return false;
  uint32_t symbol_count;
  // The table has at least a byte for 64 symbols.
  if (!DecodeVarint(&symbol_count, buffer) || !symbol_count || symbol_count / 64 > buffer->remaining_size())
    return false;
  if (scheme == tagged)
    return symbol_count <= std::numeric_limits<uint16_t>::max() &&
           decode_tagged(symbol_count, count, uint32_t(components), buffer, values);
  const int bits = precision_bits_of(symbol_bits);
  return symbol_count <= std::numeric_limits<uint16_t>::max()
             ? decode_raw<uint16_t>(bits, symbol_count, count, buffer, values)
             : decode_raw<uint32_t>(bits, symbol_count, count, buffer, values);
}
