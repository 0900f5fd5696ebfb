#include "mux/src/ladder/mesh_rungs.h"
#include "fvv_cxx/error.h"
#include "mux/src/choose/choices.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/stream_writer.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

// A pixel of a smaller rung is that many times as large as one of the first rung, and so is the error.
MeshTrack coarser(const Plan &plan, const SampledScene &scene, size_t rung) {
  MeshTrack track;
  track.rung = rung;
  track.times = 1 / plan.rung_detail(rung);
  ErrorBudget error = plan.error;
  error.value *= track.times;
  track.lattice = plan.lattice;
  allow_error(track.lattice, error, plan.has_constant_topology);
  Options options = plan.options;
  // The error of a smooth surface falls as the area of its triangles does.
  if (options.triangles)
    options.triangles = uint32_t(std::max(1.0, std::round(options.triangles / track.times)));
  track.decimation = choose_decimation(options, scene, error, track.lattice, plan.normals);
  return track;
}

} // namespace

void add_mesh_rungs(Plan &plan, const SampledScene &scene, const Tiling &tiling) {
  const bool forced = plan.options.mesh_ladder == MeshLadder::on;
  if (plan.rung_count() < 2) {
    if (forced)
      throw Error(option_name("mesh-ladder", "on") + ": expected " + option_name("ladder"), Error::usage);
    return;
  }
  if (!plan.has_meshes())
    plan.shares_meshes = "there are no meshes";
  else if (plan.options.mesh_ladder == MeshLadder::off)
    plan.shares_meshes = "as " + option_name("mesh-ladder") + " says";
  uint16_t next = last_track + 1;
  for (const VideoTrack &track : plan.tracks) next = std::max<uint16_t>(next, uint16_t(track.id + 1));
  const bool wanted = plan.shares_meshes.empty();
  bool as_fine = false;
  for (size_t rung = 1; rung < plan.rung_count() && wanted; rung++) {
    if (1 / plan.rung_detail(rung) == plan.meshes.back().times && !forced) {
      as_fine = true;
      continue;
    }
    MeshTrack track = coarser(plan, scene, rung);
    if (!track.decimation.on) { // the errors of lower rungs are larger
      plan.shares_meshes = track.decimation.reason;
      continue;
    }
    track.loader = std::make_shared<MeshLoader>(plan, track.decimation, tiling);
    track.id = next++;
    track.visibility = next++;
    track.colours = next++;
    plan.meshes.push_back(std::move(track));
  }
  if (as_fine) plan.shares_meshes = "coarser ones show less than coarser pictures do, for the bytes";
  if (forced && plan.meshes.size() < 2)
    throw Error(option_name("mesh-ladder", "on") +
                    ": no rung can have meshes of its own: " + plan.shares_meshes,
                Error::usage);
}

std::vector<MeshDecision> decide_mesh_rungs(const Plan &plan, const std::vector<uint64_t> &meshes,
                                            const std::vector<uint64_t> &pictures) {
  std::vector<MeshDecision> decisions(plan.meshes.size());
  size_t best = 0; // what the rung takes without meshes of its own
  for (size_t k = 1; k < plan.meshes.size(); k++) {
    MeshDecision &decision = decisions[k];
    const double whole = double(pictures[plan.meshes[k].rung]) + double(meshes[best]);
    decision.saving = whole > 0 ? (double(meshes[best]) - double(meshes[k])) / whole : 0;
    decision.sent = plan.options.mesh_ladder == MeshLadder::on || decision.saving >= least_mesh_saving;
    if (decision.sent) best = k;
  }
  return decisions;
}

} // namespace fvv::mux
