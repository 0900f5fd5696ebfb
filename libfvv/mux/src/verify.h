// Reads a written stream back and compares every frame with the capture.
#pragma once

#include "fvv/mesh.h"
#include "fvv/stream.h"
#include "fvv_cxx/input_file.h"
#include "mux/src/plan.h"
#include "mux/src/sums.h"
#include "mux/src/visibility.h"

#include <memory>
#include <stdexcept>
#include <utility>

namespace fvv::mux {

// file was written by plan and decisions; origins: StreamSums::origins. Throws Error as Muxer::verify.
Verdict verify(const Plan &plan, const Decisions &decisions,
               const std::vector<std::vector<MeshOrigins>> &origins, const InputFile &file);

// The message describes the difference, without file and frame.
struct MeshMismatch : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws MeshMismatch when a mesh outside of a run has other vertices or faces than the canonical source on
// the lattice; when in a run of frames with the same connectivity a vertex is further from its source vertex
// than the plan allows, or the faces between these are not the source's; or when texture indices or those of
// normals differ.
MeshVerdict verify_mesh(const Plan &plan, const MeshTrack &track, size_t frame, const fvv_mesh &decoded,
                        const MeshOrigins &origins);

// The environment that a reader finds for a group, if the plan has one: compares it with the packed one, and
// for the first group also each part and picture with the capture. Returns "" or what is wrong. Throws Error,
// named name, when the stream does not decode.
std::string verify_environment(fvv_stream *stream, size_t group, const Plan &plan, const std::string &name);

class VisibilityVerifier {
public:
  // plan and track are borrowed. track: of the meshes.
  VisibilityVerifier(const Plan &chosen, const MeshTrack &of, std::string file)
      : plan(chosen), track(of), name(std::move(file)) {}

  // For the frames of a group one after the other. mesh: of the frame, as it was read. Returns "" or what is
  // wrong. Throws Error, named after the file, when the stream does not decode.
  std::string frame(fvv_stream *stream, size_t frame, const fvv_mesh &mesh);

private:
  const Plan &plan;
  const MeshTrack &track;
  const std::string name;
  States previous; // of the frame before
};

} // namespace fvv::mux
