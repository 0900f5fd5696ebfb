#include "fvv_cxx/range.h"

#include "fvv_cxx/error.h"

#include <charconv>

namespace fvv {

namespace {

// from_chars takes a minus sign, a number of ours has none.
bool scan_number(std::string_view text, int64_t &number) {
  const char *const end = text.data() + text.size();
  if (text.find_first_not_of("0123456789") != text.npos) return false;
  const auto [at, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && at == end && number <= INT32_MAX;
}

} // namespace

std::optional<Range> scan_range(std::string_view text) {
  const size_t dots = text.find(".."), at = dots == text.npos ? text.find('-') : dots;
  Range range;
  if (!scan_number(text.substr(0, at), range.first)) return {};
  range.last = range.first;
  if (at != text.npos && !scan_number(text.substr(at + (dots == text.npos ? 1 : 2)), range.last)) return {};
  return range.first <= range.last ? std::optional(range) : std::nullopt;
}

Range parse_range(const std::string &option, const std::string &text) {
  const std::optional<Range> range = scan_range(text);
  if (!range)
    refuse_option(
        option, "expected a number or two such as 10-19 or 10..19, the second not below the first, found '" +
                    text + "'");
  return *range;
}

} // namespace fvv
