// What a stream gives up, step by step, when it is encoded more slowly than its frames come
// (docs/guide/live.md).
#pragma once

#include "fvv_media/video.h"

#include <cstddef>

namespace fvv::mux {

struct EffortStep {
  const char *text;  // for people
  bool least_effort; // of the encoder of pictures
  int coarser;       // by that many units of the codec's scale
  int mesh_level;    // of Draco, at most
};

// The first one gives up nothing.
constexpr size_t effort_steps = 4;
const EffortStep &effort_step(size_t number);

// Applies the step to what was chosen at first. Quality stays within the codec's scale; what is lossless
// stays so.
void lower(media::VideoSettings &settings, const EffortStep &step);

} // namespace fvv::mux
