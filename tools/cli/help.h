// Help on one screen, all of it on request or as JSON, and near names for options that do not exist.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
class ParseError;
} // namespace CLI

namespace fvv::cli {

// An option as the short help shows it: "-o, --output FILE", and a few words.
struct ShownOption {
  std::string usage, text;
};

struct HelpSection {
  std::string title;
  std::vector<ShownOption> options;
};

// To be called once, after all options and the footer are declared: --version, --help with lines of at most
// 100 columns, and --help-json, which is not in the help: all options for manual pages, completions and
// references. With sections, --help shows these alone, --help-all everything, in the same groups. Throws
// CLI's OptionNotFound for an option of a section that the app does not have.
//
// What --help-json reports of a value is read from the option's type_name: "a|b" are choices; FOLDER is a
// folder; FILE and PATTERN are files, FILE.fvv or FILE.png|exr those with such extensions; other words are
// names alone. A positional argument has its type_name for this, and is shown by its name.
void set_help(CLI::App &app, const std::string &tool, const std::vector<std::string> &examples,
              const std::vector<HelpSection> &sections = {});

// Makes an option the former name of another for one version: it is not in the help.
void make_former(CLI::Option &former);
// Whether the former name was given; if so, with a warning that names the other. Error (usage) for both.
bool is_given_formerly(const CLI::Option &former, const CLI::Option &now);

// What a command line that was refused, or that requested help or the version, ends with: prints it, and
// returns the exit code.
int end_of_parsing(const CLI::App &app, const CLI::ParseError &error);

} // namespace fvv::cli
