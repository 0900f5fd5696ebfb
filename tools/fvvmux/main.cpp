// fvvmux: packs a capture into a fvv stream. Argument parsing only.
#include "cli/cli.h"
#include "cli/help.h"
#include "cli/output.h"
#include "fvv_mux/muxer.h"
#include "fvv_mux/report.h"
#include "fvv_mux/segments.h"
#include "fvv_scene/inputs.h"
#include "fvvmux/options.h"
#include "fvvmux/parts.h"
#include "fvvmux/realtime.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>
#include <unistd.h>

using namespace fvv;

namespace {

constexpr const char *footer =
    "Exit code: 0 done, 1 failed, 2 usage, 3 done with warnings. A run that fails, also by --verify, leaves\n"
    "no file and no folder behind (docs/tools/outputs.md).\n"
    "spec/fvvmux.schema.json describes the output of --json.";

struct Outputs {
  std::string stream;   // "-": standard output
  std::string segments; // folder
  std::string capture;  // capture.json
  std::string report;   // page
  bool force = false;
};

void add_files(CLI::App &app, std::string &capture, Outputs &outputs) {
  app.add_option("CAPTURE", capture,
                 "capture.json (spec/capture.md) or its folder; or the folder of a COLMAP model or of "
                 "nerfstudio's transforms.json; or left out, with --meshes (docs/tools/fvvmux-inputs.md)")
      ->type_name("FILE.json|fvv");
  app.add_option("-o,--output", outputs.stream, "file to write; - is standard output")->type_name("FILE.fvv");
  app.add_option("--write-capture", outputs.capture,
                 "write the capture.json that inputs such as --meshes stand for; -o may be left out then")
      ->type_name("FILE.json");
  app.add_option(
         "--report", outputs.report,
         "write the summary as a page for browsers besides, with charts of what the bytes are of and of "
         "what --view-loss tried (docs/encoding/view-loss.md)")
      ->type_name("FILE.html");
  app.add_option(
         "--segments", outputs.segments,
         "write the stream as a folder besides: configuration, a file for each group, manifest.json, for "
         "hosts that break ranges (docs/tools/fvvserve.md). CAPTURE may be a .fvv file then: it is cut up as "
         "it "
         "is, and -o is left out")
      ->type_name("FOLDER");
  app.add_flag(
      "--force", outputs.force,
      "replace an existing file, and a folder of segments that fvvmux wrote (docs/tools/outputs.md)");
}

// What --help shows: of each group options of the command, those of the stream, and others of the command.
// --help-all has everything.
std::vector<cli::HelpSection> help_sections() {
  struct Group {
    const char *title;
    std::vector<cli::ShownOption> before, after;
  };
  const std::vector<Group> groups = {
      {"Files",
       {{"CAPTURE", "capture.json or its folder, or one of COLMAP or nerfstudio"},
        {"-o, --output FILE", "the stream; - is standard output"}},
       {{"--segments FOLDER", "also as files for hosts without range requests"},
        {"--force", "replace what exists (docs/tools/outputs.md)"},
        {"--json", "print the summary as JSON"}}},
      {"Without a capture.json (docs/tools/fvvmux-inputs.md)",
       {},
       {{"--write-capture FILE", "the capture.json that was understood"}}},
      {"Meshes", {}, {}},
      {"Pictures", {}, {}},
      {"What is left out", {}, {}},
      {"Running",
       {},
       {{"--realtime", "pack frames as they arrive; --max-delay, --idle (docs/guide/live.md)"},
        {"--plan FOLDER", "encode on many machines; --part, --merge (docs/encoding/parts.md)"},
        {"--help-all", "all options, also for players' texturing, tiles, sound and ladders"},
        {"--version", "of fvvmux"}}}};
  std::vector<cli::HelpSection> out;
  for (const Group &group : groups) {
    cli::HelpSection section = {group.title, group.before};
    for (const auto &options : {StreamOptions::shown(group.title), group.after})
      section.options.insert(section.options.end(), options.begin(), options.end());
    out.push_back(section);
  }
  return out;
}

const std::vector<std::string> examples = {
    "fvvmux players -o players.fvv",
    "fvvmux --meshes 'f/%04d.obj' --atlas 'f/%04d.png' --fps 30 -o f.fvv",
    "fvvmux players -o players.fvv --quality 38dB --max-error 0.3 --codec hevc --ladder 1,0.75,0.5",
};

struct WrittenSegments {
  std::string folder;
  mux::Segments sums;

