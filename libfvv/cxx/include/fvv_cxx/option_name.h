// How messages name options. Libraries mark an option by its identifier; the program that shows the message
// spells it in the words of its users.
#pragma once

#include <string>
#include <string_view>

namespace fvv {

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

} // namespace fvv
