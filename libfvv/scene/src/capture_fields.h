// Values of a capture.json that several of its parts have. Each fails by naming the value's place, what was
// expected and what was found.
#pragma once

#include "fvv_scene/capture.h"
#include "fvv_scene/strict_json.h"

namespace fvv::scene {

double finite(const JsonValue &value);
double positive(const JsonValue &value);
// "25", "30000/1001" or 25, in lowest terms. least: of the numerator. what: for the message.
fvv_rational read_rational(const JsonValue &value, int64_t least, const char *what);
// The ranges of fvv.md clause 5.1.
Lattice read_lattice(const JsonValue &value);
EnvironmentSource read_environment(const JsonValue &value);
// Exact seconds, of either sign: 2, "-3/2".
Seconds read_seconds(const JsonValue &value);
// The name of a file, not empty.
std::string read_file_name(const JsonValue &value);
// "stream" of an object that names a file; nothing if it has none.
std::optional<uint32_t> read_stream(const JsonValue &object);
// A pattern; without a number it names one file for all frames.
Pattern read_pattern(const JsonValue &value);
// The same, which needs a number when there are several frames.
Pattern read_pattern(const JsonValue &value, const Frames &frames);

// The array of cameras, appended to capture, whose frames and units are known already.
void read_cameras(const JsonValue &value, Capture &capture, double pixel_centre);

// The text of a capture.json whose lengths, also those of the cameras in capture, are in these units: a name
// in quotes, or a number. metres_per_unit and scale_unknown are not used.
std::string format_capture(const Capture &capture, const std::string &units);

} // namespace fvv::scene
