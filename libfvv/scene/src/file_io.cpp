// Whole files in and out; tokens and numbers of text files.
#include "fvv_scene/file_io.h"
#include "fvv_cxx/input_file.h"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <system_error>

namespace fvv::scene {

namespace {

// std::from_chars does not accept a leading '+', which printf("%+f") and Fortran write.
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

std::optional<fvv_rational> parse_rational(std::string_view text) {
  int64_t numerator = 0, denominator = 1;
  const size_t slash = text.find('/');
  const auto digits = [](std::string_view part, int64_t &number) {
    return part.find_first_not_of("0123456789") == part.npos && parse_integer(part, number);
  };
  if (!digits(text.substr(0, slash), numerator) ||
      (slash != text.npos && !digits(text.substr(slash + 1), denominator)) || !denominator)
    return {};
  const int64_t divisor = std::gcd(numerator, denominator);
  if (numerator / divisor > UINT32_MAX || denominator / divisor > UINT32_MAX) return {};
  return fvv_rational{static_cast<uint32_t>(numerator / divisor),
                      static_cast<uint32_t>(denominator / divisor)};
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char &c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
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

namespace {

struct Close {
  void operator()(std::FILE *file) const { std::fclose(file); }
};

[[noreturn]] void fail(const std::string &path, const char *what, int number) {
  throw Error(path + ": " + what + ": " + std::generic_category().message(number));
}

} // namespace

std::string read_file(const std::string &path, uint64_t limit) {
  const InputFile file(path);
  const uint64_t size = file.size();
  if (size > limit)
    throw Error(path + ": has " + std::to_string(size) + " bytes, at most " + std::to_string(limit) +
                " are allowed");
  std::string bytes(static_cast<size_t>(size), '\0');
  const fvv_input input = file.input();
  if (size && input.read_at(input.user, 0, bytes.data(), bytes.size()) < 0)
    throw Error(path + ": cannot be read to its end");
  return bytes;
}

void write_file(const std::string &path, std::string_view bytes) {
  std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "wb"));
  if (!file) fail(path, "cannot be created", errno);
  if (std::fwrite(bytes.data(), 1, bytes.size(), file.get()) != bytes.size())
    fail(path, "cannot be written", errno);
  // Buffered bytes may fail as late as here (disk full), so the result of fclose is checked.
  if (std::fclose(file.release())) fail(path, "cannot be written", errno);
}

} // namespace fvv::scene
