// The work of fvvrender: a frame, a target, the picture. Knows which cameras are asked for and which file
// gets what; the method is fvv_render/view.h's.
#pragma once

#include "fvv_demux/selection.h"
#include "fvv_render/view.h"
#include "fvvrender/target.h"

namespace fvv::rendering {

struct Options {
  std::string input, output;
  int64_t frame = 0;
  Target target;
  demux::Selection sources;                 // of the stream's cameras, by identifier
  std::optional<demux::Selection> excluded; // of these
  bool leave_one_out = false;               // the camera that the picture is taken from is no source
  render::ViewOptions view; // executor, and what the stream says of texturing, are set by run()
  // In place of what the stream says.
  std::optional<double> threshold;
  std::optional<uint32_t> best;
  std::optional<render::Vec3> unseen;
  std::string depth, weights, visibility, mask; // files; empty: none
  bool force = false;
  uint32_t threads = 1;
  bool visible_by_default = true; // view.visibility is not asked for: bits where the frame has them
  bool environment = true;        // draw the stream's background, if it has one
};

// Shares count pixels by their centres.
struct Result {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> sources;          // identifiers
  uint64_t surface = 0;                   // pixels that show the mesh
  std::vector<uint64_t> by_cameras;       // of these, with 0, 1, ... best cameras
  double load = 0, prepare = 0, draw = 0; // seconds: decoding, depth maps, the picture
  render::Visibility visibility;          // by what was drawn
  std::vector<uint16_t> with_bits;        // of the sources; with Visibility::given
  std::vector<std::string> warnings;      // and what is odd
  std::vector<std::string> losses;        // whole lines
};

// Throws Error, Error; warnings and losses so far are in result then.
void run(const Options &options, Result &result);

// output.cpp. Whether the name asks for OpenEXR; Error (usage) for an extension that is neither png
// nor exr, or, without png, not exr. The option is named in the message.
bool is_exr(const std::string &option, const std::string &path, bool png);
// Colour as display values, rounded to 8 bits, or as linear light in R G B, with 1 for white.
std::vector<uint8_t> colour_file(const render::ViewPicture &picture, bool exr);
std::vector<uint8_t> depth_file(const render::ViewPicture &picture);
// Grey: 255 where at least half of the samples show the mesh.
std::vector<uint8_t> mask_file(const render::ViewPicture &picture);
// A channel for each source, "camera.ID".
std::vector<uint8_t> weights_file(const render::ViewPicture &picture, const std::vector<uint16_t> &sources);
std::vector<uint8_t> visibility_file(const render::ViewPicture &picture,
                                     const std::vector<uint16_t> &sources);
std::string json(const Options &options, const Result &result);

} // namespace fvv::rendering
