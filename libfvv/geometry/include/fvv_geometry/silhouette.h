// A camera's mask as a signed distance, and what it says about points and balls in the world.
#pragma once

#include "fvv/calibration.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fvv::hull {

class Silhouette {
public:
  // mask: width x height of the camera, 0 outside the silhouette. camera is copied.
  Silhouette(const fvv_camera &camera, const std::vector<uint8_t> &mask);

  // The position of a world point relative to the silhouette.
  struct View {
    bool seen = false;    // within the picture; the other members are invalid otherwise
    double pixels = 0;    // distance from the outline, negative inside; exact up to 60
    double metres = 0;    // the same at the depth of the point
    double pixel[2]{};    // where it is seen
    double per_metre = 0; // pixels that a metre across the ray covers there
    double depth = 0;     // z_c
  };
  View view(const double world[3]) const;

  // What holds for all points of a ball. unsure: nothing is certain.
  enum class Ball { unseen, outside, inside, unsure };
  // The ball of twice the radius is examined, so what holds for it holds as well for points up to a radius
  // away.
  Ball ball(const double centre[3], double radius) const;

  const fvv_camera &calibration() const { return camera; }

private:
  // Pixels, the upper bounds exclusive.
  struct Box {
    uint32_t left = 0, top = 0, right = 0, bottom = 0;
    uint32_t width() const { return right - left; }
    uint32_t height() const { return bottom - top; }
  };

  double at(double u, double v) const;
  // Pixels of the silhouette within left ... right, top ... bottom.
  uint64_t count(double left, double top, double right, double bottom) const;

  fvv_camera camera;
  Box window;                   // around the silhouette; empty without one
  std::vector<float> distance;  // of the pixel centres of window
  std::vector<uint32_t> counts; // of the pixels above and left of each corner of a pixel of window
};

} // namespace fvv::hull
