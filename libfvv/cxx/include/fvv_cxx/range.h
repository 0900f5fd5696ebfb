// Numbers from one to another, as users of all tools write them.
#pragma once

#include "fvv_cxx/values.h"

#include <optional>
#include <string>
#include <string_view>

namespace fvv {

// "10-19", "10..19", or "10" alone. Nothing for other text.
std::optional<Range> scan_range(std::string_view text);

// The value of the option with that identifier. Throws Error (usage) for other text.
Range parse_range(const std::string &option, const std::string &text);

} // namespace fvv
