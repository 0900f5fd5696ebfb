// import/camera.h: what all readers do alike: poses into fvv's axes, names from file names, the last checks.
// Knows no file format.
#pragma once

#include "import/import.h"

namespace fvv::import {

// axes: the camera's right, up and backward vectors as rows in world coordinates (OpenGL); centre: where it
// stands. R = diag(1, -1, -1) axes, t = -R centre.
void set_pose_opengl(fvv_camera &camera, const double axes[9], const double centre[3]);

// The lens from all eight coefficients; without any that is not 0 there is none.
void set_radtan(fvv_camera &camera, const double coefficients[8]);
void set_fisheye(fvv_camera &camera, const double coefficients[4]);

// "images/left/0001.png", "images/right/0001.png" -> "left", "right": without extension, and without the
// folders and last parts that all of them share. Distinct whenever the paths without extension are.
std::vector<std::string> names_of_pictures(const std::vector<std::string> &paths);

// Fills r_max, checks the camera and that its id is new, and appends it. where: "path:LINE" or the like.
void append(Calibration &calibration, capture::Camera camera, const std::string &where);

// FileError unless there is a camera.
void require_cameras(const Calibration &calibration, const std::string &path);

} // namespace fvv::import
