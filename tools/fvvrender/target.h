// From where the picture is taken: a camera of the stream, or a pose that the user names. Knows cameras;
// draws nothing.
#pragma once

#include "fvvrender/frame.h"

#include <optional>

namespace fvv::rendering {

struct Target {
  std::optional<uint16_t> camera; // of the stream, with its lens; else pose
  std::vector<double> pose;       // eye, the point looked at, and maybe up: 6 or 9 numbers, metres
  std::optional<double> focal;    // pixels, with pose only; default: the width, 53 degrees across
  std::string size;               // "480x270"; empty: the camera's, or default_width x default_height
};
constexpr uint32_t default_width = 960, default_height = 540;

// The camera of the picture. A camera of the stream is scaled to size. Error (usage) for a camera that
// is not there, sizes out of range, and poses that look nowhere.
fvv_camera target_camera(const Target &target, const Frame &frame);

} // namespace fvv::rendering
