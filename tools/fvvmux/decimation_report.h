// fvvmux/decimation_report.h: what decimation did to all frames, in words and as JSON. Knows reports of
// frames; decides nothing.
#pragma once

#include "fvvmux/plan.h"

#include <nlohmann/json.hpp>

namespace fvv::mux {

struct DecimationSums {
  uint64_t frames = 0, kept = 0;              // that were to be decimated; of these, left as they were
  uint64_t faces_before = 0, faces_after = 0; // of all frames
  uint64_t held_faces = 0;                    // of all frames
  double squares = 0;                         // of the frames' rms, metres
  double max = 0, max_pixels = 0;             // of the worst frame
  double rms_pixels = 0;                      // likewise
  double volume_before = 0, volume_after = 0; // of all frames
  decimate::Lost vanished;                    // of all frames
  double thin_area = 0;                       // likewise

  void add(const decimate::Report &report);
  double rms() const;
  double volume_change() const; // as a share; 0 when there is no volume
};

// Prints a warning for a frame that lost pieces or thin parts. frame: its number in file names. Answers
// whether it did.
bool warn_of_losses(const Plan &plan, int64_t frame, const decimate::Report &report);

// Lines of the summary, each with its end.
std::string decimation_text(const Plan &plan, const DecimationSums &sums);
nlohmann::ordered_json decimation_json(const Plan &plan, const DecimationSums &sums);

} // namespace fvv::mux
