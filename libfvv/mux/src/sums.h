// What encoding adds up for the report.
#pragma once

#include "fvv/mesh.h"
#include "fvv_geometry/decimate.h"
#include "fvv_media/video.h"
#include "fvv_mux/report.h"
#include "fvv_scene/mesh_file.h"
#include "fvv_scene/pictures.h"
#include "mux/src/choose/decisions.h"
#include "mux/src/plan.h"

#include <cmath>
#include <memory>
#include <vector>

namespace fvv::mux {

struct VisibilityFrame {
  std::vector<uint8_t> payload; // empty: the frame has none
  bool key = true;
  uint32_t vertices = 0;
  std::vector<uint16_t> cameras; // that have weights
};

struct ColourFrame {
  std::vector<uint8_t> payload; // empty: the frame has none, as delta frames
  uint32_t cells = 0;
  double squares = 0;    // of differences of display values, 0 to 255, from what cameras show
  uint32_t shown = 0;    // vertices that cameras show
  uint32_t vertices = 0; // all

  double psnr() const { return squares > 0 ? 10 * std::log10(255 * 255 * 3.0 * shown / squares) : INFINITY; }
};

void add(VisibilitySums &sums, const VisibilityFrame &frame);
void add(ColourSums &sums, const ColourFrame &frame);
// group: of the frame.
void add(DecimationSums &sums, const decimate::Report &report, size_t group);
void add(MeshChanges &changes, const scene::MeshReport &source, const fvv_mesh_report &report);
void add(RateResult &rate, const media::VideoCodec &codec, double quality, bool is_over);

// What the encoder reports about a mesh, for comparison with its source.
struct MeshOrigins {
  std::shared_ptr<const std::vector<uint32_t>> vertices; // MeshFrame::origins
  uint32_t flipped_faces;                                // at most this number are reversed
};

// Over the groups of a stream.
struct StreamSums {
  explicit StreamSums(const Plan &plan)
      : meshes(plan.meshes.size()), origins(plan.meshes.size()), videos(plan.tracks.size()),
        rates(plan.tracks.size()), sounds(plan.sounds.size()) {}

  bool warned = false;
  uint64_t bytes = 0;
  std::vector<MeshSums> meshes;                  // as Plan::meshes; nothing of those not sent
  std::vector<std::vector<MeshOrigins>> origins; // likewise, each frame; filled with Options::verify
  TrackBytes calibration;                        // of cameras that move
  TrackBytes environment;
  std::vector<TrackBytes> videos; // as Plan::tracks
  std::vector<RateResult> rates;  // likewise; filled with Options::bit_rate
  std::vector<TrackBytes> sounds; // as Plan::sounds
  size_t layouts = 0;             // groups with a layout of their own
};

// All but the time, the reads, the verdict, and warnings about the whole stream.
Report make_report(const Plan &plan, const Decisions &decisions, const StreamSums &sums);

} // namespace fvv::mux
