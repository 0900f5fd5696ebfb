// The work of fvvrender: a frame, the picture and the files of it.
#pragma once

#include "fvv_view/draw.h"

namespace fvv::rendering {

// Of films alone. Time goes on with the stream, unless there is a count.
struct Film {
  std::optional<double> orbit;     // degrees over the film
  std::string path;                // file of keyframes; empty: none
  demux::Selection frames;         // one range
  std::optional<int64_t> count;    // pictures, all of Options::frame
  std::optional<fvv_rational> fps; // pictures a second; none: those of the stream
  // Of --orbit; none: such that the action is in the picture.
  std::optional<render::Vec3> target;
  std::optional<double> height, radius; // metres
};

struct Options {
  std::string input, output;
  Film film;
  int64_t frame = 0;
  view::LoadOptions load;
  view::Options draw;
  std::string depth, weights, visibility, mask; // files; empty: none
  bool force = false;
};

struct Result : view::Result {
  struct Film {
    int64_t pictures;
    fvv_rational duration; // of a picture, seconds
    int64_t first, last;   // frames of the stream
  };
  double load = 0; // seconds of decoding
  std::optional<Film> film;
};

// Throws Error; warnings and losses so far are in result then.
void run(const Options &options, Result &result);

std::string json(const Options &options, const Result &result);

} // namespace fvv::rendering
