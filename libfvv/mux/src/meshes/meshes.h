// Meshes of a capture as payloads of MESH, key and delta frames: decimated by the plan's budget, matched by
// connectivity, brought onto the lattice. Every function may run on any thread.
#pragma once

#include "fvv/mesh.h"
#include "fvv_geometry/track.h"
#include "fvv_scene/capture.h"
#include "mux/src/choose/choices.h"
#include "mux/src/plan.h"

#include <map>
#include <memory>
#include <mutex>
#include <optional>

namespace fvv::mux {

inline std::string skip_advice() {
  return option_name("skip-bad-frames") + " leaves out frames whose files cannot be used";
}

// An Error about a frame; reason: without the advice.
struct FrameError : Error {
  FrameError(const std::string &why, const std::string &advice) : Error(why + advice), reason(why) {}
  const std::string reason;
};

// Work on frames of a capture on disk: its errors name the frame and advise to skip it. number: in file
// names; none if errors name it already.
template <class Work>
auto about_frame(const scene::Capture &capture, std::optional<int64_t> number, const Work &work) {
  try {
    return work();
  } catch (const Error &error) {
    const std::string &what = error.line();
    if (error.kind != Error::failed || capture.memory || what.find(skip_advice()) != what.npos) throw;
    throw FrameError(what,
                     " (" + (number ? "frame " + std::to_string(*number) + "; " : "") + skip_advice() + ")");
  }
}

// The mesh of a frame as scene::load_mesh gives it, with errors about the frame.
inline geometry::Mesh frame_mesh(const scene::Capture &capture, int64_t number,
                                 scene::MeshReport *report = nullptr, bool normals = false) {
  return about_frame(capture, number,
                     [&] { return scene::load_mesh(capture, number, nullptr, report, normals); });
}

// For each vertex of a the vertex of b that it has become, when every face of b is that of a at the same
// place and texture coordinates agree: identical faces, or identical up to the order of vertices. Otherwise
// nothing.
std::optional<std::vector<uint32_t>> same_connectivity(const geometry::Mesh &a, const geometry::Mesh &b);

// The mesh with its vertices in another order: vertex v is order[v] of mesh. Faces are those of like, which
// has the same connectivity.
geometry::Mesh reordered(const geometry::Mesh &mesh, const std::vector<uint32_t> &order,
                         const geometry::Mesh &like);

// A mesh that was followed into a frame, and what replaces some of its faces there.
struct PatchedBody {
  geometry::Mesh mesh;
  track::Patch patch;
};

// The mesh of a frame, decimated when that is the plan: what a track is to have.
struct PreparedMesh {
  geometry::Mesh mesh;             // with the patch
  std::optional<PatchedBody> body; // when it has one
  scene::MeshReport report;
  std::optional<decimate::Report> decimation;
  QuantisationLoss loss;
};

// Frames of a group that follow each other and have the same connectivity (connectivity.h) are a run, and
// have the same faces after decimation, in the order of the first one's vertices: they could not be coded as
// motion otherwise. All else is decimated frame by frame. What a frame becomes depends on the frames of its
// group alone, whatever is asked first.
class MeshLoader {
public:
  // plan: what it says of capture and meshes is chosen. tiling: of the cameras.
  MeshLoader(const Plan &plan, const DecimationChoice &decimation, const Tiling &tiling);

  // The same meshes with another rule of tracking.
  MeshLoader(const MeshLoader &other, Track track);

  // Loads frame i (counted from 0), without its loss. Several threads may call it. Throws Error.
  PreparedMesh load(size_t i) const;

  // Whether frame i is part of a run that was tracked, which begins with it or before it.
  bool is_tracked(size_t i) const;
  // The run of tracked frames with frame i is left as it is in the files, from i on.
  void leave_untracked(size_t i);

  // Takes over the frames, groups and calibrations of the plan. Not while other threads call load().
  void extend(const Plan &plan);

  // Frees what is known of a group. load() finds it out again, should it be called for one of its frames.
  void forget(size_t group);

private:
  struct DecimatedRun {
    size_t first; // frame
    decimate::TopologyRun run;
    std::vector<std::vector<uint32_t>> orders; // of each frame's vertices; empty: as those of the first
  };
  struct Group {
    std::once_flag known;
    std::vector<DecimatedRun> runs;
    std::vector<size_t> run_of; // for each frame of the group; SIZE_MAX: none
    std::vector<track::Run> tracked;
  };
  std::shared_ptr<Group> group_at(size_t index) const;
  size_t group_index(size_t i) const;
  std::shared_ptr<Group> known_group(size_t i) const; // of a frame
  void track_frames(Group &group, size_t first, size_t count) const;
  void find_runs(Group &group, size_t first, size_t count) const;
  void add_run(Group &group, size_t group_first, size_t first,
               std::vector<std::vector<uint32_t>> orders) const;
  geometry::Mesh source(size_t i, scene::MeshReport *report = nullptr) const;
  decimate::Footprint cameras(size_t i) const;

  scene::Capture capture;
  const Tiling tiling;
  const DecimationChoice choice;
  std::vector<GroupSpan> spans;
  const bool has_constant_topology, normals; // without it no runs are searched; reads normals
  const Track track;
  const bool by_outlines; // tracked frames may be judged by masks, which these read
  const std::shared_ptr<scene::Videos> videos;
  const std::shared_ptr<const std::vector<scene::Camera>> outline_cameras; // as in the plan
  const Observer observer;
  mutable std::mutex mutex; // of groups
  mutable std::map<size_t, std::shared_ptr<Group>> groups;
};

struct MeshFrame {
  std::vector<uint8_t> payload; // empty: the frame has no mesh
  bool key = true, patched = false;
  uint32_t faces = 0; // that decoders have
  scene::MeshReport source;
  std::optional<decimate::Report> decimation; // when the plan is to decimate
  QuantisationLoss loss;                      // of what was decimated
  fvv_mesh_report report = {};
  // In a run of frames with the same connectivity: for each vertex of the decoded mesh, which vertex of the
  // frame's source it is. Otherwise nothing.
  std::shared_ptr<const std::vector<uint32_t>> origins;
};

// Of frame i (counted from 0). Failures name file, frame and element, as those of all that follow.
PreparedMesh prepare_mesh(const Plan &plan, const MeshTrack &track, size_t i);
// Throws Error if the mesh of frame i lacks normals that are to be sent.
void check_normals(const Plan &plan, size_t i, const geometry::Mesh &mesh);

// Brings it onto the lattice.
void canonicalise(const Plan &plan, size_t i, const PreparedMesh &source, fvv_mesh &mesh,
                  fvv_mesh_report &report);

// Frames first ... first + count - 1 of one group, for one track. Neighbours with the same connectivity
// become a run of a key frame and delta frames behind it; a run ends early, and another begins, where a delta
// frame takes no fewer bytes than its key frame, or a vertex would lie further off than the plan allows, and
// before a frame without a mesh.
std::vector<MeshFrame> encode_meshes(const Plan &plan, const MeshTrack &track, size_t first, size_t count);

} // namespace fvv::mux
