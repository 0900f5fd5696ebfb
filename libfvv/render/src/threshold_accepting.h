// Threshold accepting (Dueck and Scheuer 1990), for both searches of visibility: the way to a better sum
// often leads through a worse one. Knows nothing of what is searched.
#pragma once

namespace fvv::render {

// improve(worse) tries every change, takes those by which the sum grows by less than worse, and answers
// whether it took any. From tolerance down, and in the end only what is better.
template <class Improve> void accept_by_threshold(double tolerance, Improve improve) {
  constexpr int tolerant_passes = 8, strict_passes = 4;
  constexpr double least_gain = 1e-9; // or rounding might turn something for ever
  for (int pass = 0; pass < tolerant_passes; pass++)
    improve(tolerance * (tolerant_passes - pass) / tolerant_passes);
  for (int pass = 0; pass < strict_passes && improve(-least_gain); pass++) continue;
}

} // namespace fvv::render
