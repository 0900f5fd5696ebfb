// Which frames of two sequences belong together.
#pragma once

#include "fvv_compare/compare.h"

#include <optional>
#include <string>
#include <vector>

namespace fvv::compare {

struct Matching {
  std::vector<FramePair> pairs;      // in order
  std::vector<std::string> warnings; // frames that have no partner, a sentence for each sequence
};

// Frames of two captures belong together when they have the same number, otherwise when they come as many
// frame durations after the first ones. frames: only these numbers of A. start: the number in A of the frame
// that B's first one shows. Error when units or frame rates are unlike, or no frame has a partner.
Matching match(const Sequence &a, const Sequence &b, const std::optional<fvv::Range> &frames,
               std::optional<int64_t> start);

} // namespace fvv::compare
