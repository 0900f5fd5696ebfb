// capture/file.h: whole files in and out, and the one exception that everything in this folder throws.
// Knows nothing of what the bytes mean.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace fvv::capture {

// A file that cannot be used. what() is the whole line that the user reads: "path:LINE: what" for text,
// "path: 0xOFFSET: what" for binary, "path: what" where no place can be named.
class FileError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

// All bytes of a regular file. FileError when it cannot be read or holds more than limit bytes; the size is
// looked at before anything is allocated.
std::string read_file(const std::string &path, uint64_t limit);

// Replaces path. FileError with the system's reason.
void write_file(const std::string &path, std::string_view bytes);

} // namespace fvv::capture
