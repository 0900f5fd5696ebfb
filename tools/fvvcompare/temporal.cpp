#include "fvvcompare/temporal.h"

#include "fvv_geometry/surface.h"

#include <algorithm>

namespace fvv::compare {

namespace {

// The finder looks among used vertices only: one that no face uses may lie anywhere.
std::vector<bool> used_vertices(const geometry::Mesh &mesh) {
  std::vector<bool> used(mesh.vertex_count());
  for (const uint32_t v : mesh.faces) used[v] = true;
  return used;
}

} // namespace

Correspondence correspondence(const geometry::Mesh &a, const geometry::Mesh &b) {
  const std::vector<Vec3> in_a = positions_of(a), in_b = positions_of(b);
  const std::vector<bool> used_a = used_vertices(a), used_b = used_vertices(b);
  Correspondence out;
  out.of_a.resize(in_b.size());
  out.by_order = in_a.size() == in_b.size() && a.faces == b.faces;
  std::vector<uint32_t> candidates;
  std::vector<Vec3> places;
  for (uint32_t v = 0; v < in_a.size(); v++)
    if (used_a[v]) {
      candidates.push_back(v);
      places.push_back(in_a[v]);
    }
  const render::ClosestFinder finder(as_triangles(places));
  for (uint32_t v = 0; v < in_b.size(); v++) {
    if (!used_b[v]) continue;
    out.of_a[v] = out.by_order ? v : candidates[finder.nearest(in_b[v]).face];
    out.furthest = std::max(out.furthest, length(in_b[v] - in_a[out.of_a[v]]));
  }
  return out;
}

MotionError motion_error(const geometry::Mesh &a_before, const geometry::Mesh &a,
                         const geometry::Mesh &b_before, const geometry::Mesh &b,
                         const Correspondence &match) {
  const std::vector<Vec3> a0 = positions_of(a_before), a1 = positions_of(a), b0 = positions_of(b_before),
                          b1 = positions_of(b);
  const std::vector<bool> used = used_vertices(b);
  double squares = 0, largest = 0, motion = 0, count = 0;
  for (size_t v = 0; v < b1.size(); v++) {
    if (!used[v]) continue;
    const uint32_t w = match.of_a[v];
    const Vec3 ours = a1[w] - a0[w], difference = b1[v] - b0[v] - ours;
    const double square = dot(difference, difference);
    squares += square;
    largest = std::max(largest, square);
    motion += dot(ours, ours);
    count++;
  }
  return {std::sqrt(squares / count), std::sqrt(largest), std::sqrt(motion / count)};
}

} // namespace fvv::compare
