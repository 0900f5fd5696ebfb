// Meshes that were encoded for a stream, as its readers decode them.
#pragma once

#include "fvv/mesh.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/owned.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/plan.h"

#include <memory>
#include <string>
#include <vector>

namespace fvv::mux {

// Decoded meshes of a run of frames.
class DecodedMeshes {
public:
  explicit DecodedMeshes(const std::string &path) : name(path), sequence(nullptr, fvv_mesh_sequence_close) {}

  // The next frame. followed: whether the frame after it is a delta frame.
  const fvv_mesh &next(const MeshFrame &frame, bool followed) {
    if (frame.key) {
      fvv_mesh_free(&key);
      sequence.reset();
      check(fvv_mesh_decode(frame.payload.data(), frame.payload.size(), nullptr, nullptr, &key, &diagnostic));
      if (!followed) return key;
      fvv_mesh_sequence *opened = nullptr;
      const fvv_status status = fvv_mesh_sequence_open(&key, nullptr, &opened, &diagnostic);
      sequence.reset(opened);
      check(status);
    } else {
      check(
          fvv_mesh_sequence_decode(sequence.get(), frame.payload.data(), frame.payload.size(), &diagnostic));
    }
    return *fvv_mesh_sequence_mesh(sequence.get());
  }

  // Of the last frame; NULL: it has none.
  const fvv_mesh *patch() const { return sequence ? fvv_mesh_sequence_patch(sequence.get()) : nullptr; }

private:
  void check(fvv_status status) { fvv::check(status, name, diagnostic); }

  const std::string name;
  fvv_diagnostic diagnostic = {};
  OwnedMesh key;
  std::unique_ptr<fvv_mesh_sequence, void (*)(fvv_mesh_sequence *)> sequence;
};

// The positions of a decoded mesh in metres, which count from origin_of(lattice).
inline std::vector<float> metres_of(const fvv_mesh &mesh, const geometry::Lattice &lattice) {
  const render::Vec3 from = origin_of(lattice);
  const double origin[3] = {lattice.origin[0] - from.x, lattice.origin[1] - from.y,
                            lattice.origin[2] - from.z};
  std::vector<float> metres(3 * size_t(mesh.vertex_count));
  fvv_lattice_to_floats(origin, lattice.step, mesh.lattice, mesh.vertex_count, metres.data());
  return metres;
}

} // namespace fvv::mux
