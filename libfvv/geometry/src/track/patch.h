// Where the mesh of a run is not the surface of a frame, faces of it are left out and a patch is joined to
// what remains. Two surfaces with holes at the same places are joined by strips, as range scans are zipped
// (Turk and Levoy, "Zippered polygon meshes from range images", SIGGRAPH 1994).
#pragma once

#include "fvv_geometry/track.h"
#include "geometry/src/track/facing_finder.h"
#include "geometry/src/track/half_edges.h"
#include "geometry/src/track/run_mesh.h"

namespace fvv::track {

// A frame for which patches are tried. What it is made of is borrowed.
class Patcher {
public:
  // edges: of body; points: its vertices in the frame; source: the frame's surface; substitute: the same with
  // few faces, of which patches are made.
  Patcher(const RunMesh &body, const HalfEdges &edges, const std::vector<Vec3> &points,
          const decimate::Reference &source, const RunMesh &substitute);

  // What has to be in a patch; both may be empty.
  struct Wanted {
    std::vector<uint8_t> absent; // faces of the body
    std::vector<bool> taken;     // vertices of the substitute, if they are on a part that may be taken
  };
  // What is further off than limit, in pixels of the source, is left out, and the faces around it, and what
  // is wanted. Nothing where that is more than a third of the area, or where the borders of the two surfaces
  // do not correspond.
  std::optional<Patch> make(double limit, const Wanted &wanted) const;
  // Adds what a patch leaves out, and what is around places where the surface with it is still beyond the
  // budget.
  void widen(const Patch &patch, const decimate::Outliers &beyond, Wanted &wanted) const;

private:
  struct Joint; // the parts that are left out and put in
  std::vector<uint8_t> failing(double limit) const;
  // Adds the body's faces that have one of these vertices.
  void add_faces_of(const std::vector<bool> &vertices, std::vector<uint8_t> &faces) const;
  bool is_small(const std::vector<uint8_t> &faces) const;
  void find_borders(double limit, Joint &joint) const;
  void pair_borders(Joint &joint) const;
  bool drop_islands(Joint &joint) const;
  bool grow(double limit, Joint &joint) const;
  // Of the run's mesh: that which a vertex of the substitute is on.
  uint32_t face_at(uint32_t vertex, double limit) const;
  uint32_t nearest_of_substitute(Vec3 place) const;
  Patch joined(const Joint &joint) const;

  const RunMesh &body;
  const HalfEdges &edges;
  const std::vector<Vec3> &points;
  const decimate::Reference &source;
  const RunMesh &substitute;
  HalfEdges substitute_edges;
  render::ClosestFinder finder; // of the body
  std::vector<double> off;      // of each face of the body: how far it is at most from the source, in pixels
  std::vector<double> pixel;    // that it has there
  std::vector<render::ClosestPoint> facing, near; // of the substitute's vertices on the body
};

} // namespace fvv::track
