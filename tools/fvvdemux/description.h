// capture.json of what was written, and the numbers in file names. Knows the configuration and which frames
// there are; writes no file.
#pragma once

#include "capture/capture.h"
#include "fvvdemux/group.h"

#include <optional>

namespace fvv::demux {

// Frame n of the stream is first + step * n in file names.
struct FileNumbers {
  int64_t first = 0, step = 1;
  int64_t of(int64_t frame) const { return first + step * frame; }
};

// From {"frame_numbers": {"first": ..., "step": ...}} in the metadata; from 0, with a warning, when what
// stands there would not name count frames by different numbers from 0 to 2147483647.
FileNumbers file_numbers(const fvv_configuration &configuration, int64_t count,
                         std::vector<std::string> &warnings);

// Scene and cameras as capture.json tells them, with the patterns of the files; no frames yet.
capture::Capture describe_scene(const fvv_configuration &configuration, const Options &options);

// Gives the cameras of a capture that move, by its configuration, their calibrations by file number, and the
// frames in which they have none.
void describe_motion(const fvv_configuration &configuration, const Options &options,
                     const std::vector<WrittenFrame> &frames, const FileNumbers &numbers,
                     capture::Capture &capture);

// Frames of the capture; nothing, and why in reason, when no first, step and count and no one duration say
// it.
struct FrameSpan {
  capture::Frames frames;
  fvv_rational duration;
};
std::optional<FrameSpan> span_of(const std::vector<WrittenFrame> &frames, const FileNumbers &numbers,
                                 const fvv_scene &scene, std::string &reason);

} // namespace fvv::demux
