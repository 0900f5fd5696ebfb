// Everything that is decided before the first byte is written: frames, the place of each camera's picture,
// lattice, decimation. What depends on encoded bytes is left to Decisions (decisions.h).
#pragma once

#include "fvv/visibility.h"
#include "fvv_geometry/decimate.h"
#include "fvv_media/mask.h"
#include "fvv_media/sound.h"
#include "fvv_media/video.h"
#include "fvv_mux/encoder.h"
#include "fvv_mux/options.h"
#include "fvv_mux/report.h"
#include "fvv_render/colour_match.h"
#include "fvv_render/local_origin.h"
#include "fvv_render/texture_inset.h"
#include "fvv_scene/capture.h"
#include "fvv_scene/pictures.h"
#include "fvv_scene/undistort.h"

#include <algorithm>
#include <string>
#include <vector>

namespace fvv::mux {

// How far decoded geometry may be from its source.
struct ErrorBudget {
  double value =
      default_max_error; // pixels; of a length metres, or units of a capture whose scale is unknown
  bool is_length = false;
  std::string reason;      // of a length
  decimate::Sight nearest; // of the first mesh; infinite where no camera sees it
};

struct LatticeChoice {
  geometry::Lattice lattice = {{0, 0, 0}, 0.001};
  std::string reason;
  // error() in pixels at the nearest camera; 0: there is no camera or no mesh.
  double pixels = 0;
  // Steps, on each axis, by which a delta frame may leave a vertex off its lattice point.
  uint32_t delta_error = 0;

  // The largest difference in metres, on each axis, between a vertex of the source and of the decoded mesh.
  double error() const { return (0.5 + delta_error) * lattice.step; }
};

// How far meshes may be decimated.
struct DecimationChoice {
  bool on = false;
  decimate::Budget budget;
  double pixel = INFINITY; // metres that the sharpest pixel covers on the first, middle and last mesh
  double target_error = 0; // of the simplifier, where every frame begins
  bool is_length = false;  // the budget: budget.pixels are metres
  std::string reason;
};

// Whether meshes of changing connectivity are followed.
struct TrackChoice {
  bool on = false;
  std::string reason;       // empty: Options::track is never
  bool by_outlines = false; // the meshes are hulls of the masks
};

struct NormalChoice {
  uint32_t bits = 0; // of a normal index; 0: none is sent
  std::string reason;
};

// The winding of faces.
struct WindingChoice {
  bool flip = false; // faces run the other way round than in the files
  bool by_cameras = false;
  // Before that, a fraction: of the surface nearest to the cameras in some frames that faces away from them;
  // where no camera tells, of these frames' meshes, that enclose a negative volume.
  double turned_away = 0;

  double in_stream() const { return flip ? 1 - turned_away : turned_away; }
  // It is more likely than not that the files have them the wrong way round.
  bool inside_out() const { return turned_away > 0.5; }
  // The same of the stream.
  bool stays_inside_out() const { return in_stream() > 0.5; }
};

struct VisibilityChoice {
  bool on = false;       // of the first group at least
  bool open = false;     // whether it pays is decided by the first group
  bool by_views = false; // bytes have to be seen, as Options::view_loss asks
  bool known = false; // found for colours in any case: those of the first group are made before the decision
  uint8_t threshold = FVV_VISIBILITY_THRESHOLD;
  double cosine = 0.25;        // the places for which players use a camera
  std::vector<size_t> cameras; // indices in Capture::cameras
  std::string reason;
};

struct ColourChoice {
  bool on = false;
  bool of_vertices = false;    // the meshes bring them; else from the pictures of the cameras
  uint32_t cell_size = 0;      // lattice steps; more for a mesh that has too many cells of that size
  uint8_t step = 0;            // of luma and chroma
  std::vector<size_t> cameras; // indices in Capture::cameras, of those with pictures
  std::string reason;
};

class GainTables; // pictures.cpp

// Whether the pictures of cameras are corrected, so that all show the same surface alike.
struct MatchChoice {
  bool on = false;
  std::string reason;
  std::vector<size_t> cameras;              // indices in Capture::cameras, of those with pictures
  size_t frames = 0;                        // that were compared
  render::ColourMatch found;                // of these cameras; none where nothing was compared
  std::shared_ptr<const GainTables> tables; // if on
};

// How far inside the meshes the surface lies that cameras show.
struct InsetChoice {
  double inset = 0; // in units of the scene; 0: none
  std::string reason;
  std::optional<int64_t> frame; // number of the one in which cameras were drawn from the others
  render::TextureInset found;   // there
};

// What Options::view_loss led to: settings for what options leave open.
struct ViewChoice {
  ViewReport report; // without it the other fields mean nothing
  fvv_texturing texturing = {};
  std::vector<Rung> ladder; // with Options::ladder_by_views

