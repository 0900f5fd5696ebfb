// Calibration files on disk, and what their readers say of them: shared by the tests of tools/import.
#pragma once

#include "fvv_catch.h"

#include "fvv_scene/import.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <unistd.h>

class ImportFolder {
public:
  ImportFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "fvvimport-XXXXXX").string();
    REQUIRE(mkdtemp(name.data()));
    root = name;
  }
  ~ImportFolder() { std::filesystem::remove_all(root); }
  ImportFolder(const ImportFolder &) = delete;
  std::string path(const std::string &leaf = "") const { return leaf.empty() ? root : root + "/" + leaf; }
  std::string write(const std::string &leaf, const std::string &text) const {
    std::ofstream(path(leaf), std::ios::binary) << text;
    return path(leaf);
  }

private:
  std::string root;
};

// text with the first occurrence of one part replaced; the part must be there.
inline std::string with(std::string text, const std::string &part, const std::string &other) {
  const size_t at = text.find(part);
  REQUIRE(at != std::string::npos);
  return text.replace(at, part.size(), other);
}

// What a reader throws; empty when it does not.
inline std::string message_of(const std::function<void()> &read) {
  try {
    read();
  } catch (const fvv::Error &error) {
    return error.what();
  }
  return "";
}

// A change to a valid file, and the message after its path.
struct Fault {
  std::string part, other, message;
};
