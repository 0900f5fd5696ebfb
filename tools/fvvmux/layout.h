// fvvmux/layout.h: where each camera's picture stands in the video frame: whole pictures in a grid, or what a
// group shows of the scene, packed. Knows sizes and rectangles; no pixels.
#pragma once

#include "fvvmux/plan.h"

namespace fvv::mux {

// A tile for every camera with pictures, of its whole picture, in the size that the options ask for, without
// a place. cli::Failure (usage) when a picture would have to grow.
Tiling whole_pictures(const capture::Capture &capture, const Options &options);

// Gives the whole pictures places in a grid (fvv_tiles_arrange).
void arrange(const capture::Capture &capture, Tiling &tiling);

// How whole pictures are to be cropped, and why. What is seen of the scene is looked for here.
CropChoice choose_crop(const Plan &plan, const Tiling &tiling);

// With --video-pixels: makes whole pictures smaller until their crops fit a frame of so many pixels, each by
// its usefulness (tile_scale.h). cli::Failure when the smallest do not fit.
void bound(const Plan &plan, Tiling &tiling);

// Crops whole pictures to what is seen of the scene in each group, with a margin, and packs every group's
// crops into one frame. Answers the tiles of each group; tiling becomes that of the first. What is sent keeps
// the scale of the whole picture. Nothing to crop by: whole pictures in a grid, and no groups.
std::vector<std::vector<fvv_tile>> crop(const Plan &plan, Tiling &tiling);

} // namespace fvv::mux
