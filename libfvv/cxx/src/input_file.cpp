#include "fvv_cxx/input_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace fvv {

namespace {

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

const char *file_kind(mode_t mode) {
  return S_ISDIR(mode)    ? "a folder"
         : S_ISFIFO(mode) ? "a pipe"
         : S_ISSOCK(mode) ? "a socket"
         : S_ISBLK(mode)  ? "a block device"
         : S_ISCHR(mode)  ? "a character device"
                          : "a file";
}

std::filesystem::path resolved(const std::filesystem::path &path) {
  std::error_code error;
  // absolute, because a missing file would stay relative.
  const std::filesystem::path whole = std::filesystem::absolute(path.empty() ? "." : path, error);
  const std::filesystem::path out = error ? whole : std::filesystem::weakly_canonical(whole, error);
  return error ? std::filesystem::path() : out;
}

bool is_below(const std::filesystem::path &folder, const std::filesystem::path &path) {
  const std::filesystem::path within = resolved(folder), found = resolved(path);
  return !within.empty() &&
         std::mismatch(within.begin(), within.end(), found.begin(), found.end()).first == within.end();
}

std::string why_unreadable(const std::string &path) {
  struct stat status;
  if (stat(path.c_str(), &status) == 0) {
    if (!S_ISREG(status.st_mode)) return std::string("is ") + file_kind(status.st_mode);
    if (access(path.c_str(), R_OK) == 0) return "";
  }
  if (errno == ENOENT || errno == ENOTDIR) return missing_file;
  return errno == EACCES ? "permission denied" : std::strerror(errno);
}

int open_to_read(const std::string &path) {
  // Without O_NONBLOCK a pipe would wait for a writer.
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  struct stat status;
  if (descriptor < 0 || fstat(descriptor, &status) != 0)
    throw Error(path + ": cannot be opened: " + std::strerror(errno));
  if (S_ISREG(status.st_mode)) return descriptor;
  close(descriptor);
  throw Error(path + ": is " + file_kind(status.st_mode) + ", expected a file");
}

InputFile::InputFile(const std::string &path) : InputFile(path, path) {}

InputFile::InputFile(const std::string &path, const std::string &shown)
    : name(shown), descriptor(open_to_read(path)), length(0) {
  struct stat status;
  if (fstat(descriptor, &status) == 0) length = static_cast<uint64_t>(status.st_size);
}

InputFile::InputFile(const fvv_input &source, const std::string &shown)
    : name(shown), descriptor(-1), callers(source), length(source.size) {}

InputFile::~InputFile() {
  if (descriptor >= 0) close(descriptor);
}

fvv_input InputFile::input() const {
  return descriptor < 0 ? callers : fvv_input{read_at, const_cast<int *>(&descriptor), length};
}

} // namespace fvv
