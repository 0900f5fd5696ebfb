// The cameras around the scene. Knows the space that the action takes, nothing else.
#pragma once

#include "fvv/calibration.h"
#include "fvvsynth/random.h"

#include <vector>

namespace fvv::synth {

// count cameras on an oval about 5.3 m from its centre, 1.5 to 3 m high, turned to the action, each a little
// different in focal length and principal point; a pixel covers about 14 mm in pictures 480 wide. Not named.
std::vector<fvv_camera> make_rig(Random &random, uint32_t count, uint32_t width, uint32_t height);

} // namespace fvv::synth
