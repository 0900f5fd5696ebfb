// A regular file opened for reading at any offset.
#pragma once

#include "fvv_cxx/error.h"

namespace fvv {

// Throws Error with path and reason.
class InputFile {
public:
  explicit InputFile(const std::string &path);
  ~InputFile();
  InputFile(const InputFile &) = delete;
  InputFile &operator=(const InputFile &) = delete;
  fvv_input input() const; // reads with pread; valid as long as this object
  uint64_t size() const { return length; }
  const std::string &path() const { return name; }

private:
  std::string name;
  int descriptor;
  uint64_t length;
};

} // namespace fvv
