// The work of fvvrender: a frame, the picture and the files of it.
#pragma once

#include "fvv_view/draw.h"

namespace fvv::rendering {

struct Options {
  std::string input, output;
  int64_t frame = 0;
  view::LoadOptions load;
  view::Options draw;
  std::string depth, weights, visibility, mask; // files; empty: none
  bool force = false;
};

struct Result : view::Result {
  double load = 0; // seconds of decoding
};

// Throws Error; warnings and losses so far are in result then.
void run(const Options &options, Result &result);

std::string json(const Options &options, const Result &result);

} // namespace fvv::rendering
