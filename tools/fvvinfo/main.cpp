// fvvinfo: what is in a fvv file, and whether it is whole.
#include "cli/help.h"
#include "fvvinfo/report.h"

#include <CLI/CLI.hpp>

#include <cstdio>

using namespace fvv;
using Json = nlohmann::ordered_json;

namespace {

// One line for each problem; a truncated stream also says what is left of it.
void tell_problems(const info::Report &report) {
  for (size_t i = 0; i < fvv_checker_problem_count(report.checker.get()); i++) {
    char line[1024];
    fvv_diagnostic_format(fvv_checker_problem(report.checker.get(), i), report.name.c_str(), line,
                          sizeof line);
    std::fprintf(stderr, "%s\n", line);
  }
  const auto &s = report.summary();
  const uint64_t kept = fvv_checker_problem_count(report.checker.get());
  if (s.problems > kept)
    std::fprintf(stderr, "%s: and %llu problems more\n", report.name.c_str(),
                 (unsigned long long)(s.problems - kept));
  if (report.exit() == cli::loss && !s.problems)
    std::fprintf(stderr, "%s: 0x%llx: no footer: the stream is live or truncated\n", report.name.c_str(),
                 (unsigned long long)s.bytes);
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app{"Show what is in fvv files and whether they are whole."};
  std::vector<std::string> files;
  info::Options options;
  bool as_json = false;
  app.add_option("FILE", files, "fvv files; - is standard input")->required()->type_name("FILE.fvv");
  app.add_flag("--json", as_json, "print JSON (spec/fvvinfo.schema.json)");
  app.add_flag("--chunks", options.chunks, "list every chunk");
  app.add_flag("--check", options.check, "decode every mesh and check every video sample as well");
  app.footer("Exit code: 0 all whole, 1 damaged or unreadable, 2 usage, 3 truncated (or live: no footer).");
  cli::set_help(app, "fvvinfo",
                {
                    "fvvinfo players.fvv",
                    "fvvinfo --check --json players.fvv",
                });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError &error) {
    return cli::end_of_parsing(app, error);
  }
  return cli::run("fvvinfo", [&] {
    cli::Exit worst = cli::done;
    Json document = {{"fvvinfo", 1}, {"files", Json::array()}};
    for (const auto &file : files) {
      try {
        const info::Report report = info::inspect(file, options);
        if (as_json)
          document["files"].push_back(info::json(report));
        else
          std::fputs(info::text(report).c_str(), stdout);
        std::fflush(stdout);
        tell_problems(report);
        worst = cli::worse(worst, report.exit());
      } catch (const Error &failure) {
        // The other inputs are still read.
        std::fprintf(stderr, "fvvinfo: %s\n", failure.what());
        worst = cli::worse(worst, failure.kind == Error::usage ? cli::usage : cli::failed);
      }
    }
    // A file's name need not be UTF-8; JSON must be.
    if (as_json) std::printf("%s\n", document.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
    return worst;
  });
}