  std::string text() const {
    return folder + ": " + std::to_string(sums.bytes) + " bytes in " + std::to_string(sums.groups) +
           " groups and a configuration" +
           (sums.rungs > 1 ? " of each of " + std::to_string(sums.rungs) + " rungs" : "") + "\n";
  }
  nlohmann::ordered_json json() const {
    nlohmann::ordered_json out = {{"folder", folder}, {"groups", sums.groups}, {"bytes", sums.bytes}};
    if (sums.rungs > 1) out["rungs"] = sums.rungs;
    return out;
  }
};

// folder: opened before the work that takes time.
WrittenSegments write_segments(const InputFile &stream, const std::string &name, cli::OutputFolder &folder) {
  const mux::Segments sums = mux::write_segments(
      stream, [&](const std::string &part, const std::function<void(const mux::Sink &)> &fill) {
        const auto out = folder.create(part);
        fill([&](const void *bytes, size_t size) { out->write(bytes, size); });
        out->close();
      });
  return {name, sums};
}

// Segments of an existing stream.
cli::Exit cut_up(const mux::Options &options, const Outputs &outputs, bool as_json) {
  cli::OutputFolder folder(outputs.segments, outputs.force, cli::inputs({options.capture}));
  const WrittenSegments segments = write_segments(InputFile(options.capture), outputs.segments, folder);
  folder.commit();
  const nlohmann::ordered_json json = {{"fvvmux", 1}, {"segments", segments.json()}};
  std::fputs((as_json ? json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n"
                      : segments.text())
                 .c_str(),
             stdout);
  return cli::done;
}

// Of files that a run reads.
cli::Inputs files_of(const mux::Options &options) {
  return [&](const std::function<void(const std::string &)> &visit) {
    scene::visit_files(scene::load_capture(options.capture, options.inputs, mux::memory_limit_of(options)),
                       visit);
  };
}

void write_capture(const mux::Options &options, const std::string &path, cli::OutputFile &file) {
  const std::string text =
      scene::describe_inputs(options.capture, options.inputs, path, nullptr, mux::memory_limit_of(options));
  file.write(text.data(), text.size());
}

cli::Exit describe(const mux::Options &options, const Outputs &outputs) {
  cli::OutputFile file(outputs.capture, outputs.force, files_of(options));
  write_capture(options, outputs.capture, file);
  file.commit();
  return cli::done;
}

cli::Exit pack(const mux::Options &options, const Outputs &outputs, bool as_json) {
  const bool piped = outputs.stream == "-";
  const cli::Inputs captured = files_of(options);
  if (piped && as_json) throw Error("--json: standard output is taken by the stream (-o -)", Error::usage);
  // All outputs are opened before the work that takes time.
  cli::OutputFile output(outputs.stream, outputs.force, captured);
  if (!output.is_regular() && (!outputs.segments.empty() || options.verify))
    throw Error(std::string(options.verify ? "--verify" : "--segments") + ": " +
                    (piped ? "standard output" : outputs.stream) + " cannot be read back",
                Error::usage);
  std::optional<cli::OutputFolder> folder;
  if (!outputs.segments.empty()) folder.emplace(outputs.segments, outputs.force, captured);
  std::optional<cli::OutputFile> capture;
  if (!outputs.capture.empty()) {
    capture.emplace(outputs.capture, outputs.force, captured);
    write_capture(options, outputs.capture, *capture);
  }
  std::optional<cli::OutputFile> page;
  if (!outputs.report.empty()) page.emplace(outputs.report, outputs.force, captured);
  std::optional<cli::Progress> progress;
  mux::Observer observer;
  observer.on_warning = cli::warn;
  observer.on_progress = [&](size_t frames) {
    if (progress) progress->step(frames);
  };
  mux::Muxer muxer(options, observer);
  progress.emplace("fvvmux: " + outputs.stream, muxer.frame_count());
  mux::Report report = muxer.run([&](const void *bytes, size_t size) { output.write(bytes, size); });
  if (options.verify) {
    progress.emplace("fvvmux: verifying " + outputs.stream, report.frames);
    report.verdict = muxer.verify(output.written(), outputs.stream);
  }
  progress.reset();
  std::optional<WrittenSegments> segments;
  std::vector<cli::Output *> all = {&output};
  if (capture) all.push_back(&*capture);
  if (page) {
    const std::string text = mux::report_html(report, outputs.stream, Spelling::command_line);
    page->write(text.data(), text.size());
    all.push_back(&*page);
  }
  if (folder) {
    segments = write_segments(InputFile(output.written(), outputs.stream), outputs.segments, *folder);
    all.push_back(&*folder);
  }
  cli::commit(all);
  if (as_json) {
    nlohmann::ordered_json json =
        nlohmann::ordered_json::parse(mux::report_json(report, outputs.stream, Spelling::command_line));
    if (segments) json["segments"] = segments->json();
    std::printf("%s\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
  } else if (!piped || isatty(STDERR_FILENO)) {
    const std::string text =
        mux::report_text(report, outputs.stream, Spelling::command_line) + (segments ? segments->text() : "");
    std::fputs(text.c_str(), piped ? stderr : stdout);
  }
  return report.warned ? cli::loss : cli::done;
}

// A pattern without quotes is a list of files: the first is the value of --meshes, the second comes as
// CAPTURE, the others are left over.
bool may_be_list(const std::vector<std::string> &rest, bool has_meshes) {
  return rest.empty() || (has_meshes && std::none_of(rest.begin(), rest.end(), [](const std::string &word) {
                            return word.empty() || word[0] == '-';
                          }));
}

void join_list(mux::Options &options, const std::vector<std::string> &rest) {
  const std::string &first = options.inputs.meshes;
  const auto extension = [](const std::string &name) { return std::filesystem::path(name).extension(); };
  if (first.empty() || (rest.empty() && extension(options.capture) != extension(first))) return;
  std::vector<std::string> files = rest;
  files.insert(files.begin(), {first, options.capture});
  options.inputs.meshes = scene::pattern_of_files("meshes", files);
  options.capture.clear();
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app{"Pack meshes, pictures and cameras of a capture into a fvv stream."};
  mux::Options options;
  options.threads = std::clamp(std::thread::hardware_concurrency(), 1u, 256u);
  Outputs outputs;
  PartCommand command;
  RealtimeCommand realtime;
  bool as_json = false;
  add_files(app, options.capture, outputs);
  const StreamOptions given(app);
  add_part_options(app, command);
  add_realtime_options(app, realtime);
  app.add_flag("--json", as_json, "print the summary as JSON");
  app.footer(footer);
  cli::set_help(app, "fvvmux", examples, help_sections());
  try {
    app.allow_extras();
    app.parse(argc, argv);
    if (!may_be_list(app.remaining(), given.is_given("meshes"))) throw CLI::ExtrasError(app.remaining());
    if (command.is_given()) check_part_options(app, command);
    const bool cuts = !outputs.segments.empty() && mux::is_stream(options.capture);
    const bool describes = !outputs.capture.empty();
    if (options.capture.empty() && !given.is_given("meshes")) throw CLI::RequiredError("CAPTURE or --meshes");
    if (outputs.stream.empty() && !cuts && !describes && !command.is_given())
      throw CLI::RequiredError("--output");
    if (outputs.stream.empty() && !outputs.report.empty()) throw CLI::RequiredError("--output");
    if (!outputs.stream.empty() && cuts) throw CLI::ExcludesError("--output", "--segments of a .fvv file");
  } catch (const CLI::ParseError &error) {
    return cli::end_of_parsing(app, error);
  }
  return cli::run("fvvmux", [&] {
    cli::keep_freed_memory();
    if (realtime.on) options.preset = mux::Preset::live;
    given.apply(options);
    join_list(options, app.remaining());
    options = mux::settled(options);
    if (command.is_given()) return run_part_command(command, options, outputs.stream, outputs.force, as_json);
    if (realtime.on) return run_realtime(realtime, options, outputs.stream, outputs.force, as_json);
    if (outputs.stream.empty() && !outputs.capture.empty()) return describe(options, outputs);
    return outputs.stream.empty() ? cut_up(options, outputs, as_json) : pack(options, outputs, as_json);
  });
}
