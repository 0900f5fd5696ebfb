// OpenEXR files that are cut, flipped, or announce what they do not hold.
#include "exr_files.h"

#include <cstring>

using namespace fvv::media;

namespace {

std::vector<uint8_t> bytes_of(const std::string &name) {
  std::ifstream file(name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<ExrKind> kinds() {
  using namespace OPENEXR_IMF_NAMESPACE;
  std::vector<ExrKind> all;
  for (const Compression compression :
       {NO_COMPRESSION, RLE_COMPRESSION, ZIPS_COMPRESSION, ZIP_COMPRESSION, PIZ_COMPRESSION,
        PXR24_COMPRESSION, B44_COMPRESSION, B44A_COMPRESSION})
    for (const int tile : {0, 16}) {
      ExrKind kind;
      kind.compression = compression;
      kind.tile = tile;
      kind.type = tile ? FLOAT : HALF;
      if (tile) kind.channels = {"A", "B", "G", "R", "Z"};
      all.push_back(kind);
    }
  return all;
}

// Where the value of an attribute begins: name, type and size precede it.
size_t value_of(const std::vector<uint8_t> &file, const std::string &name, const std::string &type) {
  const std::string key = name + '\0' + type + '\0';
  const auto found = std::search(file.begin(), file.end(), key.begin(), key.end());
  REQUIRE(found != file.end());
  return size_t(found - file.begin()) + key.size() + 4;
}

void put(std::vector<uint8_t> &file, size_t at, uint32_t value) {
  for (size_t i = 0; i < 4; i++) file[at + i] = uint8_t(value >> (8 * i));
}

} // namespace

TEST_CASE("every cut of an OpenEXR file is an error that names the file") {
  for (const ExrKind &kind : kinds()) {
    CAPTURE(int(kind.compression), kind.tile);
    std::vector<uint8_t> file = bytes_of(write_exr("whole.exr", kind));
    // Tiles of coarser levels follow the finest one, and are not read.
    const size_t needed = kind.tile ? file.size() * 2 / 3 : file.size();
    for (size_t size = 0; size < needed; size += size < 420 || size + 20 > needed ? 1 : 13) {
      CAPTURE(size, file.size());
      // A block of exactly that size, so that a sanitizer detects any read beyond it.
      const std::vector<uint8_t> cut(file.begin(), file.begin() + std::ptrdiff_t(size));
      CHECK_THAT(error_of([&] { decode_image(cut.data(), cut.size(), 3, "cut.exr"); }),
                 Contains("cut.exr: "));
    }
  }
}

TEST_CASE("flipped bits in OpenEXR files give errors or pictures") {
  uint32_t state = 12;
  for (const ExrKind &kind : kinds()) {
    CAPTURE(int(kind.compression), kind.tile);
    const std::vector<uint8_t> file = bytes_of(write_exr("whole.exr", kind));
    int errors = 0;
    for (int round = 0; round < 600; round++) {
      std::vector<uint8_t> bad = file;
      // Every other round within the header and the table of blocks, which are the dangerous part.
      const size_t range = round % 2 ? std::min<size_t>(bad.size(), 500) : bad.size();
      for (uint32_t flips = 1 + next_random(state) % 4; flips > 0; flips--)
        bad[next_random(state) % range] ^= uint8_t(1u << next_random(state) % 8);
      const std::string error = error_of([&] {
        const Image decoded = decode_image(bad.data(), bad.size(), 3, "flipped");
        REQUIRE(decoded.pixels.size() == size_t(decoded.width) * decoded.height * 3);
      });
      errors += !error.empty();
    }
    CHECK(errors > 60);
  }
}

TEST_CASE(
    "an OpenEXR file that is too large, or lies about its size, is refused before anything is allocated") {
  const std::vector<uint8_t> file = bytes_of(write_exr("whole.exr", {}));
  const auto with_windows = [&](uint32_t right, uint32_t bottom) {
    std::vector<uint8_t> bad = file;
    for (const char *name : {"dataWindow", "displayWindow"}) {
      put(bad, value_of(bad, name, "box2i") + 8, right);
      put(bad, value_of(bad, name, "box2i") + 12, bottom);
    }
    return error_of([&] { decode_image(bad.data(), bad.size(), 3, "big"); });
  };
  CHECK(with_windows(exr_width - 1, exr_height - 1).empty());
  CHECK_THAT(with_windows(16384, 9), Contains("big: is 16385 x 10 pixels, expected 1 to 16384"));
  CHECK_THAT(with_windows(16383, 16383), Contains("cannot hold"));
  CHECK_FALSE(with_windows(0x7fffffff, 0x7fffffff).empty());
  CHECK_FALSE(with_windows(0x80000000, 3).empty());
  CHECK_FALSE(with_windows(3, uint32_t(-2)).empty());

  std::vector<uint8_t> incomplete = file; // a renderer was stopped before it wrote the table of blocks
  const size_t table = value_of(file, "screenWindowWidth", "float") + 4;
  REQUIRE(incomplete[table] == 0);
  for (size_t i = 0; i < 3 * 8; i++) incomplete[table + 1 + i] = 0;
  CHECK(decode_image(incomplete.data(), incomplete.size(), 3, "stopped").pixels ==
        decode_image(file.data(), file.size(), 3, "whole").pixels);
  CHECK_THAT(error_of([&] { decode_image(incomplete.data(), incomplete.size() - 90, 3, "stopped"); }),
             Contains("stopped: the OpenEXR file is cut or damaged"));
  CHECK_THAT(error_of([&] { decode_image(file.data(), 4, 3, "magic"); }), Contains("magic: "));
  CHECK_THAT(error_of([&] { decode_exr(file.data() + 1, 40, "other"); }),
             Contains("other: is no OpenEXR file"));
}
