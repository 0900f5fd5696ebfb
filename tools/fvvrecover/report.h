// What was kept and what is lost, as text and as JSON.
#pragma once

#include "fvv_recover/recover.h"

#include <nlohmann/json.hpp>

#include <string>

namespace fvv::recover {

// output: as the user wrote it; empty: nothing is written.
nlohmann::ordered_json json(const std::string &input, const std::string &output, const Result &result);
std::string text(const std::string &input, const Result &result);
// A line for each loss: "FILE: 0x1a2b: group 3: 10 frames kept, 15 lost: CRC of the payload does not match
// [FVV-1103]".
std::string text(const std::string &input, const Loss &loss);

} // namespace fvv::recover
