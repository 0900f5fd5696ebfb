// fvvmux/guides.h: what a calibration alone lets one draw into a picture: the world's axes, a grid on its
// ground, the other cameras. Knows cameras; knows no mesh, no masks and no files.
#pragma once

#include "fvv/calibration.h"
#include "fvvmux/overlay.h"

#include <vector>

namespace fvv::mux {

constexpr double camera_dot = 4; // across, pixels

// Length of the axes and side of the grid's squares: 1, 2 or 5 times a power of ten, so that the axes are
// about a fifth as long as the farthest camera is away from what all look at; metres, or units of the
// capture.
double guide_step(const std::vector<fvv_camera> &cameras);

// image is a picture of cameras[which], of any size. All lines follow the lens.
//
// From the world's origin, with a letter at each end.
void draw_axes(const std::vector<fvv_camera> &cameras, size_t which, media::Image &image);
// Squares on the plane through the origin across up (FVV_UP_...), around what the cameras look at. Nothing
// when up is unknown.
void draw_ground(const std::vector<fvv_camera> &cameras, size_t which, uint8_t up, media::Image &image);
// A dot with its identifier for every other camera in the picture.
void draw_cameras(const std::vector<fvv_camera> &cameras, size_t which, media::Image &image);

} // namespace fvv::mux
