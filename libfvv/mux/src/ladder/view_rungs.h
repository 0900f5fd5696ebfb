// Rungs of qualities where what views show of them decides.
#pragma once

#include "fvv_mux/options.h"

#include <vector>

namespace fvv::mux {

// Pictures and meshes that a rung may have.
struct RungCandidate {
  double psnr = 0;  // of pictures, dB
  double times = 1; // the error of meshes, over that of the first rung
  double bytes = 0; // of a group
  double error = 0; // mean square, of cameras that are drawn from the others
};

// first: what the first rung has. Lower rungs lie on the upper convex hull of the PSNR of views over the
// logarithm of bytes, best first: each takes at most two thirds of the bytes of the one before, with coarser
// pictures. Of candidates none of which does, the smallest with coarser pictures; none: the first alone.
std::vector<Rung> choose_view_rungs(const RungCandidate &first, std::vector<RungCandidate> candidates);

// Throws Error (usage) where Options::ladder_by_views does not fit other options.
void check_view_rungs(const Options &options);

// Rungs without such a measure: 6 dB apart.
std::vector<Rung> usual_rungs(double first_psnr);

} // namespace fvv::mux
