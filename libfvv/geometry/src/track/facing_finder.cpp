#include "geometry/src/track/facing_finder.h"

#include <cmath>

namespace fvv::track {

namespace {

constexpr double least_cosine = 0.342; // 70 degrees; a direction is at most 55 from its axis

} // namespace

FacingFinder::FacingFinder(const std::vector<render::TriangleTree::Triangle> &triangles,
                           const FacingFinder *like) {
  std::array<std::vector<render::TriangleTree::Triangle>, 6> of_sides;
  for (size_t side = 0; like && side < sides.size(); side++) {
    sides[side].faces = like->sides[side].faces;
    sides[side].numbers = like->sides[side].numbers;
    for (const uint32_t f : sides[side].faces) of_sides[side].push_back(triangles[f]);
    sides[side].finder.emplace(of_sides[side], &*like->sides[side].finder);
  }
  if (like) return;
  for (Side &side : sides) side.numbers.assign(triangles.size(), UINT32_MAX);
  for (size_t f = 0; f < triangles.size(); f++) {
    const auto &[a, b, c] = triangles[f];
    const render::Vec3 normal = normalised(cross(b - a, c - a));
    for (size_t side = 0; side < sides.size(); side++) {
      const double along = axis_of(normal, int(side / 2)) * (side % 2 ? -1 : 1);
      if (!(along > least_cosine)) continue;
      sides[side].numbers[f] = uint32_t(sides[side].faces.size());
      sides[side].faces.push_back(uint32_t(f));
      of_sides[side].push_back(triangles[f]);
    }
  }
  for (size_t side = 0; side < sides.size(); side++) sides[side].finder.emplace(of_sides[side]);
}

render::ClosestPoint FacingFinder::nearest(render::Vec3 from, render::Vec3 direction, uint32_t guess) const {
  size_t best = 0;
  for (size_t axis = 1; axis < 3; axis++)
    if (std::abs(axis_of(direction, int(axis))) > std::abs(axis_of(direction, int(best)))) best = axis;
  const Side &side = sides[2 * best + (axis_of(direction, int(best)) < 0)];
  const uint32_t near = guess < side.numbers.size() ? side.numbers[guess] : UINT32_MAX;
  render::ClosestPoint hit = side.finder->nearest(from, near);
  if (hit.face != UINT32_MAX) hit.face = side.faces[hit.face];
  return hit;
}

} // namespace fvv::track
