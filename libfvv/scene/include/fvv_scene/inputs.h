// Captures without a capture.json: files by pattern, and folders of COLMAP and nerfstudio as they are.
// docs/tools/fvvmux-inputs.md has what users read.
#pragma once

#include "fvv_cxx/values.h"
#include "fvv_scene/capture.h"

namespace fvv::scene {

// The capture that a user gave: capture.json or its folder; or the folder of a COLMAP model, or one with the
// transforms.json of nerfstudio, and the inputs; or an empty name, and the inputs alone. Throws Error: also
// if there are inputs with a capture.json. limit: that of the capture.
Capture load_capture(const std::string &given, const Inputs &inputs, const media::MemoryLimit &limit = {});

// The text of the capture.json that stands for a folder and inputs. file: where it is to be; its patterns are
// relative to the folder of it. notes: set to warnings, if not NULL. Throws Error: also for a folder that has
// a capture.json already.
std::string describe_inputs(const std::string &given, const Inputs &inputs, const std::string &file,
                            std::vector<std::string> *notes = nullptr, const media::MemoryLimit &limit = {});

// Values of options, which are named by their identifiers. Throw Error (usage) that names the option.
//
// "25" or "30000/1001", as seconds per frame.
fvv_rational parse_frame_rate(const char *option, const std::string &text);
// Of --units: a name of spec/capture.md or metres per unit; none for "unknown".
std::optional<double> parse_units(const std::string &text);
// Of --up: "+y".
uint8_t parse_up(const std::string &text);
// Of files that a shell makes of m*.obj without quotes: the pattern of all of them.
std::string pattern_of_files(const char *option, const std::vector<std::string> &files);
// Throws Error (usage) for patterns that are none, and for inputs that lack what they need.
void check_inputs(const Inputs &inputs);

// text with {name} and {id} replaced by those of the camera. percent: replaces a percent sign in the name.
std::string fill_in(const char *option, const std::string &text, const Camera &camera,
                    const std::string &percent);

} // namespace fvv::scene
