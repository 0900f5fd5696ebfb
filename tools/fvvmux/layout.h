// fvvmux/layout.h: where each camera's picture stands in the video frame: whole pictures in a grid, or what a
// group shows of the scene, packed. Knows sizes and rectangles; no pixels.
#pragma once

#include "fvvmux/plan.h"

namespace fvv::mux {

// A tile for every camera with pictures, of its whole picture, in the size that the options ask for, without
// a place. cli::Failure (usage) when a picture would have to grow.
Tiling whole_pictures(const capture::Capture &capture, const Options &options);

// How whole pictures are to be cropped, and why. What is seen of the scene is looked for here.
CropChoice choose_crop(const Plan &plan, const Tiling &tiling);

// With --video-pixels or --video-size: makes whole pictures smaller until their crops fit one frame of that
// size, and one that decoders take, each by its usefulness (tile_scale.h). cli::Failure when the smallest do
// not fit.
void bound(const Plan &plan, Tiling &tiling);

// Crops whole pictures to what is seen of the scene in each group, with a margin, and packs every group's
// crops into one frame. What is sent keeps the scale of the whole picture. Nothing to crop by: whole pictures
// in a grid, and no groups.
//
// One track for each set of neighbouring cameras that Options::video_tracks asks for, and of each set as many
// as it takes for no frame to exceed plan.frame_limit; the cameras of a set stay in order, and its tracks
// have about the same number of pixels. A camera that exceeds it alone has a track of its own, with a
// warning. cli::Failure when it exceeds the format. No tiles: no tracks.
std::vector<VideoTrack> tile_tracks(Plan &plan, const Tiling &whole);

} // namespace fvv::mux
