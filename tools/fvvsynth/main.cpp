// fvvsynth: writes a made-up capture, so that a fresh machine needs no data.
#include "cli/cli.h"
#include "cli/help.h"
#include "cli/output.h"
#include "fvvsynth/command.h"

#include <CLI/CLI.hpp>
#include <stdexcept>

namespace {

fvv::cli::Exit write(fvv::synth::Command &command) {
  command.settle();
  fvv::cli::OutputFolder folder(command.output, command.force);
  try {
    const fvv::synth::Scene scene(command.settings);
    if (command.settings.still)
      fvv::synth::write_footage(scene, command.shoot, folder);
    else
      fvv::synth::write_capture(scene, command.recording, folder);
  } catch (const std::invalid_argument &error) {
    throw fvv::Error(error.what(), fvv::Error::usage);
  }
  folder.commit();
  return fvv::cli::done;
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app("Writes a made-up capture of two basketball players: meshes, calibrated pictures and masks.");
  fvv::synth::Command command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError &error) {
    return fvv::cli::end_of_parsing(app, error);
  }
  return fvv::cli::run("fvvsynth", [&] { return write(command); });
}
