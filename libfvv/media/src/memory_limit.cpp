#include "fvv_media/memory_limit.h"

#include <charconv>
#include <string_view>

namespace fvv::media {

namespace {

// Powers of 1024 by one, two and three.
constexpr std::string_view units = "KMG";
constexpr uint64_t most = uint64_t(1) << 62;

} // namespace

void check_memory(const std::string &text, uint64_t bytes, const MemoryLimit &limit) {
  if (bytes <= limit.bytes) return;
  const bool small = limit.bytes < 1 << 20;
  const uint64_t unit = small ? 1 << 10 : 1 << 20;
  const std::string name = small ? " KiB" : " MiB";
  throw MemoryError(text + " takes up to " + std::to_string((bytes - 1) / unit + 1) + name + ", " +
                    limit.name + " allows " + std::to_string(limit.bytes / unit) + name);
}

std::optional<uint64_t> parse_memory(const std::string &text) {
  std::string_view digits = text;
  unsigned shift = 0;
  if (digits.empty()) return std::nullopt;
  const char last = digits.back();
  if (const size_t at = units.find(last >= 'a' ? char(last - 'a' + 'A') : last); at != units.npos) {
    shift = 10 * unsigned(at + 1);
    digits.remove_suffix(1);
  }
  uint64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || value > most >> shift)
    return std::nullopt;
  return value << shift;
}

std::string memory_text(uint64_t bytes) {
  for (size_t i = units.size(); i > 0; i--)
    if (bytes && bytes % (uint64_t(1) << 10 * i) == 0) return std::to_string(bytes >> 10 * i) + units[i - 1];
  return std::to_string(bytes);
}

} // namespace fvv::media
