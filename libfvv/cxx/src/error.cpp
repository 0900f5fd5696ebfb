#include "fvv_cxx/stream_error.h"

namespace fvv {

std::string line_of(const std::exception &error) {
  const auto *ours = dynamic_cast<const Error *>(&error);
  return ours ? ours->line() : error.what();
}

void fail(const std::string &name, const fvv_diagnostic &diagnostic) {
  char line[1024];
  fvv_diagnostic_format(&diagnostic, name.c_str(), line, sizeof line);
  throw StreamError(line, diagnostic);
}

void check(fvv_status status, const std::string &name, const fvv_diagnostic &diagnostic) {
  if (status >= 0) return;
  if (diagnostic.status < 0) fail(name, diagnostic);
  fvv_diagnostic without = {};
  without.status = status;
  throw StreamError(name + ": " + fvv_status_text(status), without);
}

} // namespace fvv
