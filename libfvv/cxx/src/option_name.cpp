#include "fvv_cxx/error.h"

#include <algorithm>

namespace fvv {

namespace {

// Control characters, which no text of a message has: what is quoted shows them as question marks.
constexpr char begin = '\x02', value_begin = '\x1f', end = '\x03';

void append_spelled(std::string &out, std::string_view mark, Spelling spelling) {
  const size_t at = mark.find(value_begin);
  const std::string_view identifier = mark.substr(0, at);
  const bool has_value = at != mark.npos;
  const std::string value(has_value ? mark.substr(at + 1) : std::string_view());
  std::string name(identifier);
  if (spelling == Spelling::python || spelling == Spelling::c)
    std::replace(name.begin(), name.end(), '-', '_');
  if (spelling == Spelling::command_line)
    out += "--" + name + (has_value ? " " + value : "");
  else if (spelling == Spelling::python)
    out += name + (has_value ? "='" + value + "'" : "");
  else
    out += name + (has_value ? "=" + value : "");
}

} // namespace

std::string option_name(std::string_view identifier) {
  return begin + std::string(identifier) + end;
}

std::string option_name(std::string_view identifier, std::string_view value) {
  return begin + std::string(identifier) + value_begin + std::string(value) + end;
}

std::string spell(std::string_view message, Spelling spelling) {
  std::string out;
  for (size_t i = 0; i < message.size();) {
    const size_t start = std::min(message.find(begin, i), message.size());
    out += message.substr(i, start - i);
    if (start == message.size()) break;
    const size_t stop = message.find(end, start);
    if (stop == message.npos) return out += message.substr(start);
    append_spelled(out, message.substr(start + 1, stop - start - 1), spelling);
    i = stop + 1;
  }
  return out;
}

std::string first_option(std::string_view message) {
  const size_t start = message.find(begin);
  if (start == message.npos) return {};
  const size_t stop = message.find_first_of(std::string{value_begin, end}, start);
  return std::string(message.substr(start + 1, stop == message.npos ? stop : stop - start - 1));
}

} // namespace fvv
