// A recording session as cameras leave it: films of a board, of the empty stage and of the action, without
// calibration, and beside them the truth.
#pragma once

#include "cli/output.h"
#include "fvvsynth/filming.h"

namespace fvv::synth {

struct Shoot {
  uint32_t frames = 50; // of the action
  uint32_t poses = 60;  // of the board
  double late = 0.04;   // seconds; clocks of cameras differ by less, or not at all with 0
  FrameRate rate;
  Realism realism; // without labels and claps: the action has one clap
  uint32_t threads = 1;
};

// The camera that films nothing for the session: its pictures are among the truth.
constexpr const char *held_out = "oval2";

// Writes the films of all cameras of the studio but the overhead one and the one held out, and the truth
// (docs/tools/fvvsynth.md lists the files). The same bytes for any number of threads. scene: of the rig
// studio, still. Error (usage) for fewer frames than clocks differ by.
void write_footage(const Scene &scene, const Shoot &shoot, cli::OutputFolder &folder);

} // namespace fvv::synth
