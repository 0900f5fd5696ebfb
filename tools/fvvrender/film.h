// Films of fvvrender: pictures along the way of a camera, as MP4 or as numbered files.
#pragma once

#include "fvvrender/render.h"

namespace fvv::rendering {

// Whether the name of the output is that of a film: "turn.mp4", "turn/%04d.png".
bool is_film(const std::string &output);

// Throws Error; warnings and losses so far are in result then. The counts of pixels in result are those of
// all pictures together, its sources those of the first.
void run_film(const Options &options, Result &result);

} // namespace fvv::rendering
