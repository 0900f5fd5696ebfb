// The options of a stream on the command line, from the table of fvv_mux.
#pragma once

#include "cli/help.h"
#include "fvv_mux/option_table.h"

#include <CLI/CLI.hpp>
#include <list>
#include <string>
#include <vector>

namespace fvv {

class StreamOptions {
public:
  // Declares all options of the table. app: refers to this object from then on.
  explicit StreamOptions(CLI::App &app);
  StreamOptions(const StreamOptions &) = delete;
  StreamOptions &operator=(const StreamOptions &) = delete;

  bool is_given(const std::string &name) const;
  // Sets what was given, with a warning for former names. Throws Error (usage).
  void apply(mux::Options &options) const;

  // Those of a group for a help on one screen.
  static std::vector<cli::ShownOption> shown(const std::string &group);

private:
  struct Value {
    const mux::Option *row;
    CLI::Option *option, *former; // former: NULL if there is none
    std::string text;
    std::vector<std::string> list; // in place of text, where the row is one
    bool flag = false;

    bool is_given() const { return option->count() || (former && former->count()); }
  };

  CLI::Option *declare(CLI::App &app, const std::string &name, Value &value) const;

  std::list<Value> values; // the app has pointers to them
};

} // namespace fvv
