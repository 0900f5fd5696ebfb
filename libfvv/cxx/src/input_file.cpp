#include "fvv_cxx/input_file.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace fvv {

namespace {

std::string reason() {
  return std::strerror(errno);
}

std::string kind_of(mode_t mode) {
  if (S_ISREG(mode)) return "";
  if (S_ISDIR(mode)) return "is a folder";
  if (S_ISFIFO(mode)) return "is a pipe";
  return S_ISSOCK(mode) ? "is a socket" : "is a device";
}

int open_to_read(const std::string &path) {
  // A pipe that nobody writes to must not block; for regular files O_NONBLOCK changes nothing.
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) throw Error(path + ": cannot open: " + reason());
  return descriptor;
}

fvv_status read_at(void *user, uint64_t offset, void *out, size_t size) {
  auto *bytes = static_cast<uint8_t *>(out);
  while (size) {
    const ssize_t n = pread(*static_cast<const int *>(user), bytes, size, static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return FVV_ERROR_IO;
    bytes += n, offset += static_cast<uint64_t>(n), size -= static_cast<size_t>(n);
  }
  return FVV_OK;
}

} // namespace

std::string why_unreadable(const std::string &path) {
  struct stat status;
  if (stat(path.c_str(), &status) == 0) {
    const std::string kind = kind_of(status.st_mode);
    if (!kind.empty() || access(path.c_str(), R_OK) == 0) return kind;
  }
  if (errno == ENOENT || errno == ENOTDIR) return missing_file;
  return errno == EACCES ? "permission denied" : reason();
}

InputFile::InputFile(const std::string &path) : name(path), descriptor(open_to_read(path)), length(0) {
  struct stat status;
  const bool known = fstat(descriptor, &status) == 0;
  if (known && S_ISREG(status.st_mode)) {
    length = static_cast<uint64_t>(status.st_size);
    return;
  }
  const std::string why = known ? kind_of(status.st_mode) + ", expected a file" : "cannot read: " + reason();
  close(descriptor);
  throw Error(path + ": " + why);
}

InputFile::~InputFile() {
  close(descriptor);
}

fvv_input InputFile::input() const {
  return {read_at, const_cast<int *>(&descriptor), length};
}

} // namespace fvv
