// fvv_render/ray.h: where rays meet a mesh. Knows triangles; knows no cameras. The reference for visibility:
// doubles throughout, the same answers on every machine with IEEE doubles.
#pragma once

#include "fvv_render/rasteriser.h"
#include "fvv_render/triangle_tree.h"

namespace fvv::render {

struct RayHit {
  uint32_t face = no_face; // no_face: nothing was met
  double distance = 0;     // in lengths of the ray's direction
  // Of the point that was met: weights of the face's three vertices, which add up to 1.
  std::array<double, 3> barycentric = {};
};

// A mesh that rays can be sent through, in a tree of bounding boxes (triangle_tree.h).
//
// The triangle test is watertight (Woop, Benthin, Wald, "Watertight ray/triangle intersection", JCGT 2(1),
// 2013): a ray that passes a shared edge meets at least one of its two faces, one that hits it exactly meets
// both. Boxes are tested with the margin of Ize ("Robust BVH ray traversal", JCGT 2(2), 2013), so they lose
// no hit. Both sides of a face count. Faces seen exactly edge-on, without area, or with a coordinate that is
// not finite, are never met.
class RayCaster {
public:
  // Copies what it needs. Every index must be < vertex_count.
  explicit RayCaster(const Mesh &mesh);

  // The nearest point where origin + distance * direction meets a face other than except, for 0 <= least <
  // distance < most; of several at the same distance the face with the lowest index. direction need not be a
  // unit vector; a zero or not finite one meets nothing.
  RayHit nearest(Vec3 origin, Vec3 direction, double least, double most, uint32_t except = no_face) const;

  // Whether anything but except lies between two points, these not included.
  bool blocked(Vec3 from, Vec3 to, uint32_t except = no_face) const;

private:
  struct Ray;
  template <bool any> RayHit cast(const Ray &ray, double least, double most, uint32_t except) const;

  TriangleTree tree;
};

} // namespace fvv::render
