// decimate/footprint.h: what a pixel of the cameras' pictures covers at a place in the scene. Knows cameras
// and points; knows no meshes. Occlusion is not looked at: what one camera cannot see from where it stands
// another viewpoint may, and to count it as seen errs on the safe side.
#pragma once

#include "fvv/calibration.h"

#include <cmath>
#include <vector>

namespace fvv::decimate {

// The camera that sees a place sharpest. Lengths in metres, or in whatever unit the cameras have.
struct Sight {
  double metres_per_pixel = INFINITY; // the smallest over all directions; infinite: no camera sees the place
  double distance = 0;
  uint16_t camera = 0;
};

class Footprint {
public:
  // scale_x, scale_y: pixels of the transmitted picture per pixel of the camera's. For a valid camera, of
  // which all but the name is copied.
  void add(const fvv_camera &camera, double scale_x, double scale_y);
  bool empty() const { return views.empty(); }

  // Of the cameras in whose picture the place lies; where it lies in none, of those that would see it if
  // their pictures went on, so that what is just outside is not treated as if nobody looked. Perspective,
  // skew and the lens count: the answer comes from the derivative of the projection, whose largest singular
  // value is that of a displacement across the ray in its worst direction.
  Sight look(const double point[3]) const;

private:
  struct View {
    fvv_camera camera;
    double centre[3], scale_x, scale_y;
  };
  std::vector<View> views;
};

} // namespace fvv::decimate
