// Patches of tracked meshes in terms of the key mesh that decoders have.
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

class PatchCoder {
public:
  // source: the mesh of a run; mesh_of: for each of its vertices that of the canonical mesh, UINT32_MAX:
  // none; coded: for each decoded vertex that of the canonical mesh; decoded: the key mesh.
  PatchCoder(const Plan &plan, const geometry::Mesh &source, std::vector<uint32_t> mesh_of,
             const std::vector<uint32_t> &coded, const fvv_mesh &decoded);

  struct Coded {
    std::vector<uint8_t> absent;          // of the faces of the key mesh
    std::shared_ptr<OwnedMesh> mesh;      // NULL: nothing replaces them
    std::vector<uint32_t> border, source; // of each vertex of mesh: the key mesh's, the patch's
    uint8_t profile = FVV_MESH_DRACO;
    int level = 0;

    // Borrows.
    fvv_mesh_patch described() const;
    // For each vertex of the frame that was encoded last that of the source: former has those of the frame
    // before; a vertex of the patch is vertex_count + its number there.
    std::vector<uint32_t> origins(const std::vector<uint32_t> &former, uint32_t vertex_count,
                                  const fvv_mesh_sequence &sequence) const;
  };
  // name: of the frame, for messages.
  Coded encode(const track::Patch &patch, const std::string &name) const;

private:
  using Corners = std::array<uint32_t, 3>; // sorted
  static Corners corners_of(uint32_t a, uint32_t b, uint32_t c);

  const Plan &plan;
  const std::vector<uint32_t> mesh_of;
  std::map<Corners, std::vector<uint32_t>> faces; // decoded ones with these vertices of the canonical mesh
  std::vector<uint32_t> decoded_of; // of each vertex of the canonical mesh the first decoded one
  const geometry::Mesh &run;
  size_t face_count;
};

} // namespace fvv::mux
