// Replaces cameras with a lens and their pictures by ones without (--undistort).
#pragma once

#include "fvv_media/image.h"
#include "fvv_scene/capture.h"

#include <string>
#include <vector>

namespace fvv::scene {

// The result for a camera, over all frames.
struct Undistorted {
  uint16_t id;
  uint32_t source_width, source_height, width, height; // pixels
  double horizontal, vertical;                         // degrees that the new picture shows, at most
  double kept;   // fraction of the old picture's area that is in the new one, at least
  double blank;  // fraction of the new picture's area that the old one does not show, at most
  double finest; // pixels of the new picture for one of the old one, on the axis: the least of fx and fy
  bool limited;  // the old one shows more than r_max or 75 degrees from the axis
};

class Undistortion {
public:
  // Replaces every camera of capture that has a lens and pictures by a pinhole at the same place: the same
  // focal lengths, as nearly as whole pixels allow, unless the picture became more than twice as wide or
  // high. alpha: 0 for the largest picture without blank pixels, 1 for all that the old one shows, and
  // between. A camera that moves has a picture of one size. Throws Error (usage), naming the camera, if the
  // angle of a lens is too wide.
  Undistortion(Capture &capture, double alpha);

  // Converts a picture or mask of the old camera to the new one; unchanged if there is no new one. camera:
  // index in the capture; frame: its number. Pure, for any thread.
  template <class Sample>
  media::BasicImage<Sample> apply(size_t camera, int64_t frame, media::BasicImage<Sample> picture) const;

  const std::vector<Undistorted> &report() const { return reports; }

private:
  struct Pair {
    Camera source, target;
    bool is_new = false;
  };
  void replace(const Capture &capture, Camera &camera);

  double alpha;
  std::vector<Pair> pairs; // as the capture's cameras
  std::vector<Undistorted> reports;
};

} // namespace fvv::scene
