// fvvmux/runs.h: a row of weights cut into runs of about the same weight. Knows numbers only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fvv::mux {

// Cuts weights into count runs of at least one each (1 <= count <= their number), so that the heaviest run is
// as light as it can be. Answers where each run ends. Of equal cuts the one whose first runs are longest.
std::vector<size_t> balanced_runs(const std::vector<uint64_t> &weights, size_t count);

} // namespace fvv::mux
