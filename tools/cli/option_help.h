// An option of CLI11 in the words of the help and of --help-json.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace fvv::cli {

struct OptionHelp {
  std::vector<std::string> names; // "-o", "--output"; of a positional argument its name
  std::string value;              // "FILE"; empty: a flag
  std::string text, default_value, range;
  std::vector<std::string> choices, extensions; // without a dot
  enum class Takes { word, file, folder } takes = Takes::word;
  bool is_positional = false, is_required = false, is_repeated = false;
  std::vector<std::string> needs, excludes;
};

// value: a name for it, for options that declare none.
OptionHelp describe(const CLI::Option &option, const std::string &value = "");

// Title, options; positional arguments and options that are hidden are left out.
struct OptionGroupHelp {
  std::string title;
  std::vector<OptionHelp> options;
};

// The document of --help-json: fvv_help (the version of its shape, 1), tool, version, summary, positionals,
// usage, groups, examples, exit_codes and notes. What an option does not have is absent, but for the value of
// flags, which is null.
nlohmann::ordered_json help_json(const CLI::App &app, const std::vector<OptionHelp> &positionals,
                                 const std::vector<OptionGroupHelp> &groups,
                                 const std::vector<std::string> &examples);

} // namespace fvv::cli
