// A capture folder from the scene: capture.json, meshes, pictures, masks. Knows files and their formats; what
// they show is the scene's affair.
#pragma once

#include "cli/cli.h"
#include "fvvsynth/scene.h"

namespace fvv::synth {

struct FrameRate { // frames per second, in lowest terms
  uint32_t numerator = 25, denominator = 1;
};

// "25" or "30000/1001". Failure (usage) when text is not a positive number or fraction of such.
FrameRate parse_frame_rate(const std::string &text);

// Writes frames 0 ... count - 1 into folder on that many threads. The bytes do not depend on threads. Failure
// names the file that could not be written.
void write_capture(const Scene &scene, uint32_t count, FrameRate rate, uint32_t threads,
                   const cli::OutputFolder &folder);

} // namespace fvv::synth
