// The studio's floor and walls as a glTF file, a static environment for players to draw around the action,
// with the lamps as lights. Painted by the same functions as the pictures of the cameras.
#pragma once

#include "fvvsynth/scene.h"

namespace fvv::synth {

// A GLB of two parts, floor and walls, that show what they send out (unlit), and a directional light for each
// lamp. The same bytes for any number of threads.
std::string environment_glb(const Scene &scene, uint32_t threads);

} // namespace fvv::synth
