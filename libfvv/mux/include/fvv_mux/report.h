// What was chosen for a stream and what it resulted in: plain values, as text on one screen, or as JSON
// (spec/fvvmux.schema.json). A report owns what it says: it needs neither the capture nor the options any
// more. Reasons name options by fvv::option_name(), as messages do: spell() has them in words.
#pragma once

#include "fvv/types.h"
#include "fvv_cxx/error.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace fvv::mux {

// Sums over the chunks of a track.
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
  Change split_polygons, self_crossing, left_out, untextured; // of the files
  Change welded, degenerate, duplicate, unreferenced, flipped, dropped_components, dropped_faces;
  Change nonmanifold_edges, boundary_edges; // reported, not changed
  uint64_t changed_frames = 0;              // frames in which any of these except the last line is not 0
  double max_error = 0;                     // metres, per axis
};

// The groups of a track with a bit rate.
struct RateResult {
  double finest = 0, coarsest = 0; // qualities of the codec's scale
  size_t groups = 0, over = 0;     // over: the coarsest quality takes more than the rate
};

// Of all frames.
struct VisibilitySums {
  uint64_t frames = 0, keys = 0, bytes = 0, smallest = UINT64_MAX, largest = 0;
  uint64_t pairs = 0;         // of vertex and camera
  std::set<uint16_t> cameras; // that have weights in any frame

  double bits_per_pair() const { return pairs ? 8 * double(bytes) / double(pairs) : 0; }
};

struct ColourSums {
  TrackBytes track;
  uint64_t cells = 0, shown = 0, vertices = 0;
  double squares = 0;

  double psnr() const; // dB, over the vertices that cameras show; infinite without an error
};

// Triangles that decimation left in the frames of one group.
struct GroupTriangles {
  size_t group;
  uint64_t frames = 0, faces = 0, locked_faces = 0, kept = 0; // kept: frames

  double mean() const { return double(faces) / double(frames); }
};

struct DecimationSums {
  uint64_t frames = 0, kept = 0;              // that were to be decimated; of these, unchanged
  uint64_t measured = 0;                      // of frames that are not kept: whose error is known
  uint64_t faces_before = 0, faces_after = 0; // of all frames
  uint64_t locked_faces = 0;                  // of all frames
  double squares = 0;                         // of their rms, metres
  double max = 0, max_pixels = 0;             // of the worst frame
  double rms_pixels = 0;                      // likewise
  double volume_before = 0, volume_after = 0; // of frames that were measured
  size_t vanished_pieces = 0;                 // of all frames
  double vanished_area = 0;                   // likewise
  double thin_area = 0;                       // likewise
  uint64_t by_outlines = 0;                   // frames of hulls that were tracked beyond the distance
  std::vector<GroupTriangles> groups;         // that have frames to be decimated, in order

  // The group with most triangles a frame, and how many times as many as the median group it has; 0 without.
  double max_over_median(GroupTriangles *largest = nullptr) const;
  double rms() const;
  double volume_change() const; // as a fraction; 0 if there is no volume
};

// A mesh track with its visibility and colours.
struct MeshSums {
  TrackBytes mesh;    // all frames
  TrackBytes delta;   // of these the delta frames
  TrackBytes patched; // of those the ones with a patch
  uint64_t faces = 0; // of all frames
  MeshChanges changes;
  DecimationSums decimation;
  VisibilitySums visibility;
  ColourSums colours;

  uint64_t payload() const { return mesh.payload + visibility.bytes + colours.track.payload; }
};

struct MeshVerdict {
  // metres: largest difference of a coordinate between a source vertex and its decoded one
  double max_vertex_error = 0;
  double max_texture_error = 0; // likewise, in sides of the atlas
  double max_normal_error = 0;  // degrees, between a source vertex's normal and the sent or turned one

  void add(const MeshVerdict &other);
};

// The results for a stream that passed.
struct VideoVerdict {
  size_t pictures = 0;
  uint64_t squares = 0, pixels = 0; // of luma, as media::LumaError; of all pictures
  double min_psnr = INFINITY;       // dB, of the worst frame; infinite when all are exact

  double psnr() const; // dB; some pixels count
  void add(const VideoVerdict &other);
};
struct MeshTrackVerdict {
  size_t meshes = 0, visible = 0; // frames with a mesh; with correct visibility
  MeshVerdict mesh;

