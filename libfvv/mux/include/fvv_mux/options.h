// The options of a stream. Whether they fit a capture is checked when the stream is planned.
#pragma once

#include "fvv/video.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/values.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::media {
struct MemoryLimit;
}

namespace fvv::mux {

// A luma PSNR to reach, or the codec's own number, as in media::VideoCodec; 0 of OpenEXR is lossless.
struct Quality {
  bool is_psnr = true;
  double value = 42;       // dB; a whole number when !is_psnr
  bool by_default = false; // not set: default_quality() of the codec holds
};

// metric: value is in metres. Otherwise it is in metres or, for a capture of unknown scale, in its units.
struct Length {
  double value;
  bool metric;
};

struct TileSize {
  uint16_t width, height;
};

// A rung of the ladder of quality: the pictures once more, smaller or coarser, and perhaps coarser meshes.
struct Rung {
  double scale;          // of pictures, times that of the options; 0 < scale <= 1
  uint64_t bit_rate = 0; // of all video tracks of the rung; 0: by Options::bit_rate, or by quality
  double psnr = 0;       // dB, as Quality::value, of pictures that all have the scale 1; 0: by the scale
  double times = 0;      // the error of meshes, over that of the first rung; 0: by scale or psnr
};
constexpr size_t most_rungs = 8;
// The rate that a scale deserves is that power of it (docs/encoding/ladder.md).
constexpr double rate_of_scale = 10.0 / 3;
// dB for each halving of the size (likewise): detail that is missing in the pictures of a rung anyway hides
// that much error.
constexpr double psnr_of_halving = 9;
// By rates alone.
std::vector<Rung> ladder_of_rates(const std::vector<uint64_t> &rates);

// How far decoded geometry may be from its source. pixels: of the transmitted pictures. plain: pixels where
// there are cameras, else in the units of a capture whose scale is unknown.
struct MaxError {
  enum Unit { plain, pixels, metres };
  double value;
  Unit unit = plain;
};
constexpr double default_max_error = 0.15; // pixels
constexpr double default_view_loss = 0.1;  // dB
// Where no camera tells how large a pixel is: parts of a typical mesh's diagonal, 0.25 mm for a person.
constexpr double default_max_error_parts = 8192;

// Takes the next bytes of a stream. May throw.
using Sink = std::function<void(const void *bytes, size_t size)>;

// Calls back during a run, on the thread that runs it. Each may be empty.
struct Observer {
  std::function<void(const std::string &text)> on_warning;
  std::function<void(size_t frames)> on_progress; // frames that were done since the last call
  std::function<bool()> is_cancelled;             // called often; once true, the run throws Error (cancelled)

