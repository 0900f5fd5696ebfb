// capture/pattern.cpp: names of frames' files.
#include "capture/pattern.h"
#include "capture/text_scan.h"

namespace fvv::capture {

std::optional<Pattern> Pattern::parse(const std::string &text, std::string *what) {
  const auto refuse = [&](const char *reason) {
    *what = reason + (", found " + quote(text));
    return std::nullopt;
  };
  Pattern pattern;
  pattern.source = text;
  if (text.empty()) return refuse("expected a file name");
  for (size_t i = 0; i < text.size(); i++) {
    std::string &out = pattern.numbered ? pattern.suffix : pattern.prefix;
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    i++;
    if (i < text.size() && text[i] == '%') {
      out += '%';
      continue;
    }
    // %d, or %0Nd with N from 1 to 9.
    unsigned width = 0;
    if (i + 1 < text.size() && text[i] == '0' && text[i + 1] >= '1' && text[i + 1] <= '9') {
      width = static_cast<unsigned>(text[i + 1] - '0');
      i += 2;
    }
    if (i >= text.size() || text[i] != 'd') return refuse("expected %d, %0Nd (N from 1 to 9) or %% after %");
    if (pattern.numbered) return refuse("expected one %d, not more");
    pattern.numbered = true;
    pattern.width = width;
  }
  return pattern;
}

std::string Pattern::file(int64_t frame) const {
  if (!numbered) return prefix;
  const std::string digits = std::to_string(frame);
  return prefix + std::string(digits.size() < width ? width - digits.size() : 0, '0') + digits + suffix;
}

std::optional<int64_t> Pattern::frame(std::string_view name) const {
  int64_t number;
  if (!numbered || name.size() <= prefix.size() + suffix.size() ||
      !parse_integer(name.substr(prefix.size(), name.size() - prefix.size() - suffix.size()), number) ||
      number < 0 || file(number) != name)
    return std::nullopt;
  return number;
}

} // namespace fvv::capture