  void add(const MeshTrackVerdict &other);
};
// What it has itself is that of the first rung's meshes.
struct Verdict : MeshTrackVerdict {
  std::vector<MeshTrackVerdict> lower_meshes; // as Report::lower_meshes
  size_t cameras = 0;
  std::vector<VideoVerdict> videos; // as Report::videos
  // Pixels between a point's pixels in the capture's and the stream's camera; of cameras that stand still,
  // and of those that move.
  double max_reprojection = 0, moving_reprojection = 0;
  size_t environments = 0; // groups for which a reader finds the capture's environment
  size_t sounds = 0;       // groups whose sound is that which was written
};

struct LatticeReport {
  double origin[3] = {}, step = 0; // metres, or units of a capture of unknown scale
  std::string reason;
  double pixels = 0;        // the error at the nearest camera; 0: there is no camera or no mesh
  uint32_t delta_error = 0; // steps, on each axis, by which a delta frame may leave a vertex off

  // The largest difference, on each axis, between a vertex of the source and of the decoded mesh.
  double error() const { return (0.5 + delta_error) * step; }
};

// How far decoded geometry may be from its source.
struct BudgetReport {
  double max_error = 0; // rms, in pixels, or a length
  double most = 0;      // likewise, what any place may be off
  bool is_length = false;
  double pixel = INFINITY; // metres that the sharpest pixel covers; infinite: no camera sees the meshes
  bool decimates = false;
  std::string reason; // for decimation, or against it

  bool in_pixels() const { return std::isfinite(pixel) && !is_length; }
};

// Whether Options::track has an effect.
struct TrackingReport {
  bool on = false;
  std::string reason;
};

struct WindingReport {
  bool flipped = false;    // faces run the other way round than in the files
  bool by_cameras = false; // else by the volume that meshes enclose
  double turned_away = 0;  // fraction, in the stream
};

struct NormalsReport {
  uint32_t bits = 0; // of a normal index; 0: none is sent
  std::string reason;
};

// The meshes of a lower rung, which were considered, and perhaps sent.
struct LowerMeshes : MeshSums {
  size_t rung = 0;
  uint16_t track = 0;
  double max_error = 0; // as BudgetReport::max_error
  bool in_pixels = false;
  bool sent = false;
  double saving = 0; // fraction of the bytes of its rung
};

// A video track. The bytes are those of its samples.
struct VideoTrackReport : TrackBytes {
  uint16_t track = 0, alternate_group = 0; // identifiers; 0: there are no other rungs of it
  size_t rung = 0;                         // 0: the best
  size_t part = 0;                         // of the tracks of a rung that show cameras, counted from 0
  bool is_atlas = false;
  bool is_encoded = false; // it came so: what follows the cameras is not known
  uint32_t codec = 0;      // FVV_CODEC_...
  int bit_depth = 8;
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> cameras; // identifiers, in the order of the tiles
  double quality = 0;            // of the codec's scale
  uint32_t sample_frames = 0;    // by which quality was chosen or judged
  double sample_psnr = 0;        // dB; may be infinite
  double sample_rate = 0;        // bits a second
  bool sample_foreground = false;
  uint64_t target_rate = 0; // bits a second; 0: a quality was given
  double bit_rate = 0;      // of the payload, bits a second
  RateResult rate;          // of a target rate
  double pixel_share = 0;   // pixels of the video frame over those of all pictures whole
};

struct CropReport {
  bool cropped = false;
  std::string reason;
  size_t by_masks = 0, by_mesh = 0; // cameras
  size_t layouts = 0;               // groups with a layout of their own
  std::string fill;                 // around silhouettes: keep, flat, smooth
  std::string frame_limit;          // of a video frame, for people
};

struct ChoiceReport {
  bool sent = false;
  std::string reason;
};

struct CameraGains {
  uint16_t camera = 0;
  bool matched = false;
  std::array<double, 3> gains = {1, 1, 1};
  size_t places = 0;
};
struct MatchReport {
  bool applied = false;
  std::string reason;
  size_t frames = 0;                          // that were compared; 0: nothing follows
  double difference = 0, difference_left = 0; // fractions
  std::vector<CameraGains> cameras;
};

