// Nodes on a mesh by whose motion it moves: Sumner, Schmid, Pauly, "Embedded deformation for shape
// manipulation", ACM TOG 26(3), 2007.
#pragma once

#include "geometry/src/track/run_mesh.h"

namespace fvv::track {

struct NodeGraph {
  static constexpr size_t most = 4; // nodes of a vertex
  struct Influences {
    std::array<uint32_t, most> node = {};
    std::array<double, most> weight = {}; // add up to 1; 0: not used
  };

  // spacing: distance of neighbouring nodes along the surface. Pieces with less area than a square of that
  // have no nodes of their own, and follow those next to them; unless all are so small.
  NodeGraph(const RunMesh &mesh, double spacing);

  std::vector<uint32_t> vertices; // of the mesh, where each node lies
  std::vector<Influences> of_vertex;
  std::vector<std::pair<uint32_t, uint32_t>> edges; // of neighbouring nodes, each in both directions
};

} // namespace fvv::track
