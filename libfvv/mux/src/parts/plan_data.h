// A plan as bytes: all that was decided by looking at files of the capture, and nothing that follows from
// capture.json and the options.
#pragma once

#include "mux/src/choose/decisions.h"
#include "mux/src/plan.h"

#include <string>
#include <string_view>
#include <vector>

namespace fvv::mux {

struct PlanData {
  Plan plan;                         // of a capture on disk
  Decisions decisions;               // by the first group
  std::string capture;               // the bytes of capture.json
  std::vector<std::string> warnings; // of planning
  uint32_t checksum = 0;             // of the saved plan; of one that was loaded
};

// The same bytes for the same data.
std::string save_plan(PlanData data);

// name: of the file, for messages. capture: the path of capture.json; empty: the same as when the plan was
// made. Reads no file. The plan is without an observer and without Plan::videos. Throws Error for bytes that
// are damaged or of another version of this library.
PlanData load_plan(std::string_view bytes, const std::string &name, const std::string &capture);

} // namespace fvv::mux
