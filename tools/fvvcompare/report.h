// The results as text, JSON and CSV.
#pragma once

#include "fvvcompare/command.h"

#include <string>

namespace fvv::compare {

// One screen.
std::string text(const Command &options, const Result &result);
std::string json(const Command &options, const Result &result);
// A line of names, then one for each frame.
std::string csv(const Result &result);

} // namespace fvv::compare
