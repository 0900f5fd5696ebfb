// Opening files to read, and why one cannot be read.
#pragma once

#include "fvv_cxx/error.h"

#include <filesystem>
#include <sys/stat.h>

namespace fvv {

// "a folder", "a pipe", "a socket", "a block device", "a character device", "a file".
const char *file_kind(mode_t mode);

inline constexpr char missing_file[] = "is missing";

// missing_file, "is a folder", "is a pipe", "permission denied", ...; "" for a regular file that can be
// opened.
std::string why_unreadable(const std::string &path);

// Where a path leads, whether or not there is anything: a symbolic link is as good as "..". Empty if that
// cannot be found out.
std::filesystem::path resolved(const std::filesystem::path &path);

// Whether what path leads to is in a folder or deeper. "": the working folder.
bool is_below(const std::filesystem::path &folder, const std::filesystem::path &path);

// A descriptor of a regular file, to read. Throws Error that says what the path is if it is anything else; a
// pipe never blocks it.
int open_to_read(const std::string &path);

// A regular file opened for reading at any offset, or bytes that the caller reads.
class InputFile {
public:
  explicit InputFile(const std::string &path);
  // shown: what path() and messages call the file.
  InputFile(const std::string &path, const std::string &shown);
  // source is valid as long as this object.
  InputFile(const fvv_input &source, const std::string &shown);
  ~InputFile();
  InputFile(const InputFile &) = delete;
  InputFile &operator=(const InputFile &) = delete;
  fvv_input input() const; // valid as long as this object; a file is read with pread
  uint64_t size() const { return length; }
  const std::string &path() const { return name; }

private:
  std::string name;
  int descriptor; // -1: callers is read
  fvv_input callers = {};
  uint64_t length;
};

} // namespace fvv
