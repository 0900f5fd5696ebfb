// Whole files in and out; words, lines and numbers of text files, the same under every locale.
#pragma once

#include "fvv/types.h"
#include "fvv_cxx/error.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace fvv::scene {

// Removes the next word, delimited by spaces and tabs, from rest. False if there is none.
bool next_word(std::string_view &rest, std::string_view &word);

// Removes the next line from rest, without its end (LF or CR LF). False if rest is empty.
bool next_line(std::string_view &rest, std::string_view &line);

// text as one finite decimal number. Rejects nan, inf, hexadecimal, overflow and underflow of a double. A
// leading '+' is accepted.
bool parse_double(std::string_view text, double &value);

// text as one decimal integer that fits.
bool parse_integer(std::string_view text, int64_t &value);

// "25" or "30000/1001" in lowest terms; nothing for what is none or does not fit.
std::optional<fvv_rational> parse_rational(std::string_view text);

// A to Z as a to z, other bytes as they are.
std::string lower(std::string_view text);

// In double quotes, at most 40 bytes, anything but printable ASCII as '?'.
std::string quote(std::string_view text);

// The shortest decimal text that reads back as the same double; "-0" for negative zero.
void append_double(std::string &out, double value);

// All bytes of a regular file. Error when it cannot be read or holds more than limit bytes; the size is
// checked before anything is allocated.
std::string read_file(const std::string &path, uint64_t limit);

// Replaces path. Error with the system's reason.
void write_file(const std::string &path, std::string_view bytes);

} // namespace fvv::scene
