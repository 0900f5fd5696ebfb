// How the nodes of a graph move, and the step of Gauss-Newton that moves them towards correspondences while
// neighbours stay as rigid as possible.
#pragma once

#include "fvv_render/vector.h"
#include "geometry/src/track/node_graph.h"
#include "geometry/src/track/sparse_system.h"

namespace fvv::track {

using render::Mat3;

// Of the nodes of a graph.
struct Pose {
  std::vector<Mat3> rotations;
  std::vector<Vec3> places;
};

// A point of the run's mesh is to be at target, on a plane with that normal.
struct Correspondence {
  std::array<uint32_t, 3> vertices; // of the run's mesh, whose mean by barycentric the point is
  std::array<double, 3> barycentric;
  Vec3 point; // where it is
  Vec3 target, normal;
  double weight;
};

class Deformation {
public:
  // rest: places of the mesh's vertices in which nothing is deformed. graph is borrowed, and its system.
  Deformation(const NodeGraph &graph, std::vector<Vec3> rest);

  Pose still() const; // nothing moves
  Vec3 apply(const Pose &pose, uint32_t vertex) const;
  std::vector<Vec3> apply(const Pose &pose) const;
  // Of a vertex, from those of its nodes: the rotation nearest to their mean.
  Mat3 rotation(const Pose &pose, uint32_t vertex) const;
  Vec3 rest_of_node(size_t node) const { return rest[graph.vertices[node]]; }

  // One step. rigidity: weight of the edges against the correspondences, both of which have a weight of about
  // 1 a node. Returns false, and leaves the pose, where the equations have no solution.
  bool step(SparseSystem &system, const std::vector<Correspondence> &correspondences, double rigidity,
            Pose &pose) const;

  // The pattern of the equations.
  static std::vector<std::pair<uint32_t, uint32_t>> pairs(const NodeGraph &graph);

private:
  void add(SparseSystem &system, const Correspondence &correspondence, double weight, const Pose &pose) const;
  void add_edge(SparseSystem &system, uint32_t from, uint32_t to, double weight, const Pose &pose) const;

  const NodeGraph &graph;
  std::vector<Vec3> rest;
};

} // namespace fvv::track
