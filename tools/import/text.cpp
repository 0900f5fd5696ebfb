// import/text.cpp: lines, words and numbers with their places.
#include "import/text.h"
#include "capture/text_scan.h"

namespace fvv::import {

void fail_at(const std::string &path, uint64_t line, const std::string &what) {
  throw capture::FileError(path + ":" + std::to_string(line) + ": " + what);
}

double number_at(const std::string &path, uint64_t line, std::string_view word, const char *name) {
  double value;
  if (!capture::parse_double(word, value))
    fail_at(path, line,
            std::string("expected a finite number for ") + name + ", found " + capture::quote(word));
  return value;
}

int64_t integer_at(const std::string &path, uint64_t line, std::string_view word, const char *name,
                   int64_t least, int64_t most) {
  int64_t value;
  if (!capture::parse_integer(word, value) || value < least || value > most)
    fail_at(path, line,
            std::string("expected an integer from ") + std::to_string(least) + " to " + std::to_string(most) +
                " for " + name + ", found " + capture::quote(word));
  return value;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  std::string_view line, word;
  while (words.size() < max_words && capture::next_line(text, line))
    while (words.size() < max_words && capture::next_word(line, word)) words.push_back(word);
  return words;
}

bool Lines::next(std::string_view &line) {
  if (!capture::next_line(rest, line)) return false;
  count++;
  return true;
}

bool Lines::next_content(std::string_view &line) {
  while (next(line)) {
    const size_t first = line.find_first_not_of(" \t");
    if (first != line.npos && line[first] != '#') return true;
  }
  return false;
}

} // namespace fvv::import
