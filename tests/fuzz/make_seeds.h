// Where seeds are written: a folder for each target.
#pragma once

#include "fuzz.h"

#include <filesystem>
#include <fstream>
#include <string>

namespace fuzz {

struct Folder {
  std::filesystem::path path;

  void write(const char *target, const std::string &name, const Bytes &bytes) const {
    std::filesystem::create_directories(path / target);
    std::ofstream file(path / target / name, std::ios::binary);
    file.write(reinterpret_cast<const char *>(bytes.data()), std::streamsize(bytes.size()));
    expect(file.good(), "seeds can be written");
  }
};

void write_worst_streams(const Folder &folder);

} // namespace fuzz
