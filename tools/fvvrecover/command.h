// The work of fvvrecover: a damaged file, the stream that is written of it, and what is said about both.
#pragma once

#include "fvvrecover/report.h"

#include <string>
#include <vector>

namespace fvv::recover {

struct Command {
  std::string input, output; // output: empty: nothing is written, "-": standard output
  bool force = false;        // replace the output when it exists
};

// Writes the output unless nothing can be kept; bytes_written is 0 then. Throws Error.
Result run(const Command &command);

// Whether there is nothing to write.
bool is_empty(const Result &result);

// Lines about what is wrong with the input.
std::vector<std::string> messages(const Command &command, const Result &result);

} // namespace fvv::recover
