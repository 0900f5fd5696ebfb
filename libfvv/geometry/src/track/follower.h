// Moves the mesh of a run from one frame to the next one's surface.
#pragma once

#include "geometry/src/track/deformation.h"
#include "geometry/src/track/facing_finder.h"

#include <functional>
#include <optional>

namespace fvv::track {

// A frame's surface, prepared.
struct Target {
  explicit Target(const geometry::Mesh &mesh);

  RunMesh mesh;
  std::vector<Vec3> normals; // of its vertices
  FacingFinder finder;
  std::vector<uint32_t> order; // vertices, mostly neighbours after each other
};

// The mesh of a run in one frame.
struct Posture {
  Pose pose;                   // of the fine nodes
  std::vector<double> offsets; // of each vertex along its normal
  std::vector<Vec3> points;
};

class Follower {
public:
  // hulls: what is followed flickers. check_cancelled: called often; may throw.
  Follower(const geometry::Mesh &key, bool hulls, std::function<void()> check_cancelled);

  const RunMesh &mesh() const { return body; }
  Posture start() const;
  // In the next frame. last: the posture now; before: in the frame before that; NULL: not known. Nothing
  // where the equations have no solution.
  std::optional<Posture> follow(const Posture &last, const Posture *before, const Target &target);

private:
  Pose extrapolated(const Posture &last, const Posture &before) const;
  std::vector<Vec3> points_of(const Pose &pose, const std::vector<double> &offsets) const;
  std::vector<Correspondence> correspondences(const std::vector<Vec3> &points, const Target &target,
                                              double reach, size_t stride) const;
  bool move_coarse(const Target &target, Posture &posture);
  bool move_fine(const Target &target, Posture &posture);
  bool move_offsets(const Target &target, const std::vector<double> &last, Posture &posture);

  RunMesh body;
  double unit, smoothness; // of offsets
  NodeGraph coarse, fine;
  SparseSystem coarse_system, fine_system, offset_system;
  Deformation shape; // by the fine nodes
  std::function<void()> check_cancelled;
};

} // namespace fvv::track
