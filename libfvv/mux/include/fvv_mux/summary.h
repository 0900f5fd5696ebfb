// What was chosen for a stream and what it resulted in, as data, on one screen, or as JSON
// (spec/fvvmux.schema.json).
#pragma once

#include "fvv/mesh.h"
#include "fvv_mux/plan.h"
#include "fvv_mux/verify.h"

#include <nlohmann/json.hpp>
#include <set>

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
  uint64_t changed_frames = 0;              // frames in which any of these except the last line is not 0
  double max_error = 0;                     // metres, per axis

  void add(const scene::MeshReport &source, const fvv_mesh_report &report);
};

// The groups of a track with a bit rate.
struct RateResult {
  double finest = 0, coarsest = 0; // qualities of the codec's scale
  size_t groups = 0, over = 0;     // over: the coarsest quality takes more than the rate

  void add(const media::VideoCodec &codec, double quality, bool is_over);
};

struct VisibilityFrame {
  std::vector<uint8_t> payload; // empty: the frame has none
  bool key = true;
  uint32_t vertices = 0;
  std::vector<uint16_t> cameras; // that have weights
};

// Sums over the frames of a stream.
struct VisibilitySums {
  uint64_t frames = 0, keys = 0, bytes = 0, smallest = UINT64_MAX, largest = 0;
  uint64_t pairs = 0;         // of vertex and camera
  std::set<uint16_t> cameras; // that have weights in any frame

  void add(const VisibilityFrame &frame);
  double bits_per_pair() const { return pairs ? 8 * double(bytes) / double(pairs) : 0; }
};

struct ColourFrame {
  std::vector<uint8_t> payload; // empty: the frame has none, as delta frames
  uint32_t cells = 0;
  double squares = 0;    // of differences of display values, 0 to 255, from what cameras show
  uint32_t shown = 0;    // vertices that cameras show
  uint32_t vertices = 0; // all
};

// Of all frames.
struct ColourSums {
  TrackBytes track;
  uint64_t cells = 0, shown = 0, vertices = 0;
  double squares = 0;

  void add(const ColourFrame &frame);
  double psnr() const; // dB, over the vertices that cameras show; infinite without an error
};

struct DecimationSums {
  uint64_t frames = 0, kept = 0;              // that were to be decimated; of these, unchanged
  uint64_t faces_before = 0, faces_after = 0; // of all frames
  uint64_t locked_faces = 0;                  // of all frames
  double squares = 0;                         // of the frames' rms, metres
  double max = 0, max_pixels = 0;             // of the worst frame
  double rms_pixels = 0;                      // likewise
  double volume_before = 0, volume_after = 0; // of all frames
  decimate::Lost vanished;                    // of all frames
  double thin_area = 0;                       // likewise

  void add(const decimate::Report &report);
  double rms() const;
  double volume_change() const; // as a fraction; 0 if there is no volume
};

// A mesh track with its visibility and colours.
struct MeshSums {
  TrackBytes mesh;    // all frames
  TrackBytes delta;   // of these the delta frames
  uint64_t faces = 0; // of all frames
  MeshChanges changes;
  DecimationSums decimation;
  VisibilitySums visibility;
  ColourSums colours;

  uint64_t payload() const { return mesh.payload + visibility.bytes + colours.track.payload; }
};

// The sums that it has itself are those of the first rung's meshes.
struct Summary : MeshSums {
  Plan plan;
  uint64_t bytes = 0;
  std::vector<MeshSums> lower_meshes; // of Plan::meshes without the first one; nothing of those not sent
  std::vector<std::vector<MeshOrigins>> origins; // of Plan::meshes, each frame; filled with Options::verify
  TrackBytes calibration;                        // of cameras that move
  TrackBytes background;
  std::vector<TrackBytes> videos;         // as Plan::tracks
  std::vector<RateResult> rates;          // likewise; filled with Options::bit_rate
  std::vector<TrackBytes> sounds;         // as Plan::sounds
  std::optional<Verdict> verdict;         // with Options::verify
  double seconds = 0;                     // from opening the capture to the last byte
  uint64_t mesh_reads = 0;                // of mesh files
  scene::PictureReads picture_reads = {}; // of picture and mask files
  size_t layouts = 0;                     // groups with a layout of their own

  // Bits a second of the payload of a video track.
  double bit_rate(size_t track) const;
  // Of Plan::meshes.
  MeshSums &meshes(size_t track) { return track ? lower_meshes[track - 1] : *this; }
  const MeshSums &meshes(size_t track) const { return track ? lower_meshes[track - 1] : *this; }
};

// output: the name of the stream, for people.
std::string summary_text(const Summary &summary, const std::string &output);

nlohmann::ordered_json summary_json(const Summary &summary, const std::string &output);

} // namespace fvv::mux
