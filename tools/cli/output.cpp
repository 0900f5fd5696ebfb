// Writing: a file or folder is whole under its name or absent.
#include "cli/cli.h"
#include "cli/temporary.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <mutex>

namespace fs = std::filesystem;

namespace fvv::cli {

namespace {

constexpr int slots = 16;
constexpr size_t longest = 4096;
char remembered[slots][longest];
std::mutex remembered_lock;

std::string system_reason() {
  return std::strerror(errno);
}

bool exists(const std::string &path) {
  struct stat status;
  return lstat(path.c_str(), &status) == 0;
}

std::string without_slash(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

} // namespace

std::string temporary_name(const std::string &path) {
  static int counter = 0;
  const fs::path whole(path);
  const std::string leaf = "." + whole.filename().string() + "." + std::to_string(getpid()) + "." +
                           std::to_string(counter++) + ".partial";
  return (whole.parent_path() / leaf).string();
}

void remember_temporary(const std::string &path) {
  const std::lock_guard<std::mutex> lock(remembered_lock);
  if (path.size() + 1 > longest) throw Error(path + ": the name is too long");
  for (int i = 0; i < slots; i++)
    if (!remembered[i][0]) {
      // The first character goes in last: a signal sees the whole name or none.
      std::memcpy(remembered[i] + 1, path.c_str() + 1, path.size());
      remembered[i][0] = path[0];
      return;
    }
  throw Error(path + ": too many outputs are open at once");
}

void forget_temporary(const std::string &path) {
  const std::lock_guard<std::mutex> lock(remembered_lock);
  for (auto &slot : remembered)
    if (path == slot) slot[0] = 0;
}

void remove_temporaries_in_handler() {
  for (auto &path : remembered) {
    if (!path[0] || unlink(path) == 0) continue;
    const pid_t child = fork();
    if (child == 0) {
      execl("/bin/rm", "rm", "-rf", "--", path, static_cast<char *>(nullptr));
      _exit(127);
    }
    if (child > 0) waitpid(child, nullptr, 0);
  }
}

OutputFile::OutputFile(const std::string &path, bool force) : name(path), descriptor(-1) {
  if (path == "-") {
    if (isatty(STDOUT_FILENO))
      throw Error("standard output is a terminal: not writing a binary file to it", Error::usage);
    descriptor = STDOUT_FILENO;
    name = "standard output";
    return;
  }
  if (exists(path) && !force) throw Error(path + ": already exists; --force overwrites it");
  if (fs::is_directory(path)) throw Error(path + ": is a folder");
  temporary = temporary_name(path);
  remember_temporary(temporary);
  descriptor = open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    const std::string why = system_reason();
    forget_temporary(temporary);
    throw Error(path + ": cannot create: " + why);
  }
}

OutputFile::~OutputFile() {
  if (temporary.empty()) return;
  if (descriptor >= 0) close(descriptor);
  unlink(temporary.c_str());
  forget_temporary(temporary);
}

fvv_status OutputFile::write_callback(void *user, const void *bytes, size_t size) {
  auto *self = static_cast<OutputFile *>(user);
  const auto *p = static_cast<const uint8_t *>(bytes);
  while (size) {
    const ssize_t n = ::write(self->descriptor, p, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      self->reason = system_reason();
      return FVV_ERROR_IO;
    }
    p += n, size -= static_cast<size_t>(n);
  }
  return FVV_OK;
}

void OutputFile::write(const void *bytes, size_t size) {
  write_callback(this, bytes, size);
  rethrow();
}

fvv_output OutputFile::output() {
  return {write_callback, this};
}

void OutputFile::rethrow() const {
  if (!reason.empty()) throw Error(name + ": cannot write: " + reason);
}

void OutputFile::commit() {
  if (temporary.empty()) return;
  const int closing = descriptor;
  bool good = fsync(closing) == 0 || errno == EINVAL;
  descriptor = -1;
  good = close(closing) == 0 && good;
  if (!good || rename(temporary.c_str(), name.c_str()) != 0)
    throw Error(name + ": cannot write: " + system_reason());
  forget_temporary(temporary);
  temporary.clear();
}

OutputFolder::OutputFolder(const std::string &path, bool force) : name(without_slash(path)), replace(false) {
  if (exists(name)) {
    std::error_code error;
    const bool empty = fs::is_directory(name, error) && fs::is_empty(name, error) && !error;
    if (!empty && !force) throw Error(path + ": already exists; --force replaces it");
    if (!fs::is_directory(name, error)) throw Error(path + ": is not a folder");
    replace = true;
  }
  temporary = temporary_name(name);
  remember_temporary(temporary);
  std::error_code error;
  fs::create_directories(temporary, error);
  if (error) {
    forget_temporary(temporary);
    throw Error(path + ": cannot create: " + error.message());
  }
}

OutputFolder::~OutputFolder() {
  if (temporary.empty()) return;
  std::error_code ignored;
  fs::remove_all(temporary, ignored);
  forget_temporary(temporary);
}

std::string OutputFolder::file(const std::string &relative) const {
  const fs::path part(relative);
  bool outside = part.is_absolute() || relative.empty();
  for (const auto &step : part) outside = outside || step == "..";
  if (outside) throw Error(name + ": '" + relative + "' would lie outside the output folder");
  const fs::path whole = fs::path(temporary) / part;
  std::error_code error;
  fs::create_directories(whole.parent_path(), error);
  if (error) throw Error(whole.parent_path().string() + ": cannot create: " + error.message());
  return whole.string();
}

void OutputFolder::commit() {
  std::error_code error;
  std::string former;
  if (replace) {
    // Moved aside first and removed last: at no moment is there a half folder under the name.
    former = temporary_name(name);
    fs::rename(name, former, error);
  }
  if (!error) fs::rename(temporary, name, error);
  if (error) throw Error(name + ": cannot write: " + error.message());
  forget_temporary(temporary);
  temporary.clear();
  if (!former.empty()) fs::remove_all(former, error);
}

} // namespace fvv::cli