  bool on() const { return report.is_measured; }
};

// cameras[i] is the index in Capture::cameras of tiles[i]. Of an atlas: no cameras, one tile, its whole
// picture.
struct Tiling {
  std::vector<size_t> cameras;
  std::vector<fvv_tile> tiles;
  uint32_t width = 0, height = 0; // of the video frame
};

// Columns left ... right - 1 and rows top ... bottom - 1 of a picture; empty when right is 0.
struct Silhouette {
  uint32_t left = 0, top = 0, right = 0, bottom = 0;

  bool empty() const { return right == 0; }
  void add(const Silhouette &other);
};

// To what the pictures of cameras are cropped.
struct CropChoice {
  bool on = false;
  size_t by_masks = 0, by_mesh = 0; // cameras
  std::string reason;
  uint64_t whole_pixels = 0; // of all whole pictures of a frame, in the size in which they would be sent
  std::vector<std::vector<Silhouette>>
      boxes; // of each group and camera with pictures: what is seen of the scene
};

// Tracks differ in what they show, or in the rung at which they show it, and have a quality each.
struct VideoTrack {
  uint8_t shows;                                    // FVV_SHOWS_TILES or FVV_SHOWS_ATLAS
  Tiling tiling;                                    // of groups that have no layout of their own
  std::vector<std::vector<fvv_tile>> groups;        // the tiles of each group; empty: those of tiling
  size_t part = 0;                                  // of the tracks of a rung that show tiles, counted from 0
  std::shared_ptr<const EncodedTrack> encoded = {}; // NULL: pictures are encoded here
  size_t sample = 0;                                // of a frame's samples
  size_t rung = 0;                                  // 0: the best
  size_t best = 0;                                  // index of the track that shows the same at rung 0
  uint16_t id = 0;                                  // in the stream
  uint16_t alternate_group = 0;                     // likewise; 0: there are no other rungs of it

  bool is_atlas() const { return shows == FVV_SHOWS_ATLAS; }
  bool is_in(size_t which) const { return rung == which || !alternate_group; }
  const std::vector<fvv_tile> &tiles_of(size_t group) const {
    return groups.empty() ? tiling.tiles : groups[group];
  }
};

class MeshLoader; // meshes.h

// The meshes of the first rung or, with a larger error, those of a lower one. Rungs without meshes of their
// own take those of the next better one. Visibility and colours belong to one mesh track.
struct MeshTrack {
  size_t rung = 0;
  double times = 1;      // the plan's error
  LatticeChoice lattice; // that of the plan, with the error of these delta frames
  DecimationChoice decimation;
  std::shared_ptr<MeshLoader> loader;           // where they come from
  uint16_t id = 0, visibility = 0, colours = 0; // of its tracks in the stream
};

struct Plan;
// How players are to blend colours, if that is not their default.
std::optional<fvv_texturing> texturing_of(const Plan &plan);

// An audio track. The time of packets is that of the stream, which begins at 0.
struct SoundTrack {
  scene::SoundSource source;
  media::SoundPackets packets;
};

// A track of timed payloads of another format (fvv.md clause 21): of captions it has cues, of a sequence
// files.
struct DataCue {
  double start, end; // seconds of the stream
  std::string text;  // lines, each with its end
};
struct DataTrack {
  std::string name, media_type, codec;
  std::string head; // of captions: what comes before the cues
  std::vector<DataCue> cues;
  std::vector<std::string> files; // one for each frame of the plan
};

struct PackedEnvironment; // environment.h

// A group of the stream: its frames, and the ticks that it covers.
struct GroupSpan {
  size_t first, count;
  int64_t start, end;
};
// A group ends after group_size ticks, and where the stage becomes empty: a mesh is valid until the next one,
// or the end of its group (fvv.md clause 11). One begins with its first frame, or where the stage became
// empty.
std::vector<GroupSpan> groups_of(const scene::Capture &capture, uint32_t group_size);

// A frame that Options::skip_bad_frames left out.
struct BadFrame {
  int64_t number;     // in file names
  std::string reason; // with the file
};

// Of a video frame, in pixels. name: whose limit it is.
struct FrameLimit {
  uint32_t width, height;
  uint64_t pixels;
  std::string name;
};

// Made once, and passed on as const: encoding changes nothing of it. Of frames in memory, which are not known
// at first, extend_plan adds groups between the encoding of two groups.
struct Plan {
  Options options;
  Observer observer;
  scene::Capture capture;  // frames restricted, cameras by rising identifier, unwanted patterns removed
  uint32_t group_size = 1; // ticks, at most
  size_t effort = 0;       // step (effort_steps.h) of groups that follow; changes between groups alone
  std::vector<GroupSpan> groups;
  std::vector<BadFrame> bad; // by rising number
  // Some frames have the faces of the one before: groups may have delta frames.
  bool has_constant_topology = false;
  TrackChoice tracking;
  ErrorBudget error;
  LatticeChoice lattice;
  std::vector<MeshTrack> meshes; // if there are some: of the first rung, and of lower ones in order
  std::string shares_meshes;     // why lower rungs have no meshes of their own to choose
  NormalChoice normals;
  WindingChoice winding;
  uint32_t texture_bits = 0;             // 0: meshes without texture coordinates
  std::vector<VideoTrack> tracks;        // tracks of cameras, if any, then the atlas, if there is one; these,
                                         // as far as they are encoded here, for each further rung
  std::shared_ptr<scene::Videos> videos; // reads pictures
  std::vector<scene::VideoReport> sources;
  // Of each camera of the capture; empty: they are found where masks are read. For plans whose groups are
  // encoded elsewhere, without the files of the others.
  std::vector<media::MaskRule> mask_rules;
  // For tracking by outlines: all cameras of the capture's files, those too whose pictures are not sent, with
  // their lens distortion. Of frames in memory NULL: those of the capture. With the rules of their masks.
  std::shared_ptr<const std::vector<scene::Camera>> outline_cameras;
  std::vector<media::MaskRule> outline_rules;
  bool warned = false; // while it was made
  CropChoice crop;
  std::optional<uint16_t> first_view; // identifier of a camera
  std::string objects;                // of META (find_objects); empty: none
  Tiling whole; // what is cropped: the pictures of all cameras in the size in which they are sent
  VisibilityChoice visibility;
  MatchChoice match;
  InsetChoice inset;
  ViewChoice view;
  ColourChoice colours;
  std::shared_ptr<const scene::Undistortion> undistortion; // with Options::undistort: what the cameras were
  std::shared_ptr<const PackedEnvironment> environment;    // if there is one
  std::vector<SoundTrack> sounds;                          // those of the capture that the stream has
  std::vector<DataTrack> data;
  FrameLimit frame_limit = {}; // of a video frame with tiles of cameras

