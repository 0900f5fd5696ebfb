// capture/drc_header.cpp: the first bytes of a Draco file, by the Draco bitstream specification 2.2
// ("DRACO", version, encoder type and method, flags, metadata, then the counts of the connectivity).
#include "capture/drc_header.h"

extern "C" {
#include "base/bytes.h"
}

#include <cinttypes>
#include <cstdio>

namespace fvv::capture {

namespace {

class HeaderReader {
public:
  HeaderReader(std::string_view bytes, const std::string &file)
      : cursor{reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size(), 0, 0}, name(file) {}

  DrcCounts read() {
    const uint8_t *head = fvv_cursor_take(&cursor, 11);
    if (!head || memcmp(head, "DRACO", 5)) fail(0, "expected a Draco file, which begins with DRACO");
    if (head[5] != 2 || head[6] != 2)
      fail(5,
           "expected Draco bitstream 2.2, found " + std::to_string(head[5]) + "." + std::to_string(head[6]));
    if (head[7] != 1)
      fail(7, head[7] ? "expected a triangular mesh, found another geometry"
                      : "expected a triangular mesh, found a point cloud");
    if (head[8] > 1) fail(8, "expected encoding method 0 or 1, found " + std::to_string(head[8]));
    const bool edgebreaker = head[8] == 1;
    constexpr uint16_t has_metadata = 0x8000;
    if (fvv_get_u16(head + 9) & has_metadata) skip_metadata();
    if (edgebreaker) take(1); // which traversal
    const uint64_t first = number(), second = number();
    return edgebreaker ? DrcCounts{second, first} : DrcCounts{first, second};
  }

private:
  [[noreturn]] void fail(size_t offset, const std::string &what) const {
    char text[32];
    snprintf(text, sizeof text, ": 0x%zx: ", offset);
    throw FileError(name + text + what);
  }
  void check() const {
    if (cursor.failed) fail(cursor.position, "the file ends within the Draco header");
  }
  void take(uint64_t size) {
    fvv_cursor_take(&cursor, size > SIZE_MAX ? SIZE_MAX : static_cast<size_t>(size));
    check();
  }
  uint64_t number() {
    const uint64_t value = fvv_cursor_uleb(&cursor);
    check();
    return value;
  }
  void skip_name() {
    const uint8_t *size = fvv_cursor_take(&cursor, 1);
    check();
    take(*size);
  }
  // Metadata nests: entries, then children, each a name and metadata of its own. In this order a count of the
  // children still to come does instead of recursion.
  void skip_metadata() {
    for (uint64_t attributes = number(), i = 0; i <= attributes; i++) {
      if (i < attributes) number(); // of which attribute; the last one is of the whole mesh
      for (uint64_t pending = 1, visited = 0; pending; pending--, visited++) {
        if (visited) skip_name();
        for (uint64_t entries = number(); entries; entries--) {
          skip_name();
          take(number());
        }
        const uint64_t children = number();
        if (children > cursor.size) fail(cursor.position, "the file ends within the Draco header");
        pending += children;
      }
    }
  }

  fvv_cursor cursor;
  const std::string &name;
};

} // namespace

DrcCounts parse_drc_header(std::string_view bytes, const std::string &name) {
  return HeaderReader(bytes, name).read();
}

} // namespace fvv::capture
