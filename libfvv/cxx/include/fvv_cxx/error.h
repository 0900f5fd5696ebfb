// The one exception type of the C++ libraries, how its messages name options, and failures of libfvv as such
// exceptions.
#pragma once

#include "fvv/types.h"

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace fvv {

// How messages name options. Libraries mark an option by its identifier; a front end
// spells it in the words of its users.
//
// "max-error" is, with a value and as a flag:
enum class Spelling {
  plain,        // max-error=1mm, no-delta
  command_line, // --max-error 1mm, --no-delta
  python,       // max_error='1mm', no_delta
  c,            // max_error=1mm, no_delta
};

// An option in a message, by its identifier: words in small letters with dashes between them.
std::string option_name(std::string_view identifier);
// An option and one of its values.
std::string option_name(std::string_view identifier, std::string_view value);

// A message with the names of its options spelled out.
std::string spell(std::string_view message, Spelling spelling);

// The identifier of the option that a message names first; empty if there is none.
std::string first_option(std::string_view message);

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

  // line: options in it are named by option_name().
  explicit Error(const std::string &line, Kind the_kind = failed)
      : std::runtime_error(spell(line, Spelling::plain)), kind(the_kind),
        marked(std::make_shared<const std::string>(line)) {}
  Error(const std::string &name, const std::string &text)
      : Error(name.empty() ? text : name + ": " + text, failed) {}

  // The line with options named as users of a language write them; what() has plain identifiers.
  std::string in(Spelling spelling) const { return spell(*marked, spelling); }
  // As it was given, for a line that goes on in another Error.
  const std::string &line() const { return *marked; }
  // The identifier of the option that the line names first; empty: none.
  std::string option() const { return first_option(*marked); }

  const Kind kind;

private:
  const std::shared_ptr<const std::string> marked; // shared, so that a copy does not throw
};

// Error::line(), or what() of other exceptions: for a line that goes on.
std::string line_of(const std::exception &error);

// Throws an Error (usage): "OPTION: TEXT".
[[noreturn]] inline void refuse_option(std::string_view identifier, const std::string &text) {
  throw Error(option_name(identifier) + ": " + text, Error::usage);
}

// Throws an Error with the line of a diagnostic. name: the file as the user wrote it.
[[noreturn]] void fail(const std::string &name, const fvv_diagnostic &diagnostic);
// Does the same when status is an error; otherwise does nothing.
void check(fvv_status status, const std::string &name, const fvv_diagnostic &diagnostic);

} // namespace fvv
