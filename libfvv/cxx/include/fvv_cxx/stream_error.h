// Failures of libfvv that keep their diagnostic, for callers that report more than the line.
#pragma once

#include "fvv_cxx/error.h"

namespace fvv {

// What fail() and check() throw.
class StreamError : public Error {
public:
  StreamError(const std::string &line, const fvv_diagnostic &the_diagnostic)
      : Error(line), diagnostic(the_diagnostic) {}

  const fvv_diagnostic diagnostic; // with the status; without a message where libfvv gave none
};

} // namespace fvv
