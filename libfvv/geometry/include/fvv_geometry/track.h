// Follows the surface of meshes whose connectivity changes in every frame: runs of frames that all have the
// connectivity of one of them, as delta frames need it. docs/encoding/tracking.md has the method, its sources
// and where it fails.
#pragma once

#include "fvv_geometry/decimate.h"

#include <functional>
#include <vector>

namespace fvv::track {

struct Settings {
  // Of every frame of a run, rounding to the lattice included: rms over the surface, and what part of the
  // area may be further off than decimate::max_over_rms times the budget. triangles is not used.
  decimate::Budget budget;
  double most_beyond = 0;
  // Of decimate::decimate(), for the budget.
  double target_error = 0;
  // Called often; what it throws ends the work. May be empty.
  std::function<void()> check_cancelled = {};
};

struct Frame {
  geometry::Mesh mesh;     // not yet rounded
  decimate::Report report; // against the frame's source
};

// Frames first to first + frames.size() - 1, whose meshes have the same faces.
struct Run {
  size_t first = 0;
  size_t key = 0; // the frame whose decimated mesh is followed
  std::vector<Frame> frames;
};

// Runs of two frames or more, in order; what they leave out could not be followed within the budget. Meshes
// have positions and faces alone: texture coordinates and normals are ignored. The frames of a run are
// followed in both directions from its key, the frame with most separate pieces, and of these that with most
// area. A mesh is loaded several times, one at a time is held; of results all are. The same on every machine
// that rounds as IEEE 754 has it and compiles the same code; threads play no part.
std::vector<Run> track(const decimate::Frames &frames, const Settings &settings);

} // namespace fvv::track
