// capture/picture_source.h: where the pictures (or masks) of one camera come from: a still for each frame, or
// a video. Knows names and times; reads neither stills nor videos.
#pragma once

#include "capture/pattern.h"
#include "fvv/types.h"

namespace fvv::capture {

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
};

class PictureSource {
public:
  PictureSource(Pattern stills) : pattern(std::move(stills)) {}
  PictureSource(VideoSource from) : video(std::move(from)) {}

  // Exactly one of the two is there.
  std::optional<Pattern> pattern;
  std::optional<VideoSource> video;
  // Degrees clockwise, 0, 90, 180 or 270, of what is stored. Nothing: 0 for stills, what the file says for
  // videos.
  std::optional<int> rotate;

  // As capture.json has it: the pattern, or the video's name.
  const std::string &text() const { return video ? video->file : pattern->text(); }
  // One still that all frames share.
  bool is_constant() const { return pattern && !pattern->is_numbered(); }
  // The file of a frame >= 0.
  std::string file(int64_t frame) const { return video ? video->file : pattern->file(frame); }
  bool has_same_pictures(const PictureSource &other) const;
};

// Text (a pattern), {"pattern", "rotate"} or {"video", "stream", "start", "rotate"}. constant: a pattern may
// do without a number, which names one picture for all frames. FileError.
PictureSource read_picture_source(const JsonValue &value, const Frames &frames, bool constant = false);
// As JSON; quoted: a text in JSON.
std::string format_picture_source(const PictureSource &source, std::string (*quoted)(const std::string &));

} // namespace fvv::capture
