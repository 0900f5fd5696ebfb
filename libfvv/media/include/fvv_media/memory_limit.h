// What decoding may take: compared with what a file's header demands, before a decoder is opened.
#pragma once

#include "fvv_cxx/error.h"

#include <cstdint>
#include <optional>
#include <string>

namespace fvv::media {

// HEVC of 8192 x 4320 with 10 bits takes 2.1 GiB at most.
constexpr uint64_t default_memory_limit = uint64_t(4) << 30;

// name: what messages call it, such as the option that sets it.
struct MemoryLimit {
  uint64_t bytes = UINT64_MAX;
  std::string name = "the memory limit";
};

class MemoryError : public Error {
public:
  using Error::Error;
};

// MemoryError when bytes is above limit: text, what it takes, and what limit allows. text: "decoding ...".
void check_memory(const std::string &text, uint64_t bytes, const MemoryLimit &limit);

// A number of bytes as people write it, "512M", "4g" or "100000"; nullopt: it is none. The text reads back as
// the same number.
constexpr const char *memory_words = "bytes, or a number with K, M or G such as 512M";
std::optional<uint64_t> parse_memory(const std::string &text);
std::string memory_text(uint64_t bytes);

} // namespace fvv::media
