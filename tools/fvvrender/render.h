// The work of fvvrender: a frame, a target, the picture and the files of it. The method is that of
// fvv_render/view.h.
#pragma once

#include "fvv_demux/selection.h"
#include "fvv_render/view.h"
#include "fvvrender/frame.h"

#include <optional>

namespace fvv::rendering {

struct Target {
  std::optional<uint16_t> camera; // of the stream, with its lens; else pose
  std::vector<double> pose;       // eye, the point looked at, and maybe up: 6 or 9 numbers, metres
  std::optional<double> focal;    // pixels, with pose only; default: the width, 53 degrees across
  std::string size;               // "480x270"; empty: the camera's, or default_width x default_height
};
constexpr uint32_t default_width = 960, default_height = 540;

struct Options {
  std::string input, output;
  int64_t frame = 0;
  size_t rung = 0; // of a ladder of quality
  Target target;
  demux::Selection sources;                 // of the stream's cameras, by identifier
  std::optional<demux::Selection> excluded; // of these
  bool leave_one_out = false;               // the camera that the picture is taken from is no source
  render::ViewOptions view; // executor and the texturing options of the stream are set by run()
  // In place of the stream's.
  std::optional<render::Blend> blend;
  std::optional<double> threshold;
  std::optional<uint32_t> best;
  std::optional<double> inset;
  std::optional<render::Vec3> unseen;
  std::string depth, weights, visibility, mask; // files; empty: none
  bool force = false;
  uint32_t threads = 1;
  bool visible_by_default = true; // view.visibility is not given: bits where the frame has them
  bool pictures = true;           // without, the mesh has the colours of its vertices
  bool environment = true;        // draw the stream's background, if it has one
  media::MemoryLimit memory;      // of decoding a track or a picture of the environment
};

// Shares count pixels by their centres.
struct Result {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> sources;          // identifiers
  uint64_t surface = 0;                   // pixels that show the mesh
  std::vector<uint64_t> by_cameras;       // of these, with 0, 1, ... best cameras
  double load = 0, prepare = 0, draw = 0; // seconds: decoding, depth maps, the picture
  render::Visibility visibility;          // by what was drawn
  render::Blend blend;                    // by what cameras were weighted
  std::vector<uint16_t> with_bits;        // of the sources; with Visibility::given
  bool vertex_colours = false;            // where no camera shows the mesh it has those of the stream
  std::vector<std::string> warnings;      // and warnings
  std::vector<std::string> losses;        // whole lines
};

// Throws Error; warnings and losses so far are in result then.
void run(const Options &options, Result &result);

std::string json(const Options &options, const Result &result);

} // namespace fvv::rendering
