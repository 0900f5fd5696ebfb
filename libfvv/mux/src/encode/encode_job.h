// Encodes the groups of a plan on several threads and writes them in order.
#pragma once

#include "fvv_mux/summary.h"
#include "mux/src/stream_writer.h"

#include <chrono>
#include <memory>

namespace fvv::mux {

// Every function throws Error, and exceptions of the sink; then sink received an incomplete stream.
class EncodeJob {
public:
  // summary has the plan, and gets the sums; both are borrowed. The first group decides what is open in the
  // plan.
  EncodeJob(Summary &summary, const Sink &sink);
  // For one group of a plan in which nothing is open. Writes file header and configuration. nominal: of the
  // job that wrote the first group.
  EncodeJob(Summary &summary, const Sink &sink, const NominalRates &nominal, size_t group);
  ~EncodeJob();

  // All groups of the plan.
  void run();
  // One group, the next one.
  void run_group(size_t group);
  // What the configuration says; a group is written.
  const NominalRates &nominal() const;
  // Writes index and footer and completes the summary. start: of the whole run.
  void finish(std::chrono::steady_clock::time_point start);

private:
  class State;
  std::unique_ptr<State> state;
};

// Warnings about the whole stream, by the sums.
void warn_at_end(Summary &summary);

} // namespace fvv::mux
