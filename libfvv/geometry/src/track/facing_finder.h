// Nearest points of a surface among those that face a direction: of two limbs side by side each finds itself.
#pragma once

#include "fvv_render/triangle_tree.h"

#include <array>
#include <optional>
#include <vector>

namespace fvv::track {

class FacingFinder {
public:
  // like: NULL, or a finder of the same triangles at other places, as ClosestFinder has it. Each triangle
  // faces what it faced there.
  explicit FacingFinder(const std::vector<render::TriangleTree::Triangle> &triangles,
                        const FacingFinder *like = nullptr);

  // Of the triangles whose normals are less than 70 degrees from the axis that is nearest to a direction;
  // none where there are none. face: index in triangles. guess: as ClosestFinder has it, of the last result.
  render::ClosestPoint nearest(render::Vec3 from, render::Vec3 direction, uint32_t guess = UINT32_MAX) const;

private:
  struct Side {
    std::vector<uint32_t> faces;
    std::vector<uint32_t> numbers; // of each triangle among faces; UINT32_MAX: not there
    std::optional<render::ClosestFinder> finder;
  };
  std::array<Side, 6> sides; // +x, -x, +y, ...
};

} // namespace fvv::track
