// fvvmux/verify_mesh.h: is a decoded mesh that of the capture? Knows the plan and the source, not the stream.
#pragma once

#include "fvv/mesh.h"
#include "fvvmux/plan.h"

#include <memory>
#include <stdexcept>

namespace fvv::mux {

// What the encoder says of a mesh, to be held against its source.
struct MeshOrigins {
  std::shared_ptr<const std::vector<uint32_t>> vertices; // MeshFrame::origins
  uint32_t flipped_faces;                                // at most so many run the other way round
};

struct MeshVerdict {
  // metres: largest difference of a coordinate between a source vertex and its decoded one
  double max_vertex_error = 0;
  double max_texture_error = 0; // likewise, in sides of the atlas
  double max_normal_error = 0;  // degrees, between a source vertex's normal and the sent or turned one

  void add(const MeshVerdict &other);
};

// The message says what differs, but neither file nor frame.
struct MeshMismatch : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws MeshMismatch when a mesh that stands alone has other vertices or faces than the canonical source on
// the lattice; when in a run of frames with the same connectivity a vertex is further from the source vertex
// that it is said to be than the plan allows, or the faces between these are not the source's; or when
// texture indices or those of normals differ.
MeshVerdict verify_mesh(const Plan &plan, size_t frame, const fvv_mesh &decoded, const MeshOrigins &origins);

} // namespace fvv::mux
