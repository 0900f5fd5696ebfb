#include "fvv_cxx/format.h"

#include <cstdio>

namespace fvv {

std::string format(const char *pattern, ...) {
  va_list arguments;
  va_start(arguments, pattern);
  std::string out = format_list(pattern, arguments);
  va_end(arguments);
  return out;
}

std::string format_list(const char *pattern, va_list arguments) {
  va_list again;
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, pattern, again);
  va_end(again);
  // Room for the terminator, which is then dropped.
  std::string out(size_t(length) + 1, 0);
  std::vsnprintf(out.data(), out.size(), pattern, arguments);
  out.pop_back();
  return out;
}

} // namespace fvv
