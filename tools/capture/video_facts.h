// capture/video_facts.h: what a video file holds, as far as a capture asks, and how its pictures met the
// frames.
#pragma once

#include "capture/gaps.h"
#include "capture/picture_source.h"

namespace fvv::capture {

// When the pictures of a video are shown: from 0, strictly rising, in ticks of so many seconds. At least one,
// none above 2^53 ticks.
struct PictureTimes {
  fvv_rational tick = {1, 1};
  std::vector<int64_t> times;
};

struct VideoFacts {
  uint32_t width, height; // as stored
  std::optional<int>
      rotation; // degrees clockwise that the file asks for; nothing: it asks for something else
  PictureTimes times;
  std::vector<std::string> warnings; // what is odd, without the file's name: "is interlaced"
};

// How the frames of a capture met the pictures of one video.
struct VideoReport {
  std::optional<uint16_t> camera; // nothing: the atlas
  bool masks = false;
  std::string file;
  size_t pictures = 0;
  double rate = 0; // pictures per second on average; 0: there is but one
  bool constant_rate = true;
  int64_t frames = 0, met = 0;                // met: those with a picture within half a frame duration
  double largest_offset = 0, mean_offset = 0; // seconds from frame to picture over those; the largest by size
  std::vector<FrameRange> unmet;              // numbers of the others, which take the nearest picture
  std::string unmet_text;                     // "3, 17 to 27"
  size_t used_again = 0;                      // frames whose picture the frame before has already
  size_t before = 0, between = 0,
         behind = 0;                   // pictures that no frame has: before the first that one has, ...
  std::optional<Seconds> better_start; // when all offsets are alike and more than a tenth of a frame
};

} // namespace fvv::capture
