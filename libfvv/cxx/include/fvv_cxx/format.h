// Text by a pattern of printf, of any length. C++17 has no std::format.
#pragma once

#include <cstdarg>
#include <string>

namespace fvv {

__attribute__((format(printf, 1, 2))) std::string format(const char *pattern, ...);
__attribute__((format(printf, 1, 0))) std::string format_list(const char *pattern, va_list arguments);

} // namespace fvv
