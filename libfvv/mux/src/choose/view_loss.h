// What Options::view_loss asks for: of the qualities of pictures, budgets of meshes and ways of blending the
// combination that takes fewest bytes while views from between cameras lose at most that. Measured on a few
// frames of the middle group, which are encoded as they would be in the stream (docs/encoding/view-loss.md).
#pragma once

#include "mux/src/choose/sampled_scene.h"
#include "mux/src/plan.h"

namespace fvv::mux {

// Pictures keep that PSNR at the places of cameras, however little of it is seen from elsewhere.
constexpr double least_camera_psnr = 38; // dB, over the foreground

// plan: with the tracks of the first rung and the defaults for what is not set. tiling: of the cameras.
// delta_frames: as of choose_lattice. Throws Error.
ViewChoice choose_by_view_loss(const Plan &plan, const SampledScene &scene, const Tiling &tiling,
                               double delta_frames);

} // namespace fvv::mux
