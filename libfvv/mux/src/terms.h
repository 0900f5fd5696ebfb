// Lengths and areas of a capture for people.
#pragma once

#include "fvv_cxx/format.h"
#include "mux/src/plan.h"

#include <string>

namespace fvv::mux {

inline std::string length_text(bool scale_unknown, double length) {
  return scale_unknown ? fvv::format("%.3g units", length) : fvv::format("%.3g mm", length * 1000);
}

inline std::string length_text(const Plan &plan, double length) {
  return length_text(plan.capture.scale_unknown, length);
}

inline std::string area_text(const Plan &plan, double area) {
  return plan.capture.scale_unknown ? fvv::format("%.3g square units", area)
                                    : fvv::format("%.3g cm2", area * 1e4);
}

} // namespace fvv::mux
