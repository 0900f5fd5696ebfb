// A regular file opened for reading at any offset, and why a path is none.
#pragma once

#include "fvv_cxx/error.h"

namespace fvv {

inline constexpr char missing_file[] = "is missing";

// Why path cannot be read as a regular file: missing_file, "is a folder", "is a pipe", "is a socket", "is a
// device", "permission denied", or the system's reason. Empty: it can. Never opens it: a pipe would block.
std::string why_unreadable(const std::string &path);

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
