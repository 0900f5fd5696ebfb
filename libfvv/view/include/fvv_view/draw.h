// A frame drawn from anywhere, textured from the cameras that see best. The method is that of
// fvv_render/view.h.
#pragma once

#include "fvv_demux/selection.h"
#include "fvv_render/view.h"
#include "fvv_view/frame.h"
#include "fvv_view/view.h"

#include <optional>

namespace fvv::view {

struct Options {
  Target target;
  demux::Selection sources;                 // of the stream's cameras, by identifier
  std::optional<demux::Selection> excluded; // of these
  bool leave_one_out = false;               // Target::camera is no source
  render::ViewOptions view; // executor and the texturing options of the stream are set by draw()
  // In place of the stream's.
  std::optional<render::Blend> blend;
  std::optional<double> threshold;
  std::optional<uint32_t> best;
  std::optional<double> inset;
  std::optional<render::Vec3> unseen;
  uint32_t threads = 1;           // the picture is the same for any number
  bool visible_by_default = true; // view.visibility is not given: bits where the frame has them
  bool pictures = true;           // without, the mesh has the colours of its vertices
  bool environment = true;        // draw the stream's environment, if it has one
};

// Shares count pixels by their centres.
struct Result {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> sources;    // identifiers
  uint64_t surface = 0;             // pixels that show the mesh
  std::vector<uint64_t> by_cameras; // of these, with 0, 1, ... best cameras
  double prepare = 0, draw = 0;     // seconds: depth maps, the picture
  render::Visibility visibility;    // by what was drawn
  render::Blend blend;              // by what cameras were weighted
  std::vector<uint16_t> with_bits;  // of the sources; with Visibility::given
  bool vertex_colours = false;      // where no camera shows the mesh it has those of the stream
  std::vector<std::string> warnings;
  std::vector<std::string> losses; // whole lines
};

// Throws Error; options that do not fit the frame are its usage. Warnings and losses so far are in result
// then.
render::ViewPicture draw(const Frame &frame, const Options &options, Result &result);

// Display values as 8 bits, rounded; three a pixel, rows from the top.
std::vector<uint8_t> eight_bits(const render::ViewPicture &picture);

} // namespace fvv::view
