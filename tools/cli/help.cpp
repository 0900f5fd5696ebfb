#include "cli/help.h"

#include "cli/cli.h"
#include "cli/option_help.h"
#include "fvv/types.h"

#include <algorithm>
#include <iostream>
#include <numeric>
#include <sstream>

namespace fvv::cli {

namespace {

constexpr size_t text_column = 32, screen_width = 100;

// "-o, --output FILE": the name by which the app knows it.
std::string name_in(const std::string &usage) {
  const size_t first = usage.find("--");
  return usage.substr(first, usage.find_first_of(" =", first) - first);
}

// Words of text, broken at the width of the screen, from a column on.
std::string wrapped(const std::string &text, size_t column) {
  std::string out, line;
  size_t begin = 0;
  while (begin < text.size()) {
    const size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    if (!line.empty() && column + line.size() + 1 + word.size() > screen_width) {
      out += line + "\n" + std::string(column, ' ');
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    begin = end + 1;
  }
  return out + line;
}

// A line of the help: left column, text.
std::string row(std::string left, const std::string &text) {
  left = "  " + left;
  left += left.size() + 2 > text_column ? "\n" + std::string(text_column, ' ')
                                        : std::string(text_column - left.size(), ' ');
  return left + wrapped(text, text_column) + "\n";
}

std::string joined(const std::vector<std::string> &parts, const std::string &separator) {
  std::string out;
  for (const std::string &part : parts) out += (out.empty() ? "" : separator) + part;
  return out;
}

std::string row(const OptionHelp &option) {
  std::string text = option.text;
  if (!option.range.empty()) text += " " + option.range;
  if (!option.default_value.empty()) text += " (" + option.default_value + ")";
  const std::string value = option.is_positional || option.value.empty() ? "" : " " + option.value;
  return row(joined(option.names, ", ") + value, text);
}

// The lines of a paragraph as one; a full stop at the end of a line ends it.
std::string paragraphs(const std::string &text) {
  std::string out, paragraph;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    paragraph += (paragraph.empty() ? "" : " ") + line;
    if (line.empty() || line.back() != '.') continue;
    out += wrapped(paragraph, 0) + "\n";
    paragraph.clear();
  }
  return paragraph.empty() ? out : out + wrapped(paragraph, 0) + "\n";
}

class Help : public CLI::Formatter {
public:
  Help(std::vector<HelpSection> shown, std::vector<std::string> samples)
      : sections(std::move(shown)), examples(std::move(samples)) {}

  std::string make_help(const CLI::App *app, std::string, CLI::AppFormatMode mode) const override {
    std::string out = wrapped(app->get_description(), 0) + "\n" + make_usage(app, app->get_name());
    if (mode == CLI::AppFormatMode::Normal && !sections.empty()) {
      for (const HelpSection &section : sections) {
        out += "\n" + section.title + ":\n";
        for (const ShownOption &option : section.options) out += row(option.usage, option.text);
      }
    } else {
      const std::vector<OptionHelp> first = positionals(*app);
      if (!first.empty()) out += "\n";
      for (const OptionHelp &positional : first) out += row(positional);
      for (const OptionGroupHelp &group : groups(*app)) {
        out += "\n" + group.title + ":\n";
        for (const OptionHelp &option : group.options) out += row(option);
      }
    }
    if (!examples.empty()) out += "\nExamples:\n";
    for (const std::string &example : examples) out += "  " + example + "\n";
    return out + (app->get_footer().empty() ? "" : "\n" + paragraphs(app->get_footer()));
  }

  std::string json(const CLI::App &app) const {
    return help_json(app, positionals(app), groups(app), examples).dump(2);
  }

private:
  std::vector<OptionHelp> positionals(const CLI::App &app) const {
    std::vector<OptionHelp> out;
    for (const CLI::Option *option : app.get_options())
      if (!option->nonpositional()) out.push_back(describe(*option));
    return out;
  }

