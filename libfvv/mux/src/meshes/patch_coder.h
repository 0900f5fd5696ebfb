// Patches of tracked meshes in terms of the mesh that decoders have.
#pragma once

#include "fvv/mesh.h"
#include "fvv_cxx/owned.h"
#include "fvv_geometry/track.h"
#include "mux/src/plan.h"

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fvv::mux {

// Follows a run from its key mesh on: what its vertices and faces are in the decoded mesh, of which several
// vertices may be one.
class PatchCoder {
public:
  // key: the mesh of a run; mesh_of: for each of its vertices that of the canonical mesh, UINT32_MAX: none;
  // coded: for each decoded vertex that of the canonical mesh; decoded: the key mesh.
  PatchCoder(const Plan &plan, const geometry::Mesh &key, std::vector<uint32_t> mesh_of,
             std::vector<uint32_t> coded, const fvv_mesh &decoded);

  struct Coded {
    std::vector<uint8_t> absent;     // of the faces of the decoded mesh
    std::shared_ptr<OwnedMesh> mesh; // NULL: nothing replaces them
    std::vector<uint32_t> border;    // of each vertex of mesh: the decoded mesh's
    std::vector<uint32_t> mesh_of;   // of each vertex of the patch: that of mesh; UINT32_MAX: none
    std::vector<uint32_t> decoded;   // of each vertex of the patch as decoded: that of mesh; once encoded
    uint8_t profile = FVV_MESH_DRACO;
    int level = 0;

    // Borrows, and receives what is decoded.
    fvv_mesh_patch described();
  };
  // later: lattice indices of the patch's vertices in each frame that follows. name: of the frame, for
  // messages.
  Coded encode(const track::Patch &patch, const std::vector<std::vector<int32_t>> &later,
               const std::string &name) const;

  // Goes on with the mesh that has the patch, which sequence has encoded. False: a decoded vertex is none of
  // that mesh.
  bool add(const track::Patch &patch, const Coded &coded, const fvv_mesh_sequence &sequence);

  // For each vertex of the decoded mesh that of the run's mesh, after add() of Patch::next. Of vertices that
  // are one in the decoded mesh the first stands for all.
  const std::vector<uint32_t> &origins() const { return vertex_of_decoded; }

private:
  using Corners = std::array<uint32_t, 3>; // sorted points
  static Corners corners_of(uint32_t a, uint32_t b, uint32_t c);
  void find(const geometry::Mesh &run, const fvv_mesh &decoded);
  // Of each point the first decoded vertex that a face which is not absent uses.
  std::vector<uint32_t> remaining(const std::vector<uint8_t> &absent) const;

  const Plan &plan;
  // Numbers that vertices have in common which are one in the decoded mesh, or lie on each other for good.
  std::vector<uint32_t> point_of_vertex, point_of_decoded;
  std::vector<uint32_t> vertex_of_decoded;                // the first one of the run
  std::vector<uint32_t> faces;                            // of the run's mesh
  std::map<Corners, std::vector<uint32_t>> decoded_faces; // by their points
  std::vector<uint32_t> decoded_corners;                  // of the decoded faces
  uint32_t point_count = 0;
};

} // namespace fvv::mux
