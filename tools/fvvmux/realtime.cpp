#include "fvvmux/realtime.h"
#include "cli/output.h"
#include "fvv_mux/realtime.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace fvv {

namespace {

using Json = nlohmann::ordered_json;

// One line, on standard error: the stream may be on standard output.
void print(const mux::RealtimeEvent &event, bool as_json) {
  const std::string text = spell(event.text, Spelling::command_line);
  if (!as_json)
    return cli::warn("frame " + std::to_string(event.frame) + ": " + mux::name_of(event.kind) + ": " + text);
  const Json line = {
      {"event", mux::name_of(event.kind)}, {"frame", event.frame}, {"age", event.age}, {"text", text}};
  std::fprintf(stderr, "%s\n", line.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
}

} // namespace

void add_realtime_options(CLI::App &app, RealtimeCommand &command) {
  const mux::RealtimeOptions defaults;
  command.max_delay = defaults.most_delay;
  command.idle = defaults.idle;
  CLI::Option *realtime =
      app.add_flag("--realtime", command.on,
                   "CAPTURE is a folder that grows, or - for frames on standard input (spec/frame-pipe.md): "
                   "pack frames as "
                   "they arrive, in groups of half a second, with the preset live. capture.json is there at "
                   "the start. Ends after its last frame, with the file capture.end "
                   "beside it, with SIGINT or SIGTERM, or after --idle (docs/guide/live.md)");
  app.add_flag("--in-place", command.in_place,
               "for --realtime: files get their names before they are whole, and count once their source has "
               "a file of a later frame; without it they get their names when they are whole, by renaming")
      ->needs(realtime);
  app.add_option("--max-delay", command.max_delay,
                 "for --realtime: seconds from the arrival of a frame until it is written; frames that would "
                 "take longer are dropped and named, with exit code 3")
      ->check(CLI::Range(0.1, 3600.0))
      ->type_name("SECONDS")
      ->capture_default_str()
      ->needs(realtime);
  app.add_option("--idle", command.idle,
                 "for --realtime: seconds without a frame after which the stream ends, and seconds for which "
                 "a reader of a pipe may take nothing")
      ->check(CLI::Range(0.1, 86400.0))
      ->type_name("SECONDS")
      ->capture_default_str()
      ->needs(realtime);
  for (const char *other :
       {"--plan", "--part", "--merge", "--segments", "--write-capture", "--report", "--verify"})
    realtime->excludes(app.get_option(other));
}

cli::Exit run_realtime(const RealtimeCommand &command, const mux::Options &options, const std::string &path,
                       bool force, bool as_json) {
  cli::stop_gently();
  mux::RealtimeOptions realtime;
  realtime.most_delay = command.max_delay;
  realtime.idle = command.idle;
  realtime.arrival = command.in_place ? mux::Arrival::by_successor : mux::Arrival::by_name;
  const bool reads_pipe = options.capture == "-";
  if (reads_pipe && isatty(STDIN_FILENO))
    throw Error("-: expected frames (spec/frame-pipe.md) on standard input, found a terminal", Error::usage);
  if (reads_pipe && command.in_place)
    throw Error("--in-place: expected a folder, found a pipe", Error::usage);
  mux::Options chosen = options;
  if (reads_pipe) {
    realtime.pipe = STDIN_FILENO;
    chosen.capture = "standard input";
  }
  cli::OutputFile output(path, force,
                         cli::inputs(reads_pipe ? std::vector<std::string>() : std::vector{options.capture}));
  if (!output.is_regular()) output.set_time_out(command.idle);
  mux::Observer observer;
  observer.on_warning = cli::warn;
  const mux::Report report = mux::pack_arriving(
      chosen, realtime, [&](const void *bytes, size_t size) { output.write(bytes, size); }, observer,
      [&](const mux::RealtimeEvent &event) { print(event, as_json); }, cli::is_stopped);
  output.commit();
  const bool piped = path == "-";
  const std::string text = as_json ? mux::report_json(report, path, Spelling::command_line) + "\n"
                                   : mux::report_text(report, path, Spelling::command_line);
  if (!piped || as_json || isatty(STDERR_FILENO)) std::fputs(text.c_str(), piped ? stderr : stdout);
  return report.warned ? cli::loss : cli::done;
}

} // namespace fvv
