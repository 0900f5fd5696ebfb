// fvvmux/frame_limit.h: how large a video frame may be for decoders to take it. Knows codecs by their levels;
// knows no capture.
#pragma once

#include "fvvmux/options.h"

namespace fvv::mux {

// Of the codec's highest level that decoders are sure to have (5.2 of H.264, HEVC, VP9 and AV1; sides alone
// for stills), at this rate of frames; each side at most what browsers upload as a texture.
FrameLimit decoder_limit(const Options &options, const fvv_rational &frame_duration);

// The same for the frames with tiles of cameras, and no more than the options ask for.
FrameLimit frame_limit(const Options &options, const fvv_rational &frame_duration);

bool fits(uint32_t width, uint32_t height, const FrameLimit &limit);

// "8192x8192 and 9437184 pixels (H.264 level 5.2)".
std::string limit_text(const FrameLimit &limit);

} // namespace fvv::mux
