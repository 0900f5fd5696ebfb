// Follows the surface of meshes whose connectivity changes in every frame: runs of frames that all have the
// connectivity of one of them, as delta frames need it. docs/encoding/tracking.md has the method, its sources
// and where it fails.
#pragma once

#include "fvv/calibration.h"
#include "fvv_geometry/decimate.h"

#include <functional>
#include <optional>
#include <vector>

namespace fvv::track {

// What a camera says of a frame.
struct MaskView {
  fvv_camera camera;           // of the mask's size
  std::vector<uint8_t> inside; // nonzero inside
  double scale = 1;            // pixels of the budget per pixel of the mask
};

struct Settings {
  // Of every frame of a run, rounding to the lattice included: rms over the surface, and no place further off
  // than decimate::max_over_rms times the budget. triangles is not used.
  decimate::Budget budget;
  // Whether a frame that is further off may have a patch; otherwise it ends its run.
  bool patches = false;
  // Of decimate::decimate(), for the budget.
  double target_error = 0;
  // For hulls, which flicker by more than the budget. A frame whose distance from its hull is beyond the
  // budget is judged by outlines then: in each camera it may lack of the mask, and have outside of it, as
  // many pixels as the frame's own decimated hull and the budget's times the length of the mask's outline. Of
  // pixels that are further off than decimate::max_over_rms times the budget it may have as many as that and
  // a twentieth of the length. Empty: the distance decides.
  std::function<std::vector<MaskView>(size_t frame)> masks = {};
  // Called often; what it throws ends the work. May be empty.
  std::function<void()> check_cancelled = {};
};

// A mesh that replaces some faces of a run's mesh from one frame on. Closed where that was: each edge of the
// faces that remain which had one of these at its other side has one of the patch. The first frame of a run
// has none.
struct Patch {
  std::vector<uint8_t> absent; // of each face of the frame's mesh: 1 where it is left out
  geometry::Mesh mesh;         // not yet rounded
  // Of each vertex of the patch that of the frame's mesh at whose place it is; UINT32_MAX: it has its own.
  std::vector<uint32_t> joins;
  // The surface with the patch, one vertex in a place, and of each vertex of patched() that of here;
  // UINT32_MAX: no face uses it. Frames that follow move this mesh, up to the next patch.
  geometry::Mesh next;
  std::vector<uint32_t> next_of;
};

struct Frame {
  geometry::Mesh mesh; // not yet rounded
  std::optional<Patch> patch;
  decimate::Report report; // against the frame's source, with the patch
};

// The frame's surface, and vertices that no face uses: what remains of its mesh, then the patch.
geometry::Mesh patched(const geometry::Mesh &mesh, const Patch &patch);

// Frames first to first + frames.size() - 1, whose meshes have the faces of the frame before; after one with
// a patch those of its Patch::next.
struct Run {
  size_t first = 0;
  size_t key = 0; // the frame whose decimated mesh is followed
  std::vector<Frame> frames;
};

// The fraction of a mesh's area that lies on the outline of at least one mask, within a quarter of a pixel.
// Of hulls it is 0.92 and more, of other surfaces only what cameras see edge-on: 0.65 of a person whom 13
// cameras see at 960x540.
double fraction_on_outlines(const geometry::Mesh &mesh, const std::vector<MaskView> &masks);
constexpr double least_of_hull = 0.85; // less: it is no hull of these masks

// Runs of two frames or more, in order; what they leave out could not be followed within the budget. Meshes
// have positions and faces alone: texture coordinates and normals are ignored. The frames of a run are
// followed from its key: with patches the first; else in both directions from the frame with most separate
// pieces, and of these that with most area. A mesh is loaded several times, one at a time is held; of results
// all are. The same on every machine that rounds as IEEE 754 has it and compiles the same code; threads play
// no part.
std::vector<Run> track(const decimate::Frames &frames, const Settings &settings);

} // namespace fvv::track
