// fvvmux/tile_scale.h: how many pixels each camera deserves when the frame is bounded. Knows cameras and
// boxes.
#pragma once

#include "fvvmux/plan.h"

namespace fvv::mux {

// Of each camera (indices in Capture::cameras), in shares of 1: the solid angle of what it sees of the scene,
// mean over the groups, divided by how many cameras look from where it does. That is the sum, over all
// cameras, itself included, of the squared cosine of the angle between the directions in which they look, or
// 0 beyond a right angle. A camera that is farther away, or one of three side by side, is worth less. Cameras
// that move count as they are in the first frame in which they are calibrated.
std::vector<double> usefulness(const capture::Capture &capture, const std::vector<size_t> &cameras,
                               const std::vector<std::vector<Silhouette>> &boxes);

// Whole pictures of the size at which what is seen of the scene (mean over the groups) has amount, 0 to 1,
// times all pixels that it has in full, shared out by usefulness: never larger than in full, nor smaller than
// 1/16 of it on each side. Sizes are multiples of 1/16 of full, as near as whole pixels come.
std::vector<fvv_tile> scaled_by_use(const std::vector<fvv_tile> &full,
                                    const std::vector<std::vector<Silhouette>> &boxes,
                                    const std::vector<double> &usefulness, double amount);

} // namespace fvv::mux
