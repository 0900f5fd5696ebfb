#include "cli/option_help.h"

#include "fvv/types.h"

#include <algorithm>
#include <regex>
#include <sstream>

namespace fvv::cli {

namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> split(const std::string &text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

bool begins_with(const std::string &text, const std::string &start) {
  return text.compare(0, start.size(), start) == 0;
}

// CLI11's own names of types say more to a programmer than to a reader.
std::string plain(const std::string &type) {
  return type == "UINT" || type == "INT" || type == "FLOAT" ? "N" : type;
}

// Former names are not in the help.
std::vector<std::string> long_names(const std::set<CLI::Option *> &options) {
  std::vector<std::string> names;
  for (const CLI::Option *option : options)
    if (!option->get_group().empty()) names.push_back(option->get_name());
  std::sort(names.begin(), names.end()); // the set is in the order of addresses
  return names;
}

// What is said of the value: a range, choices, or what kind of file it names.
void read_type(OptionHelp &out, const std::string &type, const std::string &constraint) {
  const size_t bracket = constraint.find('[');
  if (bracket != std::string::npos)
    out.range = std::regex_replace(constraint.substr(bracket), std::regex(" - "), "..");
  const std::string name = type.substr(0, type.find('.'));
  if (name == "FILE" || name == "PATTERN") {
    out.takes = OptionHelp::Takes::file;
    if (name.size() < type.size()) out.extensions = split(type.substr(name.size() + 1), '|');
  } else if (name == "FOLDER") {
    out.takes = OptionHelp::Takes::folder;
  } else if (type.find('|') != std::string::npos) {
    out.choices = split(type, '|');
  } else if (begins_with(constraint, "{")) { // of IsMember
    out.choices = split(constraint.substr(1, constraint.find('}') - 1), ',');
  }
}

Json json_of(const OptionHelp &option) {
  Json out;
  if (option.is_positional)
    out["name"] = option.names.front();
  else
    out["names"] = option.names;
  if (!option.is_positional) out["value"] = option.value.empty() ? Json() : Json(option.value);
  out["text"] = option.text;
  if (!option.default_value.empty()) out["default"] = option.default_value;
  if (!option.range.empty()) out["range"] = option.range;
  if (!option.choices.empty()) out["choices"] = option.choices;
  if (option.takes != OptionHelp::Takes::word)
    out["takes"] = option.takes == OptionHelp::Takes::file ? "file" : "folder";
  if (!option.extensions.empty()) out["extensions"] = option.extensions;
  if (option.is_required) out["required"] = true;
  if (option.is_repeated) out["repeated"] = true;
  if (!option.needs.empty()) out["needs"] = option.needs;
  if (!option.excludes.empty()) out["excludes"] = option.excludes;
  return out;
}

} // namespace

OptionHelp describe(const CLI::Option &option, const std::string &value) {
  OptionHelp out;
  out.is_positional = !option.nonpositional();
  if (out.is_positional) {
    out.names = {option.get_name(true)};
  } else {
    for (const std::string &name : option.get_snames()) out.names.push_back("-" + name);
    for (const std::string &name : option.get_lnames()) out.names.push_back("--" + name);
  }
  out.text = option.get_description();
  out.is_required = option.get_required();
  out.needs = long_names(option.get_needs());
  out.excludes = long_names(option.get_excludes());
  if (option.get_type_size() == 0) return out; // a flag
  const std::string whole = option.get_type_name();
  const size_t colon = whole.find(':');
  std::string type = whole.substr(0, colon);
  if (type == "TEXT" && !value.empty()) type = value;
  read_type(out, type, colon == std::string::npos ? "" : whole.substr(colon + 1));
  out.value = plain(type);
  out.default_value = option.get_default_str();
  out.is_repeated = option.get_items_expected_max() >= CLI::detail::expected_max_vector_size;
  return out;
}

Json help_json(const CLI::App &app, const std::vector<OptionHelp> &positionals,
               const std::vector<OptionGroupHelp> &groups, const std::vector<std::string> &examples) {
  Json out = {{"fvv_help", 1},
              {"tool", app.get_name()},
              {"version", fvv_version()},
              {"summary", app.get_description()}};
  std::string usage = app.get_name() + " [OPTIONS]";
  out["positionals"] = Json::array();
  for (const OptionHelp &positional : positionals) {
    const std::string name = positional.names.front() + (positional.is_repeated ? "..." : "");
    usage += positional.is_required ? " " + name : " [" + name + "]";
    out["positionals"].push_back(json_of(positional));
  }
  out["usage"] = usage;
  out["groups"] = Json::array();
  for (const OptionGroupHelp &group : groups) {
    Json options = Json::array();
    for (const OptionHelp &option : group.options) options.push_back(json_of(option));
    out["groups"].push_back({{"title", group.title}, {"options", options}});
  }
  out["examples"] = examples;
  // "Exit code: 0 done, 1 failed, ..." is a sentence of every footer; the others are notes.
  std::string footer = std::regex_replace(app.get_footer(), std::regex("\n"), " ");
  std::smatch found;
  Json codes = {
      {{"code", 0}, {"text", "done"}}, {{"code", 1}, {"text", "failed"}}, {{"code", 2}, {"text", "usage"}}};
  if (std::regex_search(footer, found, std::regex(" ?Exit code: ([^.]*)\\."))) {
    codes = Json::array();
    const std::string list = ", " + found[1].str();
    const std::regex start(", ([0-9]) ");
    for (std::sregex_iterator code(list.begin(), list.end(), start), end; code != end;) {
      const size_t begin = size_t(code->position() + code->length());
      const int number = std::stoi((*code)[1]);
      const size_t next = ++code == end ? list.size() : size_t(code->position());
      codes.push_back({{"code", number}, {"text", list.substr(begin, next - begin)}});
    }
    footer = found.prefix().str() + found.suffix().str();
  }
  out["exit_codes"] = codes;
  out["notes"] = footer.substr(std::min(footer.size(), footer.find_first_not_of(' ')));
  return out;
}

} // namespace fvv::cli
