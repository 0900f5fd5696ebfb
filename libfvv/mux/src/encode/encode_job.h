// Encodes the groups of a plan on several threads and writes them in order.
#pragma once

#include "fvv_mux/report.h"
#include "mux/src/choose/decisions.h"
#include "mux/src/plan.h"
#include "mux/src/sums.h"

#include <chrono>
#include <memory>

namespace fvv::mux {

// Every function throws Error, and exceptions of the sink; then sink received an incomplete stream.
class EncodeJob {
public:
  // plan and sink are borrowed. The first group decides what is open in the plan.
  EncodeJob(const Plan &plan, const Sink &sink);
  // For one group of a stream whose first group another job wrote. Writes file header and configuration.
  // decisions: of that job.
  EncodeJob(const Plan &plan, const Sink &sink, const Decisions &decisions, size_t group);
  ~EncodeJob();

  // All groups of the plan.
  void run();
  // One group, the next one.
  void run_group(size_t group);
  // A group is written.
  const Decisions &decisions() const;
  // Of the groups that are written.
  const StreamSums &sums() const;
  // Writes index and footer. start: of the whole run.
  Report finish(std::chrono::steady_clock::time_point start);

private:
  class State;
  std::unique_ptr<State> state;
};

// Warnings about the whole stream. Returns whether there were any.
bool warn_at_end(const Plan &plan, const Report &report);

} // namespace fvv::mux
