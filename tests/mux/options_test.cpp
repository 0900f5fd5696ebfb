// The table of options: every row has texts that set it, and what is planned is part of a plan.
#include "fvv_mux/option_table.h"
#include "fvv_scene/file_io.h"
#include "mux/src/parts/plan_data.h"
#include "mux/src/planner.h"
#include "mux_fixture.h"

#include <map>
#include <set>

namespace {

// Options with a value of the row, and what it needs.
mux::Options with(const mux::Option &row, const std::string &text) {
  mux::Options options;
  for (const std::string &other : row.needs)
    mux::set_option(options, other, mux::find_option(other)->example);
  if (row.name == "atlas" || row.name == "bake-repeats") mux::set_option(options, "meshes", "f/%04d.obj");
  mux::set_option(options, row.name, text);
  return options;
}

} // namespace

TEST_CASE("every option is set by its texts, and has the text of its value") {
  std::set<std::string> names;
  for (const mux::Option &row : mux::option_table()) {
    INFO(row.name);
    CHECK(names.insert(row.name).second);
    CHECK(!row.help.empty());
    CHECK(!row.python.empty());
    CHECK(!row.since.empty());
    CHECK(row.group.empty() == row.brief.empty());
    const mux::Options defaults, options = with(row, row.example);
    CHECK(row.text(options) != row.text(defaults));
    CHECK(row.text(with(row, row.text(options))) == row.text(options));
    CHECK_NOTHROW(mux::settled(options));
    for (const std::string &word : row.choices) CHECK(row.text(with(row, word)) == word);
    if (!row.text(defaults).empty()) CHECK(row.text(with(row, row.text(defaults))) == row.text(defaults));
    for (const std::string &other : row.needs) CHECK(mux::find_option(other));
    for (const std::string &other : row.excludes) {
      REQUIRE(mux::find_option(other));
      mux::Options both = options;
      mux::set_option(both, other, mux::find_option(other)->example);
      CHECK_THROWS_WITH(mux::settled(both), Catch::Contains(row.name) && Catch::Contains(other));
    }
    if (row.bounds) {
      CHECK_THROWS_AS(with(row, std::to_string(row.bounds->least - 1)), fvv::Error);
      CHECK_THROWS_AS(with(row, std::to_string(row.bounds->most * 2 + 1)), fvv::Error);
    }
    if (row.is_flag()) CHECK(row.text(with(row, "off")).empty());
    if (!row.former.empty()) {
      CHECK(mux::find_option(row.former) == &row);
      CHECK(names.insert(row.former).second);
    }
  }
  CHECK(names.size() > 50);
}

TEST_CASE("a plan has the options that are planned, and no others") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  const scene::Capture capture = make_capture(folder, shape);
  FileOptions options = options_for(folder);
  options.capture = capture.path;
  const mux::Plan plan = mux::make_plan(options, {});
  const std::map<std::string, std::string> of_this_capture = {
      {"frames", "1-3"}, {"cameras", "3"}, {"codec", "hevc"}};
  for (const mux::Option &row : mux::option_table()) {
    INFO(row.name);
    mux::PlanData data;
    data.plan = plan;
    data.capture = scene::read_file(capture.path, 1 << 20);
    const auto own = of_this_capture.find(row.name);
    row.set(data.plan.options, own == of_this_capture.end() ? row.example : own->second);
    const std::string set = row.text(data.plan.options);
    const mux::PlanData found = mux::load_plan(mux::save_plan(data), "plan", {});
    CHECK(row.text(found.plan.options) == (row.is_planned ? set : row.text(mux::Options())));
    for (const mux::Option &other : mux::option_table())
      if (other.is_planned && other.name != row.name)
        CHECK(other.text(found.plan.options) == other.text(data.plan.options));
  }
}

TEST_CASE("messages name options in the words of who reads them") {
  mux::Options options;
  try {
    mux::set_option(options, "max-error", "1 inch");
    FAIL("expected an Error");
  } catch (const fvv::Error &error) {
    CHECK(error.option() == "max-error");
    CHECK(error.kind == fvv::Error::usage);
    CHECK(error.in(fvv::Spelling::command_line).rfind("--max-error: expected pixels", 0) == 0);
    CHECK(error.in(fvv::Spelling::python).rfind("max_error: expected pixels", 0) == 0);
    CHECK(error.in(fvv::Spelling::c).rfind("max_error: expected pixels", 0) == 0);
    CHECK(std::string(error.what()).rfind("max-error: expected pixels", 0) == 0);
  }
  const std::string text =
      "as " + fvv::option_name("crop", "none") + " says, with " + fvv::option_name("live");
  CHECK(fvv::spell(text, fvv::Spelling::command_line) == "as --crop none says, with --live");
  CHECK(fvv::spell(text, fvv::Spelling::python) == "as crop='none' says, with live");
  CHECK(fvv::spell(text, fvv::Spelling::c) == "as crop=none says, with live");
  CHECK(fvv::spell("without marks", fvv::Spelling::python) == "without marks");
  CHECK(fvv::first_option("none").empty());
  CHECK(fvv::first_option(text) == "crop");
}
