// Parses values of options. Error (usage) names the option.
#pragma once

#include "fvv_scene/capture.h"

#include <optional>

namespace fvv::fvvimport {

// "A-B", or "A" alone.
scene::Frames parse_frames(const std::string &text);

// "1024x768".
struct Size {
  uint32_t width, height;
};
Size parse_size(const std::string &text);

// {name} and {id} are replaced; the rest is a pattern of spec/capture.md without further "{" and "}". option:
// for messages.
scene::Pattern parse_pattern(const char *option, const std::string &text, const scene::Camera &camera,
                             const scene::Frames &frames);
// A video, whose beginning is the first frame; "%" has no special meaning.
scene::VideoSource parse_video(const char *option, const std::string &text, const scene::Camera &camera,
                               const scene::Frames &frames);
// A pattern of the meshes, without placeholders.
scene::Pattern parse_pattern(const char *option, const std::string &text, const scene::Frames &frames);

} // namespace fvv::fvvimport
