// fvvmux/segments.h: a stream as a folder of files, for web hosts that serve files but break ranges:
// configuration, one file for each group, and a manifest (spec/segments.schema.json). Knows where groups
// stand; encodes nothing.
#pragma once

#include "cli/cli.h"

#include <nlohmann/json.hpp>

namespace fvv::mux {

// Whether what was named as a capture is a stream already.
bool is_stream(const std::string &path);

class Segments {
public:
  // Refuses a folder that exists, unless it is empty or force; nothing is there under its name before
  // write().
  Segments(const std::string &folder, bool force) : name(folder), output(folder, force) {}

  // Cuts the stream in the file. Every byte is checked on the way: throws cli::Failure when it is damaged,
  // cut, or has a configuration that changes, since one file holds for all groups.
  void write(const std::string &stream);

  std::string text() const;            // what was written, a line
  nlohmann::ordered_json json() const; // the same: {folder, groups, bytes}

private:
  std::string name;
  cli::OutputFolder output;
  size_t groups = 0;
  uint64_t bytes = 0;
};

} // namespace fvv::mux
