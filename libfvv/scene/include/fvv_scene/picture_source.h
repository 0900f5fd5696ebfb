// Where the pictures of a camera come from: a file for each frame, one file for all, or a video.
#pragma once

#include "fvv/types.h"
#include "fvv_media/mask.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::scene {

class Pattern {
public:
  // None if text is not a pattern; then *what is the reason, a part of a sentence.
  static std::optional<Pattern> parse(const std::string &text, std::string *what);

  const std::string &text() const { return source; } // as it was written
  bool is_numbered() const { return numbered; }      // has a %d; otherwise it names one file
  std::string file(int64_t frame) const;             // frame >= 0
  // The frame whose file this is, if there is one: the inverse of file().
  std::optional<int64_t> frame(std::string_view file) const;
  // Added to a frame's number, for a camera that counts otherwise. No number in a name is below 0.
  int64_t offset = 0;

private:
  std::string source, prefix, suffix; // around the number, %% resolved
  bool numbered = false;
  unsigned width = 0; // digits at least
};

struct Frames;
class JsonValue;

// A moment in seconds, in lowest terms; both numbers are below 2^32.
struct Seconds {
  int64_t numerator = 0;
  uint32_t denominator = 1;
};

struct VideoSource {
  std::string file;
  std::optional<uint32_t> stream; // index among all streams of the file; nothing: the first video
  Seconds start;                  // on the file's time line, of frame number first
  int64_t first = 0;
  // Seconds of the file that a second of the capture takes: 1 unless the camera's clock was fast or slow.
  fvv_rational clock{1, 1};
};

// Where stored pictures, once turned, are in the picture that the camera's calibration is about: their top
// left pixel is its pixel (x, y). Pixels beyond that picture are cut off. Where it has none, the nearest one
// is repeated; masks have background there.
struct Placement {
  int32_t x = 0, y = 0;
  uint32_t width = 0, height = 0; // of the calibration
};

class PictureSource {
public:
  PictureSource(Pattern stills) : pattern(std::move(stills)) {}
  PictureSource(VideoSource from) : video(std::move(from)) {}

  // Exactly one of the two is there.
  std::optional<Pattern> pattern;
  std::optional<VideoSource> video;
  // Degrees clockwise, 0, 90, 180 or 270, by which stored pictures are turned. None: 0 for stills, the value
  // of the file for videos.
  std::optional<int> rotate;
  std::optional<Placement> place; // none: they have the calibration's size
  // Of masks in files of stills; none: Videos finds it by all of them.
  std::optional<media::MaskRule> mask_rule;
  size_t memory_camera = 0; // of Capture::memory, where there is one

  // As capture.json has it: the pattern, or the video's name.
  const std::string &text() const { return video ? video->file : pattern->text(); }
  // One still that all frames share.
  bool is_constant() const { return pattern && !pattern->is_numbered(); }
  // The file of a frame >= 0.
  std::string file(int64_t frame) const { return video ? video->file : pattern->file(frame); }
  bool has_same_pictures(const PictureSource &other) const;
};

// Text (a pattern), {"pattern", "offset", "rotate", "place"} or {"video", "stream", "start", "rotate",
// "place"}; the size of a place is not set. constant: a pattern may do without a number, which names one
// picture for all frames. Error.
PictureSource read_picture_source(const JsonValue &value, const Frames &frames, bool constant = false);
// As JSON; quoted: a text in JSON.
std::string format_picture_source(const PictureSource &source, std::string (*quoted)(const std::string &));

struct FrameRange {
  int64_t first, last;
};

class Gaps {
public:
  explicit Gaps(int64_t frame_step) : step(frame_step) {}

  // Numbers come in ascending order.
  void add(int64_t frame) {
    if (found.empty() || found.back().last + step != frame)
      found.push_back({frame, frame});
    else
      found.back().last = frame;
  }
  const std::vector<FrameRange> &ranges() const { return found; }
  // "3, 17 to 27"
  std::string text() const {
    constexpr size_t most = 8; // more would hide the other problems
    std::string out;
    for (size_t i = 0; i < found.size() && i < most; i++) {
      out += (i ? ", " : "") + std::to_string(found[i].first);
      if (found[i].first != found[i].last) out += " to " + std::to_string(found[i].last);
    }
    return out + (found.size() > most ? ", ..." : "");
  }

private:
  int64_t step;
  std::vector<FrameRange> found;
};

// When the pictures of a video are shown: from 0, strictly rising, in ticks of tick seconds. At least one,
// none above 2^53 ticks.
struct PictureTimes {
  fvv_rational tick = {1, 1};
  std::vector<int64_t> times;
};

struct VideoFacts {
  uint32_t width, height;      // as stored
  std::optional<int> rotation; // degrees clockwise by the file; none: it has another transform
  PictureTimes times;
  std::vector<std::string> warnings; // warnings without the file's name: "is interlaced"
  std::string timecode;              // of the first picture, as the camera wrote it; empty: none
};

// How the frames of a capture match the pictures of one video.
struct VideoReport {
  std::optional<uint16_t> camera; // nothing: the atlas
  bool masks = false;
  std::string file;
  size_t pictures = 0;
  double rate = 0; // pictures per second on average; 0: there is only one
  bool constant_rate = true;
  // Without those at which the camera is not calibrated and that have no picture; met: those with
  int64_t frames = 0, met = 0;                // a picture within half a frame duration
  double largest_offset = 0, mean_offset = 0; // seconds from frame to picture over those; the largest by size
  std::vector<FrameRange> unmet;              // numbers of the others, which take the nearest picture
  std::string unmet_text;                     // "3, 17 to 27"
  size_t used_again = 0;                      // frames whose picture the frame before has already
  size_t before = 0, between = 0,
         behind = 0;                   // pictures that no frame has: before the first that one has, ...
  std::optional<Seconds> better_start; // when all offsets are alike and more than a tenth of a frame
};

} // namespace fvv::scene
