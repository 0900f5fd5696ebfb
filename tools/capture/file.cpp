// capture/file.cpp: whole files in and out.
#include "capture/file.h"

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

namespace fvv::capture {

namespace {

struct Close {
  void operator()(std::FILE *file) const { std::fclose(file); }
};

[[noreturn]] void fail(const std::string &path, const char *what, int number) {
  throw FileError(path + ": " + what + ": " + std::generic_category().message(number));
}

} // namespace

std::string read_file(const std::string &path, uint64_t limit) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) fail(path, "cannot be opened", error ? error.value() : ENOENT);
  if (!std::filesystem::is_regular_file(status)) throw FileError(path + ": is not a regular file");
  const uint64_t size = std::filesystem::file_size(path, error);
  if (error) fail(path, "cannot be measured", error.value());
  if (size > limit)
    throw FileError(path + ": has " + std::to_string(size) + " bytes, at most " + std::to_string(limit) +
                    " are allowed");
  const std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "rb"));
  if (!file) fail(path, "cannot be opened", errno);
  std::string bytes(static_cast<size_t>(size), '\0');
  const size_t count = std::fread(bytes.data(), 1, bytes.size(), file.get());
  if (std::ferror(file.get())) fail(path, "cannot be read", errno);
  if (count != bytes.size())
    throw FileError(path + ": ended after " + std::to_string(count) + " of " + std::to_string(size) +
                    " bytes while it was read");
  return bytes;
}

void write_file(const std::string &path, std::string_view bytes) {
  std::unique_ptr<std::FILE, Close> file(std::fopen(path.c_str(), "wb"));
  if (!file) fail(path, "cannot be created", errno);
  if (std::fwrite(bytes.data(), 1, bytes.size(), file.get()) != bytes.size())
    fail(path, "cannot be written", errno);
  // Buffered bytes may fail as late as here (disk full), so that the answer of fclose counts.
  if (std::fclose(file.release())) fail(path, "cannot be written", errno);
}

} // namespace fvv::capture