struct InsetReport {
  double length = 0; // 0: none
  std::string reason;
  std::optional<int64_t> frame; // in which cameras were drawn from the others; none: nothing follows
  size_t pixels = 0, cameras = 0, better = 0;
  bool is_compared = false;               // enough pixels were
  double psnr_without = 0, psnr_best = 0; // dB
};

// Meshes and pictures that were considered for Options::view_loss, with the blend that was chosen.
struct ViewCandidate {
  double max_error = 0, step = 0; // of meshes, as in ViewReport
  double psnr = 0;                // of pictures, dB
  double bytes = 0;               // of a group
  double loss = 0;                // dB, against views without a choice
  bool is_measured = false;       // as a whole; else the losses of meshes and pictures are added up
};

// A way of blending that was tried. gain: dB, over that of the players or of the options.
struct BlendCandidate {
  double threshold = 0;
  uint32_t best = 0;
  double gain = 0;
};

// What a lower rung of a ladder shows. loss: dB, against the first without a choice, with meshes of its own,
// which it may do without.
struct RungView {
  double scale = 1; // of pictures, relative to those of the first
  double psnr = 0;  // of them in that size, dB
  double max_error = 0;
  double loss = 0;
};

// What Options::view_loss led to. PSNR and SSIM are of cameras that were drawn from the others; bytes are
// estimates for the meshes and pictures of a group.
struct ViewReport {
  double goal = 0;          // dB
  bool is_measured = false; // else nothing but the reason follows
  std::string reason;       // why not, or why the goal is missed; empty: it is kept
  int64_t frame = 0;        // number of the first one that was tried
  double psnr = 0;          // of pictures, dB
  double max_error = 0;     // of meshes, pixels, or a length
  double step = 0;          // of their lattice
  bool is_length = false;
  bool is_paper = false; // the blend
  double threshold = 0;  // least cosine
  uint32_t best = 0;     // cameras at a place
  double loss = 0;       // dB, against views without a choice; less than 0: views gain
  double finest_psnr = 0, finest_ssim = 0, psnr_without = 0, held_out_psnr = 0, held_out_ssim = 0;
  double between_psnr = 0; // half-way between cameras, against the finest; may be infinite
  double bytes_without = 0, bytes = 0;
  std::vector<ViewCandidate>
      candidates; // by meshes, then by rising PSNR of pictures; those without a choice first
  std::vector<BlendCandidate> blends;
  std::vector<RungView> rungs; // below the first
};

// A sound track. The bytes are those of its chunks.
struct SoundReport : TrackBytes {
  uint16_t track = 0;
  std::string file, title, language; // language: BCP 47
  bool encoded = false;              // else its packets are those of the file
  std::string codec;                 // "Opus", "AAC"
  uint32_t rate = 0, channels = 0, bit_rate = 0;
  double start = 0, end = 0; // seconds of the stream
  bool placed = false, moves = false;
};

struct EnvironmentReport {
  uint64_t chunks = 0, bytes = 0; // bytes: of one
  size_t parts = 0, pictures = 0, lights = 0;
  uint64_t vertices = 0, triangles = 0, mesh_bytes = 0, picture_bytes = 0;
  double origin[3] = {}, step = 0; // of its lattice
  std::string reason;
  double max_axis_error = 0; // metres
};

// How the pictures of a video meet the frames of the capture.
struct SourceReport {
  struct Range {
    int64_t first, last;
  };
  struct Seconds {
    int64_t numerator, denominator;
  };
  std::optional<uint16_t> camera; // none: the atlas
  bool masks = false;
  std::string file;
  size_t pictures = 0;
  double rate = 0; // pictures a second on average
  bool constant_rate = true;
  int64_t frames = 0, met = 0;
  double largest_offset = 0, mean_offset = 0; // seconds
  std::vector<Range> unmet;                   // numbers of frames
  size_t used_again = 0, before = 0, between = 0, behind = 0;
  std::optional<Seconds> better_start;
};

// A camera whose lens was removed.
struct UndistortedCamera {
  uint16_t camera = 0;
  uint32_t source_width = 0, source_height = 0, width = 0, height = 0; // pixels
  double horizontal = 0, vertical = 0;                                 // degrees
  double kept = 0, blank = 0, axis_scale = 0;
  bool limited = false;
};

struct LensGapReport {
  uint16_t camera = 0;
  double r_max = 0, share = 0;
};

