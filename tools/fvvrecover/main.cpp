// fvvrecover: a whole stream from what a damaged or unfinished one has left.
#include "cli/cli.h"
#include "cli/help.h"
#include "fvvrecover/command.h"

#include <CLI/CLI.hpp>

#include <cstdio>

using namespace fvv;

namespace {

cli::Exit recover_file(const recover::Command &command, bool as_json) {
  const recover::Result result = recover::run(command);
  for (const std::string &line : recover::messages(command, result))
    std::fprintf(stderr, "%s\n", line.c_str());
  const bool is_empty = recover::is_empty(result);
  if (as_json) {
    const std::string text = recover::json(command.input, is_empty ? "" : command.output, result)
                                 .dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
    std::printf("%s\n", text.c_str());
  } else if (command.output != "-") {
    std::fputs(recover::text(command.input, result).c_str(), stdout);
  }
  return is_empty ? cli::failed : result.has_lost() ? cli::loss : cli::done;
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app{"Write a whole stream from what a damaged or unfinished fvv file has left."};
  recover::Command command;
  bool as_json = false, dry_run = false;
  app.add_option("IN", command.input, "fvv file; it is never changed")->required()->type_name("FILE.fvv");
  auto *named = app.add_option("-o,--output", command.output, "fvv file to write")->type_name("FILE.fvv");
  app.add_flag("--dry-run", dry_run, "write nothing, report what can be kept")->excludes(named);
  app.add_flag("--force", command.force, "replace an existing output file");
  app.add_flag("--json", as_json, "print a report as JSON (spec/fvvrecover.schema.json)");
  app.footer(
      "Frames are kept with all their chunks or not at all. What is whole keeps its bytes; groups after\n"
      "lost ones get new sequence numbers. Nothing damaged gets a new CRC (docs/tools/fvvrecover.md).\n"
      "Exit code: 0 the input is whole and the output the same, 1 nothing can be kept, 2 usage,\n"
      "3 written, and the input is damaged or unfinished.");
  cli::set_help(app, "fvvrecover",
                {
                    "fvvrecover damaged.fvv -o whole.fvv",
                    "fvvrecover damaged.fvv --dry-run --json",
                });
  try {
    app.parse(argc, argv);
    if (command.output.empty() && !dry_run) throw CLI::RequiredError("--output or --dry-run");
    if (command.output == "-" && as_json) throw CLI::ExcludesError("--json", "-o -");
  } catch (const CLI::ParseError &error) {
    return cli::end_of_parsing(app, error);
  }
  return cli::run("fvvrecover", [&] { return recover_file(command, as_json); });
}
