// Whole files in and out; tokens and numbers of text files.
#include "fvv_scene/text.h"

#include "fvv_cxx/input_file.h"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

namespace fvv::scene {

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

namespace {

struct Close {
  void operator()(std::FILE *file) const { std::fclose(file); }
};

[[noreturn]] void fail(const std::string &path, const char *what, int number) {
  throw Error(path + ": " + what + ": " + std::generic_category().message(number));
}

} // namespace

std::string read_file(const std::string &path, uint64_t limit) {
  const std::string why = why_unreadable(path);
  if (why == missing_file) fail(path, "cannot be opened", ENOENT);
  if (!why.empty()) throw Error(path + ": " + why + ", expected a file that can be read");
  std::error_code error;
  const uint64_t size = std::filesystem::file_size(path, error);
  if (error) fail(path, "cannot be measured", error.value());
  if (size > limit)
    throw Error(path + ": has " + std::to_string(size) + " bytes, at most " + std::to_string(limit) +
                " are allowed");
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
  if (!file) fail(path, "cannot be opened", errno);
  std::string bytes(static_cast<size_t>(size), '\0');
  const size_t count = std::fread(bytes.data(), 1, bytes.size(), file.get());
  if (std::ferror(file.get())) fail(path, "cannot be read", errno);
  if (count != bytes.size())
    throw Error(path + ": ended after " + std::to_string(count) + " of " + std::to_string(size) +
                " bytes while it was read");
  return bytes;
}

void write_file(const std::string &path, std::string_view bytes) {
  std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "wb"));
  if (!file) fail(path, "cannot be created", errno);
  if (std::fwrite(bytes.data(), 1, bytes.size(), file.get()) != bytes.size())
    fail(path, "cannot be written", errno);
  // Buffered bytes may fail as late as here (disk full), so that the answer of fclose counts.
  if (std::fclose(file.release())) fail(path, "cannot be written", errno);
}

} // namespace fvv::scene
