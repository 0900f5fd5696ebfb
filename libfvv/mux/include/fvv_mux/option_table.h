// All options of a stream, in one table: command lines, completions, references, bindings and plans are made
// from it.
#pragma once

#include "fvv_mux/options.h"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::mux {

struct OptionBounds {
  double least, most;
  bool whole; // numbers without a fraction
};

// Texts name other options as fvv::option_name() does.
struct Option {
  std::string name;    // "max-error": the identifier, by which set_option() and messages know it
  std::string former;  // what the version before called it; empty: the same
  std::string since;   // version of the library
  std::string group;   // heading in a reference; empty: "More options"
  std::string brief;   // a few words for a help on one screen; empty: it is not there
  std::string value;   // a name for the value: "RATE"; empty: a flag, whose texts are "on" and "off"
  std::string help;    // what it does and, where that is no text, its default
  std::string python;  // type of the value in Python's notation
  std::string example; // a value other than the default, which fits without other options but those of needs
  std::vector<std::string> choices;
  std::optional<OptionBounds> bounds;
  std::vector<std::string> needs, excludes; // other options of the table
  char separator = ',';                     // between the parts of a value that has several
  bool is_list = false;                     // of any texts: each may be given apart
  bool of_capture = false;                  // of captures on disk; not for an Encoder
  bool is_planned = true;                   // part of a plan; others are of one run on one machine

  // Throws Error (usage) that names the option, what was expected and what was found.
  std::function<void(Options &, const std::string &text)> set;
  // The value as a text that set takes; empty: no value, or the flag is off.
  std::function<std::string(const Options &)> text;

  bool is_flag() const { return value.empty(); }
};

// In the order of references.
const std::vector<Option> &option_table();

// By its name or former name; NULL: there is none.
const Option *find_option(std::string_view name);

} // namespace fvv::mux
