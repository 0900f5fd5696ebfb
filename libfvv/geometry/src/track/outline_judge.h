// Whether the outlines of a tracked hull are those of the frame's masks.
#pragma once

#include "fvv_geometry/outline.h"
#include "fvv_geometry/track.h"

namespace fvv::track {

class OutlineJudge {
public:
  // own: the frame's hull as a key frame would have it. tolerance: pixels of the budget.
  OutlineJudge(const std::vector<MaskView> &masks, const geometry::Mesh &own, double tolerance);

  // By the rule of Settings::masks. False if no camera sees anything of the frame.
  bool accepts(const geometry::Mesh &tracked) const;

private:
  const std::vector<MaskView> &masks;
  const double tolerance;
  std::vector<geometry::MaskDifference> of_own;
};

} // namespace fvv::track
