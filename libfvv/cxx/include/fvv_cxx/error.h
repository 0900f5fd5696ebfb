// The one exception type of the C++ libraries, and failures of libfvv as such exceptions.
#pragma once

#include "fvv/types.h"

#include <stdexcept>
#include <string>

namespace fvv {

// what() is the whole line that a user reads: "file: place: what is wrong", where a place is "LINE" of text,
// "0xOFFSET" of binary data or a JSON pointer; only what is wrong where no file is known. The C++ libraries
// throw this and std::bad_alloc, nothing else.
class Error : public std::runtime_error {
public:
  enum Kind {
    failed,    // the input or the system
    usage,     // the caller's options do not fit the input or each other
    cancelled, // by the caller
  };

  explicit Error(const std::string &line, Kind the_kind = failed)
      : std::runtime_error(line), kind(the_kind) {}
  Error(const std::string &name, const std::string &text)
      : Error(name.empty() ? text : name + ": " + text, failed) {}

  const Kind kind;
};

// Throws an Error with the line of a diagnostic. name: the file as the user wrote it.
[[noreturn]] void fail(const std::string &name, const fvv_diagnostic &diagnostic);
// Does the same when status is an error; otherwise does nothing.
void check(fvv_status status, const std::string &name, const fvv_diagnostic &diagnostic);

} // namespace fvv
