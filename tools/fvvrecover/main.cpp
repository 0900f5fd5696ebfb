// fvvrecover: a whole stream from what a damaged or unfinished one has left.
#include "cli/cli.h"
#include "cli/help.h"
#include "cli/output.h"
#include "fvvrecover/report.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <memory>

using namespace fvv;

namespace {

constexpr uint64_t progress_step = uint64_t(1) << 20;

// A step for each MiB of all passes.
class Steps {
public:
  Steps(const std::string &name, uint64_t size)
      : bar("reading " + name, recover::passes * size / progress_step, "MiB"), left(progress_step) {}
  void add(uint64_t bytes) {
    for (; bytes >= left; left = progress_step) {
      bytes -= left;
      bar.step();
    }
    left -= bytes;
  }

private:
  cli::Progress bar;
  uint64_t left;
};

cli::Exit recover_file(const std::string &input, const std::string &name, bool force, bool as_json) {
  const InputFile file(input);
  std::unique_ptr<cli::OutputFile> output;
  if (!name.empty()) output = std::make_unique<cli::OutputFile>(name, force, cli::inputs({input}));
  recover::Result result;
  {
    Steps steps(input, file.size());
    recover::Options options;
    options.progress = [&](uint64_t bytes) { steps.add(bytes); };
    result = recover::recover(
        file,
        [&](const void *bytes, size_t size) {
          if (output) output->write(bytes, size);
        },
        options);
  }
  const bool has_output = output && result.has_kept();
  if (has_output || (output && result.state == recover::State::whole)) output->commit();
  for (const recover::Loss &loss : result.losses)
    std::fprintf(stderr, "%s\n", recover::text(input, loss).c_str());
  if (result.state == recover::State::unfinished)
    std::fprintf(stderr, "%s: 0x%llx: no footer: whether more followed is not known\n", input.c_str(),
                 static_cast<unsigned long long>(file.size()));
  if (result.state == recover::State::damaged && result.losses.empty() && !result.problems.empty()) {
    char line[1024];
    fvv_diagnostic_format(&result.problems.front(), input.c_str(), line, sizeof line);
    std::fprintf(stderr, "%s; nothing is lost\n", line);
  }
  const bool is_empty = !result.has_kept() && result.state != recover::State::whole;
  if (is_empty) result.bytes_written = 0;
  if (is_empty) std::fprintf(stderr, "%s: nothing can be kept: no group has a whole frame\n", input.c_str());
  if (as_json) {
    const std::string text = recover::json(input, is_empty ? "" : name, result)
                                 .dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
    std::printf("%s\n", text.c_str());
  } else if (name != "-") {
    std::fputs(recover::text(input, result).c_str(), stdout);
  }
  return is_empty ? cli::failed : result.has_lost() ? cli::loss : cli::done;
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app{"Write a whole stream from what a damaged or unfinished fvv file has left."};
  std::string input, output;
  bool force = false, as_json = false, dry_run = false;
  app.add_option("IN", input, "fvv file; it is never changed")->required()->type_name("FILE.fvv");
  auto *named = app.add_option("-o,--output", output, "fvv file to write")->type_name("FILE.fvv");
  app.add_flag("--dry-run", dry_run, "write nothing, report what can be kept")->excludes(named);
  app.add_flag("--force", force, "replace an existing output file");
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
    if (output.empty() && !dry_run) throw CLI::RequiredError("--output or --dry-run");
    if (output == "-" && as_json) throw CLI::ExcludesError("--json", "-o -");
  } catch (const CLI::ParseError &error) {
    return cli::end_of_parsing(app, error);
  }
  return cli::run("fvvrecover", [&] { return recover_file(input, output, force, as_json); });
}
