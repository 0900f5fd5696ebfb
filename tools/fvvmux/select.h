// fvvmux/select.h: the part of a capture that goes into the stream. Knows capture and options; looks at no
// file.
#pragma once

#include "capture/capture.h"
#include "fvvmux/options.h"

namespace fvv::mux {

// Leaves out the frames, cameras, pictures and meshes that options don't want, and what a stream cannot
// carry, the latter with a warning; puts the cameras in the order that the stream has. Answers whether it
// warned. Throws cli::Failure (usage) for wishes that do not fit the capture, and when nothing is left.
bool select(capture::Capture &capture, const Options &options);

// Its parts: only the frames of a range, only the cameras that items name (none: all). Throw as select.
void restrict_frames(capture::Capture &capture, const cli::Range &range);
void restrict_cameras(capture::Capture &capture, const std::vector<std::string> &items);

// "camera 3 (left)", for messages.
std::string describe(uint16_t id, const std::string &name);
std::string describe(const capture::Camera &camera);

} // namespace fvv::mux
