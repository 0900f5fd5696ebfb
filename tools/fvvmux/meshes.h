// fvvmux/meshes.h: meshes of a capture as payloads of MESH, key and delta frames.
// Every function is pure and may run on any thread. Knows nothing of the container.
#pragma once

#include "fvv/mesh.h"
#include "fvvmux/plan.h"

#include <memory>

namespace fvv::mux {

struct MeshFrame {
  std::vector<uint8_t> payload;
  bool key = true;
  capture::MeshReport source;
  std::optional<decimate::Report> decimation; // when the plan is to decimate
  fvv_mesh_report report = {};
  // In a run of frames with the same connectivity: for each vertex of the decoded mesh, which vertex of the
  // frame's source it is. Otherwise nothing.
  std::shared_ptr<const std::vector<uint32_t>> origins;
};

// The mesh of frame i (counted from 0), decimated when that is the plan: what the stream is to have. Failures
// name file, frame and element, as those of all that follow.
struct Source {
  capture::Mesh mesh;
  capture::MeshReport report;
  std::optional<decimate::Report> decimation;
};
Source load_source(const Plan &plan, size_t i);

// Brings it onto the lattice.
void canonicalise(const Plan &plan, size_t i, const Source &source, fvv_mesh &mesh, fvv_mesh_report &report);

// Frames first ... first + count - 1 of one group. Neighbours with the same connectivity become a run
// of a key frame and delta frames behind it; a run ends early, and another begins, where a delta frame takes
// no fewer bytes than its key frame, or a vertex would lie further off than the plan allows.
std::vector<MeshFrame> encode_meshes(const Plan &plan, size_t first, size_t count);

} // namespace fvv::mux
