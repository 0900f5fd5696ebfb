// Which rungs of a ladder have meshes of their own: coarser ones, where they save enough of a rung's bytes.
#pragma once

#include "mux/src/choose/decisions.h"
#include "mux/src/choose/sampled_scene.h"

namespace fvv::mux {

// The fraction of a rung's bytes that meshes of its own have to save (docs/encoding/ladder.md).
constexpr double least_mesh_saving = 0.05;

// Adds coarser meshes for lower rungs to a plan whose other tracks are chosen, for all rungs of which
// decimation is allowed. tiling: of the cameras. Throws Error (usage) if they are requested and no rung may
// have any.
void add_mesh_rungs(Plan &plan, const SampledScene &scene, const Tiling &tiling);

// Which of them are sent. Of the first group: the bytes of each mesh track with its visibility and colours,
// and of the pictures of each rung.
std::vector<MeshDecision> decide_mesh_rungs(const Plan &plan, const std::vector<uint64_t> &meshes,
                                            const std::vector<uint64_t> &pictures);

} // namespace fvv::mux
