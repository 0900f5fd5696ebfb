// capture/lens_check.h: whether a lens can be inverted all over its picture. Knows cameras; reads no file.
#pragma once

#include "capture/capture.h"

namespace fvv::capture {

// A camera of whose picture a part lies beyond r_max, where nothing is projected: mostly because the lens
// folds there (fvv.md, clause 9.3).
struct LensGap {
  uint16_t camera;
  double r_max; // tangent of the angle to the axis, or of a fisheye the angle, in radians
  double share; // of the picture's area, about; of a camera that moves the largest of its frames
};

// Cameras without such a part are left out.
std::vector<LensGap> lens_gaps(const Capture &capture);

// Lines of a summary.
std::string text_of(const std::vector<LensGap> &gaps);

} // namespace fvv::capture
