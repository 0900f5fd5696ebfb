// fvv_render/closest.h: the point of a set of triangles that is nearest to a given one. Doubles throughout,
// the same answers on every machine with IEEE doubles.
#pragma once

#include "fvv_render/triangle_tree.h"

#include <limits>

namespace fvv::render {

struct ClosestPoint {
  uint32_t face = UINT32_MAX; // UINT32_MAX: there are no triangles, or the point is not finite
  double squared = std::numeric_limits<double>::infinity(); // distance
  Vec3 point;
  // Of that point: weights of the triangle's three corners, which add up to 1.
  std::array<double, 3> barycentric = {};
};

// The nearest point of one triangle (face is left 0): where its plane is nearest if that lies within, else
// the nearest of its edges, after Ericson, "Real-Time Collision Detection" (2005), section 5.1. What counts
// is the sign of the barycentric coordinates, taken with the given point as origin, so that the result is as
// exact near to the surface as the coordinates are. A triangle without area, or with a height below 1e-10 of
// its longest edge, is its three edges; one whose corners coincide is a point.
ClosestPoint closest_on_triangle(Vec3 from, const TriangleTree::Triangle &triangle);

class ClosestFinder {
public:
  // Triangles with a coordinate that is not finite are left out; those without area count. Fewer than 2^32.
  // like: NULL, or a finder of the same triangles at other places, of which the hierarchy is taken with boxes
  // of its own, in a fraction of the time (Wald et al., "Ray tracing deformable scenes using dynamic bounding
  // volume hierarchies", 2007). Answers are the same; they come the later the more the triangles have moved
  // apart.
  explicit ClosestFinder(const std::vector<TriangleTree::Triangle> &triangles,
                         const ClosestFinder *like = nullptr);

  // The best closest_on_triangle() of all, exactly; of several at the same squared distance the triangle with
  // the lowest index. guess: a triangle that may be near, such as the one that was found for a neighbour of
  // the point; the better it is the sooner the answer comes, which is the same for any value. enough: a
  // squared distance at which the search may end with what it has, for those who only want to know whether
  // anything is so near; below 0 for the best of all.
  ClosestPoint nearest(Vec3 from, uint32_t guess = UINT32_MAX, double enough = -1) const;

  // The triangles that are not left out, by their indices, such that those after each other are mostly
  // neighbours: whoever asks for many points by that order has good guesses.
  const std::vector<uint32_t> &along_surface() const { return order; }

private:
  // The boxes of up to four children side by side, so that a compiler can compute with several at once: x of
  // the four, y, z.
  struct Node {
    double low[12], high[12];
    uint32_t child[4]; // indices in nodes, or of triangles in the order of the leaves
    uint32_t count;
    bool leaf; // children are triangles
  };
  // False when these are not as many triangles, or some are to be left out.
  bool refit(const std::vector<TriangleTree::Triangle> &source, const ClosestFinder &like);
  static TriangleTree::Box box_around(const Node &node);
  void fill(Node &node, const TriangleTree::Box &box, uint32_t child);
  uint32_t gather(const TriangleTree &tree, uint32_t top);

  std::vector<Node> nodes; // the root in front; none without triangles
  std::vector<uint32_t> order;
  std::vector<TriangleTree::Triangle> triangles; // in that order
  std::vector<uint32_t> slots;                   // of each index in the source; UINT32_MAX: left out
};

} // namespace fvv::render
