// import/diagnose.h: does a calibration explain points that were measured in the scene and in the pictures,
// and if not, is it one of the mistakes that conversions between programs make? Knows fvv's camera; knows no
// file format but its own list of points.
#pragma once

#include "import/import.h"

#include <array>

namespace fvv::import {

// world: in the units of the cameras. pixel: by fvv's count, the centre of the top left pixel at (0.5, 0.5).
struct Observation {
  double world[3];
  uint16_t camera;
  double pixel[2];
};

// Lines "X Y Z CAMERA_ID U V"; empty lines and those that begin with '#' are skipped. FileError "path:LINE:
// ...", also for cameras that the calibration does not have and for fewer points than diagnose() wants.
std::vector<Observation> read_observations(const std::string &path,
                                           const std::vector<capture::Camera> &cameras);

enum class Mistake { axes, inverse, inverse_and_axes, half_pixel, distortion };
constexpr size_t mistake_count = 5;
// A word for JSON, and a sentence for people.
const char *name_of(Mistake mistake);
const char *description_of(Mistake mistake);

// Root mean squares of the distance between projected and observed pixel. A point that a camera cannot show
// (behind it, beyond r_max), and any distance above it, counts as the diagonal of the picture, so that one
// point cannot outweigh all others.
struct Diagnosis {
  size_t points = 0;
  double rms = 0, max = 0;                       // as given
  size_t invisible = 0;                          // as given: points that their camera cannot show
  std::vector<double> rms_of_camera;             // one for each camera, NaN without points
  std::array<double, mistake_count> undone = {}; // rms with a mistake undone, the best of its variants; NaN
                                                 // where it cannot have been made
  std::optional<Mistake> suspected;
};

constexpr size_t min_observations = 8;

// Undoes one mistake at a time in all cameras:
// - axes: the camera's y and z axes are turned round (OpenGL for OpenCV);
// - inverse: the pose goes from the camera to the world, in OpenCV's axes or, turned twice, in OpenGL's;
// - inverse_and_axes: both, in either order;
// - half_pixel: the principal point moves by half a pixel up and left, or down and right;
// - distortion: k1 k2 p1 p2 k3 read as k1 k2 k3 p1 p2 or the reverse, or p1 and p2 exchanged.
// The rule: a mistake is suspected when undoing it leaves at most half of the rms as given and at most 0.7 of
// what undoing any other leaves, and when the rms as given is above 0.1 px.
Diagnosis diagnose(const std::vector<capture::Camera> &cameras, const std::vector<Observation> &observations);

} // namespace fvv::import
