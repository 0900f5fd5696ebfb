// fvvmux/mux.h: a capture becomes a fvv stream. Ties the plan, the encoders' threads and the container's
// writer together; knows the order of chunks, but no byte of them.
#pragma once

#include "cli/cli.h"
#include "fvv/mesh.h"
#include "fvvmux/decimation_report.h"
#include "fvvmux/plan.h"
#include "fvvmux/verify.h"
#include "fvvmux/visibility.h"

namespace fvv::mux {

// Sums over the frames of a track.
struct TrackBytes {
  uint64_t chunks = 0, payload = 0, smallest = UINT64_MAX, largest = 0;

  void add(uint64_t bytes);
};

// Sums of what loading and canonicalising changed, and how many frames each concerned.
struct Change {
  uint64_t count = 0, frames = 0;

  void add(uint64_t n) {
    count += n;
    frames += n > 0;
  }
};
struct MeshChanges {
  Change split_polygons, left_out; // of the files: MeshReport
  Change welded, degenerate, duplicate, unreferenced, flipped, dropped_components, dropped_faces;
  Change nonmanifold_edges, boundary_edges; // reported, not changed
  uint64_t changed_frames = 0;              // frames in which anything but the last line's is not 0
  double max_error = 0;                     // metres, per axis

  void add(const capture::MeshReport &source, const fvv_mesh_report &report);
};

// What a bit rate made of a track's groups.
struct RateResult {
  double finest = 0, coarsest = 0; // qualities of the codec's scale
  size_t groups = 0, over = 0;     // over: the coarsest quality takes more than the rate

  void add(const media::VideoCodec &codec, double quality, bool is_over);
};

struct Summary {
  Plan plan;
  uint64_t bytes = 0;
  TrackBytes mesh;                  // all frames
  TrackBytes delta;                 // of these the delta frames
  std::vector<MeshOrigins> origins; // of each frame; filled with Options::verify
  TrackBytes calibration;           // of cameras that move
  TrackBytes background;
  std::vector<TrackBytes> videos; // as Plan::tracks
  std::vector<RateResult> rates;  // likewise; filled with Options::bit_rate
  MeshChanges changes;
  DecimationSums decimation;
  std::optional<Verdict> verdict; // with Options::verify
  VisibilitySums visibility;
  double seconds = 0; // from the first look at the capture to the last byte
  size_t layouts = 0; // groups with a layout of their own

  // Bits a second of the payload of a video track.
  double bit_rate(size_t track) const;
  cli::Exit exit() const { return plan.warned ? cli::loss : cli::done; }
};

// Writes options.output, or throws and leaves nothing behind. The bytes depend on the capture and the options
// other than threads. Throws cli::Failure, capture::FileError, media::Error.
Summary mux(const Options &options);

} // namespace fvv::mux
