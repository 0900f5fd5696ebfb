// fvvmux/neighbours.h: which cameras a viewer needs together. Knows where they stand and look.
#pragma once

#include "capture/capture.h"

#include <vector>

namespace fvv::mux {

// Cameras (indices in Capture::cameras) in count sets, at most one for each camera: as places in that list,
// rising, the sets by their first. Begins with each camera alone, and again and again joins the two sets
// whose most unlike directions of looking are nearest; at equal angles (cameras side by side) those whose
// farthest cameras stand nearest, then the first. Cameras that move count as they are in the first frame in
// which they are calibrated.
std::vector<std::vector<size_t>> neighbours(const capture::Capture &capture,
                                            const std::vector<size_t> &cameras, size_t count);

} // namespace fvv::mux
