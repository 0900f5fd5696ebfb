// A folder for the files of one input, in memory where there is such a place; removed with the object.
#pragma once

#include "../fuzz.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <unistd.h>

namespace fuzz {

class Scratch {
public:
  Scratch() {
    namespace fs = std::filesystem;
    const fs::path shared = "/dev/shm";
    const bool is_there = access(shared.c_str(), W_OK) == 0;
    folder = (is_there ? shared : fs::temp_directory_path()) / ("fvv-fuzz-" + std::to_string(getpid()));
    fs::remove_all(folder); // of a process that had this number and crashed
    fs::create_directory(folder);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
  }
  Scratch(const Scratch &) = delete;
  Scratch &operator=(const Scratch &) = delete;

  std::string path(const std::string &name) const { return folder / name; }
  std::string write(const std::string &name, const void *data, size_t size) const {
    std::ofstream file(folder / name, std::ios::binary);
    file.write(static_cast<const char *>(data), std::streamsize(size));
    expect(bool(file.flush()), "there is room for files");
    return path(name);
  }
  std::string read(const std::string &name) const {
    std::ifstream file(folder / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

private:
  std::filesystem::path folder;
};

} // namespace fuzz