struct LeftOutFrame {
  int64_t frame; // number in file names
  std::string reason;
};

// Of frames that arrived while they were packed. Delays are seconds from the arrival of a frame to the last
// byte of its group.
struct RealtimeReport {
  size_t lost = 0, dropped = 0; // frames: did not become whole, or were too old
  double median_delay = 0, p95_delay = 0, largest_delay = 0;
  double start = 0; // seconds from the arrival of the first frame to the last byte of its group
  struct Step {
    int64_t frame;    // number of the first one, in file names
    size_t effort;    // 0: the most
    std::string text; // what is given up
  };
  std::vector<Step> steps; // changes of effort
  std::string end;         // why no more frames came
};

// What it has itself is that of the first rung's meshes.
struct Report : MeshSums {
  bool warned = false; // there was a warning
  uint64_t bytes = 0;
  size_t frames = 0, groups = 0;
  uint32_t group_size = 1; // ticks, at most
  fvv_rational frame_duration = {1, 25};
  int64_t ticks = 0; // that the stream lasts
  bool scale_unknown = false, live = false;
  std::string preset; // its name
  bool skips_bad_frames = false;
  std::vector<LeftOutFrame> left_out;

  bool has_meshes = false;
  uint8_t mesh_profile = 0; // FVV_MESH_...
  int mesh_level = 0;
  uint16_t mesh_track = 0;
  bool has_constant_topology = false; // some frames have the faces of the one before
  LatticeReport lattice;
  BudgetReport budget;
  WindingReport winding;
  NormalsReport normals;
  std::optional<TrackingReport> tracking; // none: Options::track is never
  uint32_t texture_bits = 0;              // 0: meshes without texture coordinates
  size_t empty_frames = 0;                // at which the stage is empty
  std::vector<LowerMeshes> lower_meshes;
  std::string shares_meshes; // why lower rungs have no meshes of their own to choose

  TrackBytes calibration; // of cameras that move
  TrackBytes environment_chunks;
  std::vector<VideoTrackReport> videos; // those of cameras, then the atlas; then those of each lower rung
  bool has_bit_rate = false;            // in place of a quality
  std::optional<double> target_psnr;    // dB, without a bit rate
  uint32_t video_tracks = 1;            // as the options say
  std::vector<double> ladder;           // scale of each rung; empty: there is one rung
  CropReport crop;
  ChoiceReport visibility_choice, colours_choice;
  double colour_cell = 0; // side, as the lattice's step
  MatchReport match;
  InsetReport inset;
  std::optional<ViewReport> view; // without the option none
  std::vector<SoundReport> sounds;
  std::optional<EnvironmentReport> environment;
  std::vector<SourceReport> sources;
  std::optional<std::vector<UndistortedCamera>> undistorted;
  std::vector<LensGapReport> lens_gaps;

  uint64_t mesh_reads = 0, picture_reads = 0, mask_reads = 0; // of files
  std::optional<RealtimeReport> realtime;
  double seconds = 0;             // from opening the capture to the last byte
  std::optional<Verdict> verdict; // Muxer::verify

  size_t rung_count() const { return ladder.empty() ? 1 : ladder.size(); }
  // Of a rung's pictures, relative to those of the first.
  double rung_scale(size_t rung) const { return rung ? ladder[rung] / ladder[0] : 1; }
  // 0: those of the first rung; k + 1: lower_meshes[k].
  MeshSums &meshes(size_t track) { return track ? lower_meshes[track - 1] : static_cast<MeshSums &>(*this); }
  const MeshSums &meshes(size_t track) const {
    return track ? lower_meshes[track - 1] : static_cast<const MeshSums &>(*this);
  }
  // Which of these a rung takes.
  size_t mesh_of(size_t rung) const;
  // Video tracks of the best rung that show cameras.
  size_t tile_track_count() const;
};

// output: the name of the stream, for people. spelling: of options that reasons name.
std::string report_text(const Report &report, const std::string &output, Spelling spelling = Spelling::plain);

// A document of spec/fvvmux.schema.json.
std::string report_json(const Report &report, const std::string &output, Spelling spelling = Spelling::plain);

// A page for browsers, whole in itself: what the bytes are of, and charts of what Options::view_loss tried.
std::string report_html(const Report &report, const std::string &output, Spelling spelling = Spelling::plain);

} // namespace fvv::mux
