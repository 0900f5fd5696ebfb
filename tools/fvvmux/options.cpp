#include "fvvmux/options.h"

#include "fvv_cxx/format.h"

namespace fvv {

namespace {

std::string in_words(const std::string &text) {
  return spell(text, Spelling::command_line);
}

std::string joined(const std::vector<std::string> &parts, char separator) {
  std::string out;
  for (const std::string &part : parts) out += (out.empty() ? "" : std::string(1, separator)) + part;
  return out;
}

// For the help alone: what is out of bounds is refused by the table, in its words.
CLI::Validator shown_bounds(const mux::OptionBounds &bounds) {
  return {[](std::string &) { return std::string(); },
          fvv::format("[%.10g..%.10g]", bounds.least, bounds.most)};
}

} // namespace

StreamOptions::StreamOptions(CLI::App &app) {
  for (const mux::Option &row : mux::option_table()) {
    Value &value = values.emplace_back(Value{&row, nullptr, nullptr, {}, {}});
    value.option = declare(app, row.name, value);
    if (row.former.empty()) continue;
    value.former = declare(app, row.former, value);
    cli::make_former(*value.former);
  }
  for (const Value &value : values) {
    for (const std::string &other : value.row->excludes) value.option->excludes(app.get_option("--" + other));
    for (const std::string &other : value.row->needs) value.option->needs(app.get_option("--" + other));
  }
}

CLI::Option *StreamOptions::declare(CLI::App &app, const std::string &name, Value &value) const {
  const mux::Option &row = *value.row;
  const std::string help = in_words(row.help);
  if (row.is_flag()) return app.add_flag("--" + name, value.flag, help);
  CLI::Option *option = row.is_list ? app.add_option("--" + name, value.list, help)->delimiter(',')
                                    : app.add_option("--" + name, value.text, help);
  option->type_name(row.choices.empty() ? row.value : joined(row.choices, '|'));
  option->default_str(row.text(mux::Options()));
  if (row.bounds) option->check(shown_bounds(*row.bounds));
  return option;
}

bool StreamOptions::is_given(const std::string &name) const {
  for (const Value &value : values)
    if (value.row->name == name) return value.is_given();
  return false;
}

void StreamOptions::apply(mux::Options &options) const {
  for (const Value &value : values) {
    if (!value.is_given()) continue;
    const mux::Option &row = *value.row;
    if (value.former) cli::is_given_formerly(*value.former, *value.option);
    mux::set_option(options, row.name,
                    row.is_flag() ? (value.flag ? "on" : "off")
                    : row.is_list ? joined(value.list, ',')
                                  : value.text);
  }
}

std::vector<cli::ShownOption> StreamOptions::shown(const std::string &group) {
  std::vector<cli::ShownOption> out;
  for (const mux::Option &row : mux::option_table())
    if (row.group == group && !row.brief.empty())
      out.push_back({"--" + row.name + (row.is_flag() ? "" : " " + row.value), in_words(row.brief)});
  return out;
}

} // namespace fvv
