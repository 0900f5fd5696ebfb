// capture/text_scan.cpp: tokens and numbers of text files.
#include "capture/text_scan.h"

#include <charconv>
#include <cmath>

namespace fvv::capture {

namespace {

// std::from_chars knows no leading '+', which printf("%+f") and Fortran write.
std::string_view without_plus(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  return text;
}

template <class Number> bool parse_whole(std::string_view text, Number &value) {
  text = without_plus(text);
  const char *end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

} // namespace

bool next_word(std::string_view &rest, std::string_view &word) {
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  size_t start = 0;
  while (start < rest.size() && blank(rest[start])) start++;
  size_t stop = start;
  while (stop < rest.size() && !blank(rest[stop])) stop++;
  word = rest.substr(start, stop - start);
  rest.remove_prefix(stop);
  return !word.empty();
}

bool next_line(std::string_view &rest, std::string_view &line) {
  if (rest.empty()) return false;
  const size_t end = rest.find('\n');
  line = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

bool parse_double(std::string_view text, double &value) {
  return parse_whole(text, value) && std::isfinite(value);
}

bool parse_integer(std::string_view text, int64_t &value) {
  return parse_whole(text, value);
}

std::string quote(std::string_view text) {
  constexpr size_t limit = 40;
  std::string out = "\"";
  for (const char c : text.substr(0, limit)) out += c >= 0x20 && c < 0x7f ? c : '?';
  return out + (text.size() > limit ? "...\"" : "\"");
}

void append_double(std::string &out, double value) {
  char text[32]; // the longest shortest form of a double has 24 characters
  out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
}

} // namespace fvv::capture
