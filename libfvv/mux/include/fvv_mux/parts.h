// A stream in parts: planned once, its groups encoded by many processes on many machines, and put together
// to the bytes that Muxer writes for the same capture and options (docs/encoding/parts.md).
#pragma once

#include "fvv_cxx/input_file.h"
#include "fvv_mux/options.h"

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::mux {

// An encoded group. stream: file header, configuration and the group, as one who joins a live stream receives
// it. report: what merge_parts() needs besides, as JSON; "warnings" in it are lines for people.
struct Part {
  std::unique_ptr<InputFile> stream;
  std::string report;
};

struct Merged {
  uint64_t bytes = 0;
  std::vector<std::string> warnings; // of planning, of each group in order, and of the whole stream
};

class PartPlan {
public:
  // Plans the stream and encodes its first group, which decides the rest: reads files of the whole capture,
  // and takes as long as Muxer until that group is written. first: takes the bytes of the first part.
  // Options::verify must not be set. Throws Error, and exceptions of first.
  PartPlan(const Options &options, const Observer &observer, const Sink &first);
  // From the bytes of a plan. name: of their file, for messages. capture: capture.json or its folder, where
  // it is now; empty: where it was planned. Throws Error for bytes that are damaged or of another version.
  PartPlan(std::string_view bytes, const std::string &name, const std::string &capture = {});
  ~PartPlan();
  PartPlan(PartPlan &&) noexcept;

  std::string bytes() const;
  // Of a plan that was made here.
  const std::string &first_report() const;
  // The first one is encoded with the plan.
  size_t group_count() const;
  size_t frame_count() const;
  size_t frames_of(size_t group) const;
  // The capture's files that encoding a group reads, capture.json among them.
  std::vector<std::string> files_of(size_t group) const;

  // Encodes a group and returns its report. Reads the files of its frames alone. Several threads may call it
  // for different groups. Throws Error: also if capture.json is not that of the plan.
  std::string encode(size_t group, uint32_t threads, const Sink &sink, const Observer &observer) const;

  // Throws Error (name: what is wrong) unless all parts are there; its text has the numbers of the others.
  void check_complete(const std::string &name, const std::vector<bool> &there) const;
  // Writes the stream. open_part is called once for each group in order. Every byte is checked. Throws Error,
  // and exceptions of open_part and sink.
  Merged merge(const std::function<Part(size_t group)> &open_part, const Sink &sink,
               const Observer &observer) const;

private:
  struct State;
  std::unique_ptr<State> state;
};

} // namespace fvv::mux
