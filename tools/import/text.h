// import/text.h: text files line by line, with errors that name the line. Knows no format.
#pragma once

#include "capture/file.h"

#include <string>
#include <string_view>
#include <vector>

namespace fvv::import {

constexpr uint64_t max_text_size = uint64_t(64) << 20;

// FileError "path:LINE: what".
[[noreturn]] void fail_at(const std::string &path, uint64_t line, const std::string &what);

// The whole of word is a finite decimal number, or fail_at "expected a finite number for NAME, found ...".
double number_at(const std::string &path, uint64_t line, std::string_view word, const char *name);
int64_t integer_at(const std::string &path, uint64_t line, std::string_view word, const char *name,
                   int64_t least, int64_t most);

// The words of a text, delimited by blanks and line ends. Stops after max_words, which is more than any line
// of any format may have, so that a line as long as a file costs no vector of that length.
constexpr size_t max_words = 1000;
std::vector<std::string_view> words_of(std::string_view text);

// Borrows bytes and path.
class Lines {
public:
  Lines(std::string_view bytes, const std::string &path) : rest(bytes), name(path) {}

  bool next(std::string_view &line);         // the next one as it stands
  bool next_content(std::string_view &line); // skips empty lines and those that begin with '#'
  uint64_t number() const { return count; }  // of the last line, from 1
  const std::string &path() const { return name; }
  std::string where() const { return name + ":" + std::to_string(count); }
  [[noreturn]] void fail(const std::string &what) const { fail_at(name, count, what); }
  double real(std::string_view word, const char *what) const { return number_at(name, count, word, what); }
  int64_t integer(std::string_view word, const char *what, int64_t least, int64_t most) const {
    return integer_at(name, count, word, what, least, most);
  }

private:
  std::string_view rest;
  const std::string &name;
  uint64_t count = 0;
};

} // namespace fvv::import
