// fvv_render/triangle_tree.h: triangles in a hierarchy of bounding boxes, which rays and nearest points are
// looked up in. Knows triangles; knows no meshes, and nothing of what it is asked for.
#pragma once

#include "fvv_render/vector.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fvv::render {

// Split by the surface area heuristic over bins (Wald, "On fast construction of SAH-based bounding volume
// hierarchies", 2007). Whoever searches it may read all of it.
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
  // Enough for the nodes that wait while one of two children is looked at, whatever the input.
  static constexpr size_t stack_size = 58;

  // Copies what it needs: of fewer than 2^32 triangles those whose coordinates are finite.
  explicit TriangleTree(const std::vector<Triangle> &source);

  std::vector<Node> nodes;         // the root in front; none without triangles
  std::vector<uint32_t> order;     // index in the source of each triangle, as the leaves have them
  std::vector<Triangle> triangles; // in that order

private:
  struct Entry;
  struct Extent;
  uint32_t build(std::vector<Entry> &entries, size_t first, size_t end, int depth, const Extent &extent);
  static size_t split(std::vector<Entry> &entries, size_t first, size_t end, int depth, const Box &centres,
                      std::array<Extent, 2> &parts);
};

} // namespace fvv::render