  // Of one rung.
  size_t tile_track_count() const {
    return size_t(
        std::count_if(tracks.begin(), tracks.end(), [](const auto &t) { return !t.is_atlas() && !t.rung; }));
  }
  size_t rung_count() const { return std::max<size_t>(1, options.ladder.size()); }
  // Of a rung's pictures, relative to those of the first.
  double rung_scale(size_t rung) const {
    return rung ? options.ladder[rung].scale / options.ladder[0].scale : 1;
  }
  // By which the error of meshes is divided. Where pictures stay as large, meshes are seen as well as before,
  // and may err half as much more as those of the size that deserves the quality (docs/encoding/ladder.md).
  double rung_detail(size_t rung) const {
    if (rung && options.ladder[rung].times) return 1 / options.ladder[rung].times;
    if (!rung || !options.ladder[rung].psnr) return rung_scale(rung);
    return std::exp2((options.ladder[rung].psnr - options.ladder[0].psnr) / (2 * psnr_of_halving));
  }
  bool has_meshes() const { return capture.meshes.has_value(); }
  bool has_mesh(size_t frame) const { return capture.has_mesh(capture.frames.number(int64_t(frame))); }
  size_t frame_count() const { return size_t(capture.frames.count); }
  size_t group_count() const { return groups.size(); }
  size_t first_of(size_t group) const { return groups[group].first; }
  size_t frames_of(size_t group) const { return groups[group].count; }
  size_t group_of(size_t frame) const {
    const auto after = std::upper_bound(groups.begin(), groups.end(), frame,
                                        [](size_t f, const GroupSpan &group) { return f < group.first; });
    return size_t(after - groups.begin()) - 1;
  }
  int64_t tick_of(size_t frame) const { return capture.frames.place(int64_t(frame)); }
  int64_t end() const { return capture.frames.places(); } // first tick after the stream
};

// Checks every file first: an Error has a line for each problem; warnings are
// printed.
Plan make_plan(const Options &options, const Observer &observer);
// The same for a capture whose frames are in memory: those that are there now are all that is looked at.
// encoded: tracks whose samples are among them.
Plan make_plan(scene::Capture capture, const std::vector<EncodedTrack> &encoded, const Options &options,
               const Observer &observer);
// Adds one more group to a plan of frames in memory: how its pictures are cropped and laid out. The video
// frame keeps its size; where the crops need more room, the group's pictures are sent smaller.
void extend_plan(Plan &plan, const GroupSpan &group);

// Frames in a group: by the options, or one second.
uint32_t group_size_of(const Options &options, const fvv_rational &frame_duration);

// What coordinates in float count from.
inline render::Vec3 origin_of(const geometry::Lattice &lattice) {
  return render::local_origin(lattice.origin, lattice.step);
}

// Cameras whose pictures are transmitted, at the size in which they are; without any, all cameras. frame: its
// number in file names. tiling: of the cameras.
decimate::Footprint footprint(const scene::Capture &capture, const Tiling &tiling, int64_t frame);

} // namespace fvv::mux
