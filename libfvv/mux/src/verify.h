// The parts of verify().
#pragma once

#include "fvv_mux/verify.h"

#include "fvv/mesh.h"
#include "fvv/stream.h"
#include "fvv_mux/plan.h"
#include "mux/src/visibility.h"

#include <memory>
#include <stdexcept>
#include <utility>

namespace fvv::mux {

// The message says what differs, but neither file nor frame.
struct MeshMismatch : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws MeshMismatch when a mesh that stands alone has other vertices or faces than the canonical source on
// the lattice; when in a run of frames with the same connectivity a vertex is further from the source vertex
// that it is said to be than the plan allows, or the faces between these are not the source's; or when
// texture indices or those of normals differ.
MeshVerdict verify_mesh(const Plan &plan, size_t frame, const fvv_mesh &decoded, const MeshOrigins &origins);

// The environment that a reader finds for a group, if the plan has one: the one that was packed, all of it;
// for the first group also part by part and picture by picture what the capture has. Answers "" or what is
// wrong. Throws Error, named name, when the stream does not decode.
std::string verify_background(fvv_stream *stream, size_t group, const Plan &plan, const std::string &name);

class VisibilityVerifier {
public:
  // plan is borrowed.
  VisibilityVerifier(const Plan &chosen, std::string file) : plan(chosen), name(std::move(file)) {}

  // For the frames of a group one after the other. mesh: of the frame, as it was read. Answers "" or what is
  // wrong. Throws Error, named after the file, when the stream does not decode.
  std::string frame(fvv_stream *stream, size_t frame, const fvv_mesh &mesh);

private:
  const Plan &plan;
  const std::string name;
  States former; // of the frame before
};

} // namespace fvv::mux
