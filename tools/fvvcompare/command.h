// The work of fvvcompare: two sequences, their figures and the files of them.
#pragma once

#include "fvv_compare/compare.h"
#include "fvv_media/memory_limit.h"

namespace fvv::compare {

struct Command : Options {
  std::string a, b;
  std::string table;   // a file for the figures of each frame; empty: none
  std::string heatmap; // a folder for a coloured mesh of each frame; empty: none
  media::MemoryLimit memory;
  bool force = false; // replace them when they exist
};

// Throws Error if nothing can be compared; result has the losses even then. result: empty.
void run(const Command &command, Result &result);

} // namespace fvv::compare
