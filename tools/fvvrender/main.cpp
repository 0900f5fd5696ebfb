// fvvrender: the picture of a frame from anywhere, textured from the cameras that see best: the reference
// that players are compared with.
#include "cli/cli.h"
#include "cli/help.h"
#include "fvvrender/command.h"
#include "fvvrender/film.h"

#include <CLI/CLI.hpp>
#include <cstdio>

using namespace fvv;

namespace {

void tell(const rendering::Result &result) {
  for (const std::string &text : result.warnings) cli::warn(text);
  for (const std::string &line : result.losses) std::fprintf(stderr, "%s\n", line.c_str());
}

cli::Exit draw(const rendering::Options &options, bool as_json) {
  rendering::Result result;
  try {
    rendering::is_film(options.output) ? rendering::run_film(options, result)
                                       : rendering::run(options, result);
  } catch (...) {
    tell(result);
    throw;
  }
  tell(result);
  if (as_json) std::printf("%s\n", rendering::json(options, result).c_str());
  return result.losses.empty() ? cli::done : cli::loss;
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app{
      "Draw a frame of a fvv file, or a film of it, as any camera would see it, textured from its cameras."};
  rendering::Command command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError &error) {
    return cli::end_of_parsing(app, error);
  }
  return cli::run("fvvrender", [&] { return draw(command.options(), command.as_json); });
}