  void warn(const std::string &text) const {
    if (on_warning) on_warning(text);
  }
  void progress(size_t frames) const {
    if (on_progress) on_progress(frames);
  }
  void check_cancelled() const {
    if (is_cancelled && is_cancelled()) throw Error("cancelled", Error::cancelled);
  }
};

// How long encoding may take, for fewer bytes and what is checked; sets what options leave open. medium is
// for every day, slow for archives. docs/encoding/presets.md
enum class Preset { live, fast, medium, slow };

// automatic: where the source's differ from computed ones.
enum class Normals { automatic, always, never };

// automatic: as in the files, unless most of the visible surface would face away from the cameras.
enum class Winding { automatic, keep, flip };

// automatic: to the visible scene, where there are masks or meshes.
enum class Crop { automatic, none };

// Of tiles, around the silhouettes of cameras with masks. flat: grey beyond tile_fill_margin. automatic: what
// takes fewest bytes with the codec.
enum class TileFill { automatic, keep, flat, smooth };

// automatic: weights, where they take few bytes beside the pictures.
enum class Visibility { automatic, weights, none };

// Of vertices, for surface that no camera shows and players that cannot decode the pictures. automatic: where
// there are meshes and pictures of cameras, and no atlas.
enum class Colours { automatic, on, off };

// Correction of cameras that differ in exposure and white balance. automatic: where they differ noticeably.
enum class MatchColours { automatic, on, off };

// Meshes of their own for lower rungs. automatic: where they save enough of the rung's bytes.
enum class MeshLadder { automatic, on, off };

// Meshes whose connectivity changes as runs of one connectivity. automatic: where all of a frame stays within
// the budget and that takes fewer bytes; always: wherever the rms of a frame does.
enum class Track { automatic, never, always };

struct Options {
  std::string capture;  // capture.json or its folder, or, with inputs, as scene::load_capture has it
  scene::Inputs inputs; // in place of a capture.json
  Preset preset = Preset::medium;
  uint32_t codec = FVV_CODEC_AVC1;
  int bit_depth = 0; // 8, 10 or, of OpenEXR, 16; 0: the least that the codec has
  Quality quality = {true, 42, true};
  // dB that views from between cameras may lose against 42 dB and default_max_error; decides about quality,
  // max_error and the blending where they are not set. 0: nothing is chosen so. Without a value it is
  // default_view_loss, unless quality, max_error or a bit rate is set, the preset has no time for it, or
  // frames come one after the other. docs/encoding/view-loss.md
  std::optional<double> view_loss;
  uint64_t bit_rate = 0;        // of all video tracks, in place of quality; 0: none
  std::optional<TileSize> tile; // else scale holds
  double scale = 1;             // of pictures, 0 < scale <= 1
  double atlas_scale = 1;       // of those of the atlas, likewise
  std::vector<Rung> ladder; // 2 to most_rungs with falling scales or PSNR; empty: every picture is sent once
  bool ladder_by_views = false; // rungs are chosen by what views lose; ladder is empty
  MeshLadder mesh_ladder = MeshLadder::automatic;
  uint32_t texture_bits = 0; // of texture indices; 0: as the capture says, else libfvv's default
  TileFill tile_fill = TileFill::automatic;
  std::optional<Length> step;
  std::optional<MaxError> max_error; // else the defaults above
  uint32_t triangles = 0;            // of a frame, whatever that costs; 0: max_error decides
  bool keep_geometry = false;        // no decimation
  uint32_t group = 0;                // frames; 0: one second
  std::optional<int> mesh_level;     // of Draco, 0 to 10; else the preset's
  uint8_t mesh_profile = FVV_MESH_DRACO;
  bool delta = true;          // frames that share their faces with the one before as motion
  std::optional<Track> track; // docs/encoding/tracking.md; else the preset's, which is never or automatic
  Normals normals = Normals::automatic;
  std::optional<Winding> winding; // else keep, with a warning where it is wrong
  std::string objects; // file with names of objects that are followed, or auto; empty: none are followed
  uint32_t min_component = 0;
  uint32_t threads = 1;
  static constexpr uint64_t default_max_memory = uint64_t(4) << 30;
  uint64_t max_memory = default_max_memory; // of decoding one file of the capture, in bytes
  std::optional<fvv::Range> frames;         // numbers as in file names
  std::vector<std::string> data;            // WebVTT files, and folders with a file for each frame
  std::vector<std::string> cameras;         // identifiers, ranges of them (2-5) or names; empty: all
  bool pictures = true, meshes = true;
  bool repeat_configuration = false, live = false;
  bool verify = false; // keep what verify() needs
  Crop crop = Crop::automatic;
  Visibility visibility = Visibility::automatic;
  Colours colours = Colours::automatic;
  MatchColours match_colours = MatchColours::automatic;
  uint32_t colour_cells = 0; // about as many on the first mesh; 0: as measured
  // How players are to blend colours; written if any of these is set.
  std::optional<double> texture_threshold;              // least cosine
  std::optional<uint32_t> texture_best;                 // cameras
  std::optional<std::array<uint8_t, 3>> texture_unseen; // R, G, B
  std::optional<uint32_t> texture_blend;                // FVV_BLEND_VIEWER, FVV_BLEND_PAPER
  std::optional<double> texture_depth_bias, texture_depth_slope;
  // Length from the mesh inward to the surface that cameras show, in units of the scene; 0: none. Without a
  // value it is found by drawing cameras from the others.
  std::optional<double> texture_inset;
  bool undistort = false;       // pictures without lens
  double undistort_alpha = 0;   // 0: none of their pixels are blank; 1: they show all that the sources show
  bool skip_bad_frames = false; // leave out frames of a capture on disk whose files cannot be used
  bool environment = true;      // the capture's static surroundings, if it has some
  bool sound = true;            // the capture's, likewise
  uint32_t sound_bit_rate = 0;  // of each track; 0: packets of Opus and AAC-LC stay, others by their channels
  uint32_t sound_channels = 2;  // at most, of sound that is encoded; of placed sound 1
  uint64_t video_pixels = 0;    // of the frame with the cameras' tiles, at most; 0: any
  std::optional<TileSize> video_size; // likewise, of its sides
  uint32_t video_tracks = 1;          // for sets of neighbouring cameras; each camera alone: UINT32_MAX
};

// Without an option: 42 dB, or lossless.
Quality default_quality(uint32_t codec);

// Sets an option of option_table() by its name or former name, with the words of fvvmux: "max-error", "1mm";
// flags are "on" or "off". The order of calls does not matter. Throws Error (usage) for a name that does not
// exist and for a value that does not fit; options are unchanged then.
void set_option(Options &options, std::string_view name, std::string_view value);

// The options with what follows from others filled in. Throws Error (usage) where they exclude each other,
// for front ends whose users set them by name: in a struct the more exact of two options holds (bit_rate
// before quality, tile before scale). An Encoder, a Muxer and a PartPlan fill in by themselves.
Options settled(Options options);

// Of a capture that is read with the options.
media::MemoryLimit memory_limit_of(const Options &options);

} // namespace fvv::mux
