// fvv_render/ray.h: where rays meet a mesh. Knows triangles; knows no cameras. The reference for visibility:
// doubles throughout, the same answers on every machine with IEEE doubles.
#pragma once

#include "fvv_render/rasteriser.h"

namespace fvv::render {

struct RayHit {
  uint32_t face = no_face; // no_face: nothing was met
  double distance = 0;     // in lengths of the ray's direction
  // Of the point that was met: weights of the face's three vertices, which add up to 1.
  std::array<double, 3> barycentric = {};
};

// A mesh that rays can be sent through, in a hierarchy of bounding boxes split by the surface area heuristic
// over bins (Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007).
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
  struct Box {
    Vec3 low, high;
  };
  // An inner node's children are the next node and the one at second; a leaf has count > 0 faces from first.
  struct Node {
    Box box;
    uint32_t second = 0, first = 0, count = 0;
  };
  struct Ray;
  struct Entry;
  uint32_t build(std::vector<Entry> &entries, size_t first, size_t end, int depth);
  static size_t split(std::vector<Entry> &entries, size_t first, size_t end, int depth);
  template <bool any> RayHit cast(const Ray &ray, double least, double most, uint32_t except) const;

  std::vector<Node> nodes;
  std::vector<uint32_t> order;                // faces as the leaves have them
  std::vector<std::array<Vec3, 3>> triangles; // in that order
};

} // namespace fvv::render