  std::vector<OptionGroupHelp> groups(const CLI::App &app) const {
    std::vector<OptionGroupHelp> out;
    std::vector<std::string> titles;
    for (const HelpSection &section : sections) titles.push_back(section.title);
    titles.push_back(sections.empty() ? "Options" : "More options");
    for (const std::string &title : titles) {
      OptionGroupHelp group = {title, {}};
      for (const CLI::Option *option : app.get_options())
        if (option->nonpositional() && !option->get_group().empty() &&
            (option->get_group() == "Options" ? titles.back() : option->get_group()) == title)
          group.options.push_back(describe(*option, value_name(*option)));
      if (!group.options.empty()) out.push_back(group);
    }
    return out;
  }

  // The word after the name in a section.
  std::string value_name(const CLI::Option &option) const {
    for (const HelpSection &section : sections)
      for (const ShownOption &shown : section.options) {
        if (shown.usage.find("--") == std::string::npos || name_in(shown.usage) != option.get_name())
          continue;
        const size_t space = shown.usage.rfind(' ');
        return space < shown.usage.find("--") ? "" : shown.usage.substr(space + 1);
      }
    return "";
  }

  const std::vector<HelpSection> sections;
  const std::vector<std::string> examples;
};

// Insertions, deletions, replacements and exchanges of neighbours that turn a into b (optimal string
// alignment).
size_t distance(const std::string &a, const std::string &b) {
  std::vector<std::vector<size_t>> rows(a.size() + 1, std::vector<size_t>(b.size() + 1));
  std::iota(rows[0].begin(), rows[0].end(), size_t(0));
  for (size_t i = 1; i <= a.size(); i++) {
    rows[i][0] = i;
    for (size_t j = 1; j <= b.size(); j++) {
      rows[i][j] =
          std::min({rows[i - 1][j] + 1, rows[i][j - 1] + 1, rows[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        rows[i][j] = std::min(rows[i][j], rows[i - 2][j - 2] + 1);
    }
  }
  return rows[a.size()][b.size()];
}

// The option that somebody may have meant; empty: none is near.
std::string near_name(const CLI::App &app, const std::string &given) {
  std::string best;
  size_t least = std::max<size_t>(2, given.size() / 3) + 1;
  for (const CLI::Option *option : app.get_options())
    for (const std::string &name :
         option->get_group().empty() ? std::vector<std::string>() : option->get_lnames()) {
      const std::string full = "--" + name;
      const size_t apart = full.compare(0, given.size(), given) == 0 ? 1 : distance(given, full);
      if (apart < least) {
        least = apart;
        best = full;
      }
    }
  return best;
}

} // namespace

void set_help(CLI::App &app, const std::string &tool, const std::vector<std::string> &examples,
              const std::vector<HelpSection> &sections) {
  app.name(tool);
  app.set_help_flag("-h,--help", sections.empty() ? "this text" : "the options that people need most");
  if (!sections.empty()) app.set_help_all_flag("--help-all", "all options");
  app.set_version_flag("--version", tool + " " + fvv_version(), "of " + tool);
  for (const HelpSection &section : sections)
    for (const ShownOption &option : section.options)
      if (option.usage.find("--") != std::string::npos)
        app.get_option(name_in(option.usage))->group(section.title);
  const auto help = std::make_shared<Help>(sections, examples);
  app.formatter(help);
  // Thrown while options are read, as the version: whatever else is required may be absent.
  app.add_flag_callback("--help-json", [&app, help] { throw CLI::CallForVersion(help->json(app), 0); })
      ->group("");
}

void make_former(CLI::Option &former) {
  former.group("");
}

bool is_given_formerly(const CLI::Option &former, const CLI::Option &now) {
  if (!former.count()) return false;
  // CLI has no name for options of no group.
  const std::string name = "--" + former.get_lnames().front();
  if (now.count())
    throw Error(now.get_name() + ": expected without " + name + ", its former name", Error::usage);
  warn(name + ": is called " + now.get_name() + " now; the next version does not know this name");
  return true;
}

int end_of_parsing(const CLI::App &app, const CLI::ParseError &error) {
  const int code = app.exit(error);
  if (code == 0) return done;
  // CLI has these after it refused an argument that it does not know.
  for (const std::string &given : app.remaining()) {
    if (given.compare(0, 2, "--") != 0) continue;
    const std::string name = given.substr(0, given.find('=')), meant = near_name(app, name);
    if (!meant.empty()) std::cerr << "Did you mean " << meant << " for " << name << "?\n";
  }
  return usage;
}

} // namespace fvv::cli
