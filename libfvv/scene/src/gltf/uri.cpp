// URIs of buffers.

#include "scene/src/gltf/uri.h"

namespace fvv::scene::gltf {

namespace {

constexpr std::string_view scheme = "data:";

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

} // namespace

bool is_data_uri(std::string_view uri) {
  return uri.substr(0, scheme.size()) == scheme;
}

std::optional<std::string> data_uri(std::string_view uri) {
  const size_t comma = uri.find(',');
  constexpr std::string_view mark = ";base64";
  if (!is_data_uri(uri) || comma == uri.npos || comma < scheme.size() + mark.size() ||
      uri.substr(comma - mark.size(), mark.size()) != mark)
    return std::nullopt;
  std::string_view text = uri.substr(comma + 1);
  if (text.size() % 4) return std::nullopt;
  size_t padding = 0;
  while (padding < 2 && padding < text.size() && text[text.size() - 1 - padding] == '=') padding++;
  text.remove_suffix(padding);
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  unsigned bits = 0, value = 0;
  for (const char c : text) {
    const int digit = base64_digit(c);
    if (digit < 0) return std::nullopt;
    value = (value << 6 | static_cast<unsigned>(digit)) & 0xffff;
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(value >> bits & 0xff);
  }
  return bytes;
}

std::optional<std::string> relative_file(std::string_view uri) {
  std::string path;
  for (size_t i = 0; i < uri.size(); i++) {
    char c = uri[i];
    // Before escapes are resolved: a colon in a name has to be written as %3A.
    if (c == ':') return std::nullopt;
    if (c == '%') {
      const int high = i + 2 < uri.size() ? hex_digit(uri[i + 1]) : -1;
      const int low = i + 2 < uri.size() ? hex_digit(uri[i + 2]) : -1;
      if (high < 0 || low < 0) return std::nullopt;
      c = static_cast<char>(high << 4 | low);
      i += 2;
    }
    if (c == '\0' || c == '\\') return std::nullopt;
    path += c;
  }
  if (path.empty() || path[0] == '/') return std::nullopt;
  for (size_t start = 0; start != std::string::npos;) {
    const size_t end = path.find('/', start);
    if (path.substr(start, end == path.npos ? end : end - start) == "..") return std::nullopt;
    start = end == path.npos ? end : end + 1;
  }
  return path;
}

} // namespace fvv::scene::gltf
