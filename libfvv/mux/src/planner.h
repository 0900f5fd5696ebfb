// A step of planning that is repeated for a plan that was saved.
#pragma once

#include "mux/src/plan.h"

namespace fvv::mux {

// Removes the frames, cameras, pictures and meshes that options exclude, and data that a stream cannot hold,
// the latter with a warning; sorts the cameras into the order of the stream. Returns whether it warned. Reads
// no file. Throws Error (usage) for options that do not fit the capture, and when nothing is left.
bool select(scene::Capture &capture, const Options &options, const Observer &observer);

} // namespace fvv::mux
