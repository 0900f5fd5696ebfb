#include "fvvserve/ranges.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace fvv::serve {

namespace {

constexpr const char *date_format = "%a, %d %b %Y %H:%M:%S GMT";

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

// Only the form that is to be sent (IMF-fixdate); others count as absent.
std::optional<std::time_t> parse_date(std::string_view text) {
  std::tm fields = {};
  const std::string copy(trimmed(text));
  const char *end = strptime(copy.c_str(), date_format, &fields);
  if (!end || *end) return std::nullopt;
  return timegm(&fields);
}

// Whether a list of entity tags has ours. A weak tag fits only where the comparison is weak (8.8.3.2).
bool has_tag(std::string_view list, const std::string &etag, bool weak) {
  list = trimmed(list);
  if (list == "*") return true;
  while (!list.empty()) {
    const bool is_weak = list.substr(0, 2) == "W/";
    if (is_weak) list.remove_prefix(2);
    const size_t close = list.empty() || list[0] != '"' ? std::string_view::npos : list.find('"', 1);
    if (close == std::string_view::npos) return false;
    if (list.substr(0, close + 1) == etag && (weak || !is_weak)) return true;
    list = trimmed(list.substr(close + 1));
    if (list.empty() || list[0] != ',') return false;
    list = trimmed(list.substr(1));
  }
  return false;
}

// 1*DIGIT; what is too large for 64 bits lies behind the end of every file.
std::optional<uint64_t> parse_position(std::string_view text) {
  constexpr uint64_t largest = std::numeric_limits<uint64_t>::max();
  if (text.empty()) return std::nullopt;
  uint64_t value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    const auto digit = static_cast<uint64_t>(c - '0');
    value = value > (largest - digit) / 10 ? largest : value * 10 + digit;
  }
  return value;
}

Selection select_range(std::string_view range, uint64_t size) {
  const Selection whole = {200, 0, size}, unsatisfiable = {416, 0, 0};
  constexpr std::string_view unit = "bytes";
  const size_t equals = range.find('=');
  // Range units are case-insensitive (14.1).
  if (equals != unit.size() || !std::equal(unit.begin(), unit.end(), range.begin(), [](char a, char b) {
        return a == std::tolower(static_cast<unsigned char>(b));
      }))
    return whole;
  const std::string_view spec = trimmed(range.substr(equals + 1));
  const size_t dash = spec.find('-');
  if (dash == std::string_view::npos) return whole; // of a list the second dash or a comma is no digit
  const auto first = parse_position(spec.substr(0, dash)), last = parse_position(spec.substr(dash + 1));
  if (dash == 0) {
    if (!last) return whole;
    if (*last == 0) return unsatisfiable;
    if (size == 0) return whole; // satisfiable (14.1.2), but no Content-Range can say so
    const uint64_t count = std::min(*last, size);
    return {206, size - count, count};
  }
  if (!first || (!last && dash + 1 != spec.size()) || (last && *last < *first)) return whole;
  if (*first >= size) return unsatisfiable;
  return {206, *first, last ? std::min(*last - *first, size - *first - 1) + 1 : size - *first};
}

// A date is a strong validator only when a second change cannot have fallen into the same second (8.8.2.2).
bool range_holds(std::string_view if_range, const Validators &validators, std::time_t now) {
  if (if_range.empty()) return true;
  if (if_range.front() == '"') return if_range == validators.etag;
  const auto date = parse_date(if_range);
  return date && *date == validators.modified && validators.modified < now - 1;
}

} // namespace

Selection select(const Conditions &c, const Validators &validators, uint64_t size, std::time_t now,
                 bool head) {
  if (!c.if_match.empty()) {
    if (!has_tag(c.if_match, validators.etag, false)) return {412, 0, 0};
  } else if (const auto date = parse_date(c.if_unmodified_since)) {
    if (validators.modified > *date) return {412, 0, 0};
  }
  if (!c.if_none_match.empty()) {
    if (has_tag(c.if_none_match, validators.etag, true)) return {304, 0, 0};
  } else if (const auto date = parse_date(c.if_modified_since)) {
    if (validators.modified <= *date) return {304, 0, 0};
  }
  if (head || c.range.empty() || !range_holds(trimmed(c.if_range), validators, now)) return {200, 0, size};
  return select_range(trimmed(c.range), size);
}

std::string http_date(std::time_t time) {
  std::tm fields = {};
  gmtime_r(&time, &fields);
  char text[64];
  return {text, std::strftime(text, sizeof text, date_format, &fields)};
}

} // namespace fvv::serve
