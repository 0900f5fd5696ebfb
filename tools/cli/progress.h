// A line that says how far a run is, on a terminal.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

namespace fvv::cli {

// "label  12 of 50 frames  24 %  8.3 frames/s  5 s left" on stderr, drawn at most ten times a second, cleared
// at the end and before other lines of the run. Nothing in a pipe, nor on a terminal that cannot clear a line
// (TERM=dumb). One at a time; steps may come from one thread only.
class Progress {
public:
  // unit: what is counted, in the plural.
  Progress(const std::string &label, uint64_t steps, const std::string &unit = "frames");
  ~Progress();
  void step(uint64_t n = 1);

private:
  struct Line;
  std::unique_ptr<Line> line;
};

// Clears the line, if there is one, until its next step. Safe in a signal handler.
void hide_progress();

} // namespace fvv::cli
