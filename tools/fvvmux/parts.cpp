#include "fvvmux/parts.h"
#include "cli/output.h"
#include "fvv_cxx/range.h"
#include "fvv_mux/parts.h"
#include "fvv_scene/capture.h"
#include "fvv_scene/file_io.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <unistd.h>

namespace fvv {

namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t largest_plan = uint64_t(4) << 30, largest_report = uint64_t(64) << 20;
constexpr const char *plan_name = "plan.cbor";

std::string part_name(size_t group) {
  return "group-" + std::to_string(group) + ".fvv";
}

std::string report_name(size_t group) {
  return "group-" + std::to_string(group) + ".json";
}

std::string inside(const std::string &folder, const std::string &name) {
  return folder + (folder.empty() || folder.back() != '/' ? "/" : "") + name;
}

bool is_there(const std::string &path) {
  return access(path.c_str(), F_OK) == 0;
}

mux::PartPlan read_plan(const std::string &folder, const std::string &capture = {}) {
  const std::string path = inside(folder, plan_name);
  return {scene::read_file(path, largest_plan), path, capture};
}

mux::Observer observer_of(std::optional<cli::Progress> &progress, bool &warned) {
  mux::Observer observer;
  observer.on_warning = [&warned](const std::string &text) {
    warned = true;
    cli::warn(text);
  };
  observer.on_progress = [&progress](size_t frames) {
    if (progress) progress->step(frames);
  };
  return observer;
}

void print(bool as_json, const char *key, const Json &json, const std::string &text) {
  const Json document = {{"fvvmux", 1}, {key, json}};
  std::fputs((as_json ? document.dump(2, ' ', false, Json::error_handler_t::replace) : text).c_str(), stdout);
  std::fputs("\n", stdout);
}

cli::Exit write_plan(const std::string &path, const mux::Options &options, bool force, bool as_json) {
  cli::OutputFolder folder(path, force, [&](const std::function<void(const std::string &)> &visit) {
    scene::visit_files(scene::load_capture(scene::description_file(options.capture)), visit);
  });
  bool warned = false;
  std::optional<cli::Progress> progress;
  const auto first = folder.create(part_name(0));
  const mux::PartPlan plan(options, observer_of(progress, warned),
                           [&](const void *bytes, size_t size) { first->write(bytes, size); });
  first->close();
  folder.write(report_name(0), plan.first_report());
  folder.write(plan_name, plan.bytes());
  for (size_t group = 1; group < plan.group_count(); group++) {
    folder.expect(part_name(group));
    folder.expect(report_name(group));
  }
  folder.commit();
  print(as_json, "plan", {{"folder", path}, {"groups", plan.group_count()}, {"frames", plan.frame_count()}},
        path + ": a plan of " + std::to_string(plan.frame_count()) + " frames in " +
            std::to_string(plan.group_count()) + " groups, of which group 0 is encoded");
  return warned ? cli::loss : cli::done;
}

cli::Exit write_parts(const std::string &folder, const PartCommand &command, uint32_t threads, bool force,
                      bool as_json) {
  const Range range = parse_range("part", command.part);
  const mux::PartPlan plan = read_plan(folder, command.capture);
  if (range.last >= int64_t(plan.group_count()))
    throw Error("--part: expected numbers from 0 to " + std::to_string(plan.group_count() - 1) + ", found " +
                    command.part,
                Error::usage);
  bool warned = false;
  size_t frames = 0;
  for (int64_t group = range.first; group <= range.last; group++) frames += plan.frames_of(size_t(group));
  std::optional<cli::Progress> progress(std::in_place, "fvvmux: " + folder, frames);
  for (auto group = size_t(range.first); group <= size_t(range.last); group++) {
    const cli::Inputs inputs = [&](const std::function<void(const std::string &)> &visit) {
      visit(inside(folder, plan_name));
      for (const std::string &path : plan.files_of(group)) visit(path);
    };
    cli::OutputFile stream(inside(folder, part_name(group)), force, inputs);
    cli::OutputFile report(inside(folder, report_name(group)), force, inputs);
    const std::string text = plan.encode(
        group, threads, [&](const void *bytes, size_t size) { stream.write(bytes, size); },
        observer_of(progress, warned));
    report.write(text.data(), text.size());
    cli::commit({&stream, &report});
  }
  progress.reset();
  print(as_json, "parts", {{"folder", folder}, {"first", range.first}, {"last", range.last}},
        folder + ": groups " + std::to_string(range.first) + " to " + std::to_string(range.last) + " of " +
            std::to_string(plan.group_count()));
  return warned ? cli::loss : cli::done;
}

} // namespace

