// Bytes in memory and files as fvv_input.
#include "fvv_catch.h"

#include "fvv/types.h"

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

namespace {

const std::string content = "what a stream would be";

std::string path_of(const char *name) {
  return (std::filesystem::temp_directory_path() / name).string();
}

std::string read(const fvv_input &input, uint64_t offset, size_t size) {
  std::string out(size, '?');
  CHECK(input.read_at(input.user, offset, out.data(), size) == FVV_OK);
  return out;
}

} // namespace

TEST_CASE("a block of memory is an input") {
  const fvv_input input = fvv_input_memory(content.data(), content.size());
  REQUIRE(input.size == content.size());
  CHECK(read(input, 0, content.size()) == content);
  CHECK(read(input, 7, 6) == "stream");
  CHECK(read(input, content.size(), 0).empty());
  CHECK(fvv_input_memory(nullptr, 0).size == 0);
}

TEST_CASE("a file is an input until it is closed") {
  const std::string path = path_of("fvv_input_test.bin");
  std::FILE *file = std::fopen(path.c_str(), "wb");
  REQUIRE(file);
  REQUIRE(std::fwrite(content.data(), 1, content.size(), file) == content.size());
  REQUIRE(std::fclose(file) == 0);
  fvv_input input;
  fvv_diagnostic diagnostic;
  REQUIRE(fvv_input_file_open(path.c_str(), &input, &diagnostic) == FVV_OK);
  CHECK(input.size == content.size());
  CHECK(read(input, 7, 6) == "stream");
  CHECK(read(input, 0, content.size()) == content);
  char more[2];
  CHECK(input.read_at(input.user, content.size() - 1, more, 2) == FVV_ERROR_IO);
  CHECK(read(input, 0, 4) == "what");
  fvv_input_file_close(&input);
  CHECK(!input.user);
  fvv_input_file_close(&input);
  std::remove(path.c_str());
}

TEST_CASE("what is no readable file is refused with a reason") {
  fvv_input input;
  fvv_diagnostic diagnostic;
  CHECK(fvv_input_file_open(path_of("fvv_no_such_file").c_str(), &input, &diagnostic) == FVV_ERROR_IO);
  CHECK(std::string(diagnostic.message).find("cannot be opened: ") == 0);
  CHECK(!input.read_at);
  const std::string folder = std::filesystem::temp_directory_path().string();
  CHECK(fvv_input_file_open(folder.c_str(), &input, &diagnostic) == FVV_ERROR_IO);
  CHECK(!input.user);
  CHECK(fvv_input_file_open(nullptr, &input, &diagnostic) == FVV_ERROR_ARGUMENT);
  CHECK(!input.user);
  CHECK(input.size == 0);
}
