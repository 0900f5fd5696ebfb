// Answers to the questions of conformance/PROTOCOL.md on one frame.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace fvv::conformance {

// The operations that are offered.
std::vector<std::string> questions();
// request: its op is one of them. Throws std::runtime_error if the stream lacks what it asks for.
nlohmann::json answer_question(const std::vector<uint8_t> &bytes, const nlohmann::json &request);

} // namespace fvv::conformance
