// Triangles in a hierarchy of bounding boxes: the nearest point of a set of triangles, and where rays meet a
// mesh. Doubles throughout: results are the same on every machine with IEEE doubles.
#pragma once

#include "fvv_render/rasteriser.h"
#include "fvv_render/vector.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace fvv::render {

// Split by the surface area heuristic over bins (Wald, "On fast construction of SAH-based bounding volume
// hierarchies", 2007). Searches read all of it.
struct TriangleTree {
  using Triangle = std::array<Vec3, 3>;
  struct Box {
    Vec3 low, high;
  };
  // An inner node's children are the next node and the one at second; a leaf has count > 0 faces from first.
  struct Node {
    Box box;
    uint32_t second = 0, first = 0, count = 0;
  };
  // Enough for the nodes that wait while one of two children is searched, for any input.
  static constexpr size_t stack_size = 58;

  // Copies what it needs: of fewer than 2^32 triangles those whose coordinates are finite.
  explicit TriangleTree(const std::vector<Triangle> &source);

  std::vector<Node> nodes;         // the root first; none without triangles
  std::vector<uint32_t> order;     // index in the source of each triangle, as the leaves have them
  std::vector<Triangle> triangles; // in that order

private:
  struct Entry;
  struct Extent;
  uint32_t build(std::vector<Entry> &entries, size_t first, size_t end, int depth, const Extent &extent);
  static size_t split(std::vector<Entry> &entries, size_t first, size_t end, int depth, const Box &centres,
                      std::array<Extent, 2> &parts);
};

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
  // volume hierarchies", 2007). Results are the same; a search takes longer the more the triangles have moved
  // apart.
  explicit ClosestFinder(const std::vector<TriangleTree::Triangle> &triangles,
                         const ClosestFinder *like = nullptr);

  // The best closest_on_triangle() of all, exactly; of several at the same squared distance the triangle with
  // the lowest index. guess: a triangle that may be near, such as the one that was found for a neighbour of
  // the point; a better guess makes the search faster, and the result is the same for any value. enough: a
  // squared distance at which the search may end with what it has, to find out only whether anything is so
  // near; below 0 for the best of all.
  ClosestPoint nearest(Vec3 from, uint32_t guess = UINT32_MAX, double enough = -1) const;

  // The triangles that are not left out, by their indices, such that those after each other are mostly
  // neighbours: searches in that order have good guesses.
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

  std::vector<Node> nodes; // the root first; none without triangles
  std::vector<uint32_t> order;
  std::vector<TriangleTree::Triangle> triangles; // in that order
  std::vector<uint32_t> slots;                   // of each index in the source; UINT32_MAX: left out
};

struct RayHit {
  uint32_t face = no_face; // no_face: nothing was met
  double distance = 0;     // in lengths of the ray's direction
  // Of the point that was met: weights of the face's three vertices, which add up to 1.
  std::array<double, 3> barycentric = {};
};

// A mesh that rays can be sent through.
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
  friend class RayFan;
  struct Ray;
  template <bool any> RayHit cast(const Ray &ray, double least, double most, uint32_t except) const;

  TriangleTree tree;
};

// Rays that all begin at one place, such as those to what a camera may see: results are those of
// RayCaster::blocked(). Faces are sorted into a grid of the plane that the place sees them on, so that a ray
// is tested against the few faces of its cell.
class RayFan {
public:
  // Borrows rays, which is of mesh: for meshes that are not all to one side of the place.
  RayFan(Vec3 from, const Mesh &mesh, const RayCaster &rays);

  bool blocked(Vec3 to, uint32_t except = no_face) const;

private:
  // A face in a cell: the rectangle that it covers, and its least distance along the axis; all rounded
  // outwards.
  struct Entry {
    float left, right, top, bottom, nearest;
    uint32_t slot; // of the face among the triangles of rays
  };
  void sort(const Mesh &mesh);    // into the grid, where there can be one
  Vec3 project(Vec3 point) const; // x / z, y / z, z
  uint32_t column(double x) const { return cell(x - low[0], columns); }
  uint32_t row(double y) const { return cell(y - low[1], rows); }
  uint32_t cell(double at, uint32_t count) const {
    return uint32_t(std::min(std::max(at * scale, 0.0), double(count - 1)));
  }

  Vec3 centre;
  const RayCaster &rays;
  Vec3 across, down, along;
  double low[2] = {}, scale = 0; // cells for each unit of x / z
  uint32_t columns = 0, rows = 0;
  std::vector<uint32_t> first; // of the entries of each cell, row by row; empty: without a grid
  std::vector<Entry> entries;
};

} // namespace fvv::render
