// fvvmux/summary.h: what was chosen and what came out, on one screen or as JSON. Knows nothing of how it came
// about.
#pragma once

#include "fvvmux/mux.h"

#include <nlohmann/json.hpp>

namespace fvv::mux {

std::string summary_text(const Summary &summary);

// The keys are listed in fvvmux --help.
nlohmann::ordered_json summary_json(const Summary &summary);

} // namespace fvv::mux
