// The silhouette that a camera saw as a signed distance in its picture. Knows one mask and one camera; knows
// no other camera and no mesh.
#pragma once

#include "fvv/calibration.h"

#include <cstdint>
#include <vector>

namespace fvv::hull {

class Silhouette {
public:
  // mask: width x height of the camera, 0 outside the silhouette. camera is copied.
  Silhouette(const fvv_camera &camera, const std::vector<uint8_t> &mask);

  // Where a point of the world stands towards the silhouette.
  struct View {
    bool seen = false;    // within the picture; the rest means nothing otherwise
    double pixels = 0;    // distance from the outline, negative inside
    double metres = 0;    // the same at the depth of the point
    double pixel[2]{};    // where it is seen
    double per_metre = 0; // pixels that a metre across the ray covers there
    double depth = 0;     // z_c
  };
  View view(const double world[3]) const;
  // Whether all points within radius metres of a point seen there are surely outside.
  bool clear_of(const View &view, double radius) const;

private:
  double at(double u, double v) const;

  fvv_camera camera;
  std::vector<float> distance; // of pixel centres
};

} // namespace fvv::hull
