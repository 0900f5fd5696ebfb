// A stream as a folder of files, for web hosts that serve files but not ranges of them: the configuration,
// one file for each group, and a manifest (spec/segments.schema.json).
#pragma once

#include "fvv_cxx/input_file.h"
#include "fvv_mux/options.h"

namespace fvv::mux {

// Whether the file that was named as a capture is a stream.
bool is_stream(const std::string &path);

// Writes a file of the folder: passes write a function that takes its bytes.
using WriteFile = std::function<void(const std::string &name, const std::function<void(const Sink &)> &fill)>;

struct Segments {
  size_t groups = 0;
  uint64_t bytes = 0; // of configurations and groups, of all rungs
  size_t rungs = 1;
};

// Cuts a stream; of a ladder of quality each rung into a folder of its own. Every byte is checked: throws
// Error if it is damaged or truncated, or if its configuration changes, as there is one file for all groups.
Segments write_segments(const InputFile &stream, const WriteFile &write_file);

} // namespace fvv::mux
