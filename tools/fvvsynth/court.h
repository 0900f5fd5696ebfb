// The still surroundings: a floor of boards with painted lines, and a wall that fades upwards. Part of the
// pictures, not of the meshes.
#pragma once

#include "fvv_render/picture.h"

namespace fvv::synth {

// What camera sees of them: linear light, width x height, each pixel the mean of 5 x 5 samples,
// or 3 x 3 from a width of 960 on, where pixels cover less.
std::vector<render::Rgb> draw_court(const render::Projection &camera, uint32_t key);

} // namespace fvv::synth
