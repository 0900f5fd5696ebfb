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
  Pose pose;                 // of the fine nodes
  std::vector<Vec3> offsets; // of each vertex from where the pose has it, turned with it
  std::vector<Vec3> points;
};

// How a frame is approached.
struct Approach {
  const Pose *before = nullptr; // in the frame before the last, for the motion to go on; NULL: not known
  bool near = false;            // nothing moves far against that
  bool steady = true;           // of hulls: their flicker is not followed
};

class Follower {
public:
  // error: rms by which the mesh may be off; nothing: it is of hulls, which flicker. check_cancelled: called
  // often; may throw.
  Follower(const geometry::Mesh &key, std::optional<double> error, std::function<void()> check_cancelled);

  const RunMesh &mesh() const { return body; }
  Posture start() const;
  // In the next frame. last: the posture now. Nothing where the equations have no solution.
  std::optional<Posture> follow(const Posture &last, const Approach &approach, const Target &target);
  // The pose before start(), of a mesh that goes on where another one has moved from before to last. like: of
  // each vertex that of the other's mesh; UINT32_MAX: it moves as the vertex next to it that has one.
  Pose before_start(const Follower &other, const Posture &last, const Posture &before,
                    const std::vector<uint32_t> &like) const;

private:
  static Pose extrapolated(const Pose &last, const Pose &before);
  std::vector<Vec3> points_of(const Pose &pose, const std::vector<Vec3> &offsets) const;
  // Of the mesh, from which the nearest points of the target are looked for.
  enum class Places { vertices, faces };
  // What one step leaves to the next: the faces that were nearest, where the search begins (of the target for
  // vertices and for places on faces, of the mesh for vertices of the target), and the mesh as it was.
  struct Guesses {
    std::vector<uint32_t> vertices, places, target;
    std::optional<FacingFinder> moved; // none: the mesh has moved far since
  };
  // How much of what remains after the motion is followed.
  struct Firmness {
    double smoothness, memory; // of offsets
    int solves;
  };
  Firmness firmness(const Approach &approach) const;
  std::vector<Correspondence> correspondences(const std::vector<Vec3> &points, const Target &target,
                                              double reach, size_t stride, Places places,
                                              Guesses &guesses) const;
  bool move_coarse(const Target &target, Posture &posture, Guesses &guesses);
  bool move_fine(const Target &target, Posture &posture, Guesses &guesses);
  bool move_offsets(const Target &target, const Firmness &firmness, Posture &posture, Guesses &guesses);
  void add_pull(const Correspondence &correspondence, double times);

  RunMesh body;
  double unit;
  std::optional<double> error; // rms by which the mesh may be off, in units; nothing: of hulls
  NodeGraph coarse, fine;
  SparseSystem coarse_system, fine_system, offset_system;
  Deformation shape; // by the fine nodes
  std::function<void()> check_cancelled;
};

} // namespace fvv::track
