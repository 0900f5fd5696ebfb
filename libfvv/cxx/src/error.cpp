#include "fvv_cxx/error.h"

namespace fvv {

void fail(const std::string &name, const fvv_diagnostic &diagnostic) {
  char line[1024];
  fvv_diagnostic_format(&diagnostic, name.c_str(), line, sizeof line);
  throw Error(line);
}

void check(fvv_status status, const std::string &name, const fvv_diagnostic &diagnostic) {
  if (status >= 0) return;
  if (diagnostic.status < 0) fail(name, diagnostic);
  throw Error(name + ": " + fvv_status_text(status));
}

} // namespace fvv
