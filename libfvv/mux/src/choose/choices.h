// What is chosen once for a stream: the error that geometry may have, with the lattice and the decimation
// that follow from it (budget.cpp, docs/encoding/budget.md); normals, winding, visibility (choices.cpp).
#pragma once

#include "fvv_geometry/track.h"
#include "mux/src/choose/sampled_scene.h"
#include "mux/src/plan.h"

namespace fvv::mux {

// By the option; else pixels, or a length where no camera sees the first mesh. Throws Error (usage) where the
// option's unit has no meaning for the capture.
ErrorBudget choose_budget(const Options &options, const SampledScene &scene);

// By the option, the capture, or the budget. delta_frames: how
// many follow a key frame on average; they take fewest bytes on a lattice finer than the error allowed, for
// which the key frame pays. has_constant_topology: there are some at all.
LatticeChoice choose_lattice(const Options &options, const SampledScene &scene, const ErrorBudget &error,
                             bool has_constant_topology, double delta_frames);

// The error that delta frames may have on a lattice, within a budget. has_constant_topology: likewise.
void allow_error(LatticeChoice &choice, const ErrorBudget &error, bool has_constant_topology);

// Warns when the lattice was given and errs by more than a budget that was given too. Returns whether it did.
bool warn_of_lattice(const Plan &plan);

// Without by_outlines. constant_topology: SampledScene::constant_topology_fraction().
TrackChoice choose_tracking(const Options &options, const SampledScene &scene, const NormalChoice &normals,
                            double constant_topology);
// Fewer leave surface that one camera alone shows, and of which cameras that are drawn from the others tell
// nothing.
constexpr size_t cameras_all_round = 6;

// For Plan::outline_cameras; rules: of each camera, if they are known.
std::shared_ptr<const std::vector<scene::Camera>> outline_cameras(std::vector<scene::Camera> cameras,
                                                                  const std::vector<media::MaskRule> &rules);
// The masks of a frame as tracking has them, for the cameras that are calibrated in it. tiling: of the
// pictures of the capture that are sent, whose pixels the budget counts.
std::vector<track::MaskView> mask_views(const scene::Capture &capture,
                                        const std::vector<scene::Camera> &cameras, scene::Videos &videos,
                                        const Tiling &tiling, int64_t frame);
// Looks whether the meshes are hulls of the masks. The plan's error is chosen.
void look_for_hulls(Plan &plan, const SampledScene &scene, const Tiling &tiling);
// Warns where everything stays a key frame though tracking was demanded.
bool warn_of_tracking(const Plan &plan);

// By the options, for a lattice that is chosen. Decimates three frames on trial.
DecimationChoice choose_decimation(const Options &options, const SampledScene &scene,
                                   const ErrorBudget &error, const LatticeChoice &lattice,
                                   const NormalChoice &normals);

// What cameras, or the budget, say of a pixel's size in a frame.
decimate::Footprint footprint(const scene::Capture &capture, const Tiling &tiling, int64_t frame,
                              bool is_length);

// A multiple of the budget for people: "0.9 px", "6 mm".
std::string budget_text(const Plan &plan, double times = 1);

// What rounding to the lattice takes away of a mesh.
struct QuantisationLoss {
  double share = 0;      // of the area: of faces that have none on the lattice, or become one with another
  decimate::Lost pieces; // of which no face is left, but for those below --min-component
  decimate::Lost flat;   // whose two sides become one
};
// decimated: pieces are in its report then.
QuantisationLoss quantisation_loss(const geometry::Mesh &mesh, const geometry::Lattice &lattice,
                                   uint32_t min_component, bool decimated);
constexpr double most_quantisation_loss = 0.01; // more is a loss that is reported

// By the option; for automatic, by how many vertices of the first frame's source lie on hard edges: their own
// faces have their normal, but all faces around their point, from which players compute it, do not. Fails if
// normals are requested and that source has none.
NormalChoice choose_normals(const Options &options, const SampledScene &scene);

// meshes: of the capture, with faces as in the files.
WindingChoice choose_winding(const Options &options, const scene::Capture &capture,
                             const std::vector<SampledMesh> &meshes);

// The winding of the stream's faces, for people. turned_away: WindingChoice::in_stream().
std::string winding_text(double turned_away, bool by_cameras);

// The identifier of the camera from whose side a viewer should look at first (spec/registry.md, keys of
// META): of those that show nearly as much of the meshes as any does, uncovered and within the picture, the
// one in whose picture they are largest, in the first and the middle frame. Not one that looks steeply up or
// down, where others do not. Nothing: there are no meshes, or no two cameras with pictures.
std::optional<uint16_t> choose_first_view(const Plan &plan, const SampledScene &scene);

// The text of META with the objects of the scene (spec/registry.md, keys of META), of all frames, with names
// by Options::objects. Empty: that is. The plan's lattice is chosen. Throws Error.
std::string find_objects(const Plan &plan);

// The cameras that are calibrated in a frame.
std::vector<fvv_camera> cameras_at(const scene::Capture &capture, int64_t frame);

// Warns when no camera sees the meshes because their units, axes or origins differ, with what would make them
// fit; true if it did. meshes: as in the files. The plan's winding is chosen.
bool warn_of_coordinates(const Plan &plan, const std::vector<SampledMesh> &meshes);

// Warns of cameras in whose pictures the mesh is never, though others see it; true if it did. meshes: as in
// the files. The plan's winding is chosen.
bool warn_of_blind_cameras(const Plan &plan, const std::vector<SampledMesh> &meshes);

// Warns of cameras whose masks have no foreground in any frame, or no background, though the mesh is in their
// pictures; true if it did. meshes: as in the files.
bool warn_of_masks(const Plan &plan, const std::vector<SampledMesh> &meshes);

// Warns when faces are inside out in the stream; true if it did. The plan's winding is chosen.
bool warn_of_winding(const Plan &plan);

} // namespace fvv::mux