Joined merge_parts(const std::string &folder, const std::string &path, bool force) {
  const mux::PartPlan plan = read_plan(folder);
  std::vector<bool> there;
  for (size_t group = 0; group < plan.group_count(); group++)
    there.push_back(is_there(inside(folder, part_name(group))) &&
                    is_there(inside(folder, report_name(group))));
  plan.check_complete(folder, there);
  cli::OutputFile output(path, force, [&](const std::function<void(const std::string &)> &visit) {
    visit(inside(folder, plan_name));
    for (size_t group = 0; group < plan.group_count(); group++) {
      visit(inside(folder, part_name(group)));
      visit(inside(folder, report_name(group)));
    }
  });
  bool warned = false;
  std::optional<cli::Progress> progress(std::in_place, "fvvmux: " + path, plan.frame_count());
  mux::Merged merged = plan.merge(
      [&](size_t group) {
        return mux::Part{std::make_unique<InputFile>(inside(folder, part_name(group))),
                         scene::read_file(inside(folder, report_name(group)), largest_report)};
      },
      [&](const void *bytes, size_t size) { output.write(bytes, size); }, observer_of(progress, warned));
  progress.reset();
  output.commit();
  return {std::move(merged), plan.group_count()};
}

namespace {

cli::Exit merge(const std::string &folder, const std::string &path, bool force, bool as_json) {
  const bool piped = path == "-";
  if (piped && as_json) throw Error("--json: standard output is taken by the stream (-o -)", Error::usage);
  const Joined joined = merge_parts(folder, path, force);
  for (const std::string &text : joined.stream.warnings) cli::warn(text);
  if (!piped)
    print(as_json, "merged", {{"file", path}, {"groups", joined.groups}, {"bytes", joined.stream.bytes}},
          path + ": " + std::to_string(joined.stream.bytes) + " bytes from " + std::to_string(joined.groups) +
              " parts");
  return joined.stream.warnings.empty() ? cli::done : cli::loss;
}

} // namespace

void add_part_options(CLI::App &app, PartCommand &command) {
  auto *plan = app.add_option(
      "--plan", command.plan,
      "plan the stream, encode its first group, and write both as a folder, for other processes and machines "
      "that encode the other groups with --part (docs/encoding/parts.md)");
  auto *part = app.add_option("--part", command.part,
                              "CAPTURE is the folder of a plan: encode these groups of it, 3 or 3-7")
                   ->excludes(plan);
  app.add_flag("--merge", command.merge,
               "CAPTURE is the folder of a plan, with all its parts: write the stream to -o, with the bytes "
               "that one run with the plan's options writes")
      ->excludes(plan)
      ->excludes(part);
  app.add_option("--capture", command.capture, "for --part: where the capture is now, if it has moved")
      ->needs(part);
}

void check_part_options(const CLI::App &app, const PartCommand &command) {
  const std::string name = command.merge ? "--merge" : command.part.empty() ? "--plan" : "--part";
  const std::set<std::string> common = {"CAPTURE", "--force", "--json"};
  const std::set<std::string> more = command.merge
                                         ? std::set<std::string>{"--merge", "--output"}
                                         : std::set<std::string>{"--part", "--capture", "--threads"};
  const std::set<std::string> never = {"--output", "--segments", "--verify", "--write-capture",
                                       "--report"}; // of --plan
  for (const CLI::Option *option : app.get_options()) {
    const std::string given = option->get_name();
    const bool fits = name == "--plan" ? !never.count(given) : common.count(given) || more.count(given);
    if (option->count() && !fits) throw CLI::ExcludesError(given, name);
  }
  if (command.merge && !app.get_option("--output")->count()) throw CLI::RequiredError("--output");
}

cli::Exit run_part_command(const PartCommand &command, const mux::Options &options, const std::string &output,
                           bool force, bool as_json) {
  if (!command.plan.empty()) return write_plan(command.plan, options, force, as_json);
  if (command.merge) return merge(options.capture, output, force, as_json);
  return write_parts(options.capture, command, options.threads, force, as_json);
}

} // namespace fvv
