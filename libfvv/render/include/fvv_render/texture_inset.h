// How far inside a mesh the surface lies that the pictures of its cameras show: a hull is larger than the
// body that it was made from, and cameras on two sides of a detail show it at two places of the hull.
#pragma once

#include "fvv_render/held_out.h"

namespace fvv::render {

struct TextureInset {
  double inset = 0; // for ViewOptions; 0: none is better by least_gain
  // PSNR in dB of cameras that are drawn from all others, without an inset and with the best that was tried.
  double before = 0, after = 0;
  size_t views = 0, better = 0; // cameras that were drawn, and those whose error the best inset reduces
  size_t pixels = 0;            // that were compared
};

// What pays for the additional work of a player and for the risk of a wrong choice.
constexpr double least_gain = 0.05;     // dB
constexpr size_t least_compared = 1000; // pixels
constexpr double largest_inset = 0.032; // of the mesh's longest side

// Draws each camera from all others on a grid of pixels, with insets from 1/2000 of the longest side of the
// mesh on, doubled while the error falls, then between the best of these and its neighbours, and last at the
// minimum of the parabola through the best three.
// options: how players blend; its inset is not used. frames may lack cameras. The same result for every
// executor. Throws what ViewRenderer throws.
TextureInset find_texture_inset(const std::vector<HeldOutFrame> &frames, const ViewOptions &options);

} // namespace fvv::render
