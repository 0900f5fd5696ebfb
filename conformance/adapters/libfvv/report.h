// The report of conformance/PROTOCOL.md on one stream.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <vector>

namespace fvv::conformance {

// Which frames are intact is what fvv_checker says, and what they hold is read through fvv_stream. live: the
// checker gets the bytes in pieces.
nlohmann::json report(const std::vector<uint8_t> &bytes, bool live);
// That of a reader that joined late.
nlohmann::json joined_report(const std::vector<uint8_t> &bytes);

} // namespace fvv::conformance
