// video/: the TILE payload: there and back, every rule broken once, limits, cut and flipped bytes.
#include "exact.h"

#include "fvv/video.h"

#include "fvv_catch.h"

extern "C" {
#include "base/bytes.h"
#include "base/layout.h"
}

namespace {

using bytes = std::vector<uint8_t>;

std::vector<fvv_tile> layout(size_t count) {
  std::vector<fvv_tile> tiles;
  for (size_t i = 0; i < count; i++) {
    fvv_tile t = {};
    t.camera_id = (uint16_t)(100 + i);
    t.source = {(uint16_t)(3 * i), 7, 1920, 1080};
    t.destination = {(uint16_t)(480 * (i % 4)), (uint16_t)(272 * (i / 4)), 480, 270};
    tiles.push_back(t);
  }
  return tiles;
}

bytes encoded(const std::vector<fvv_tile> &tiles) {
  size_t size = 0;
  REQUIRE(fvv_tiles_encode(tiles.data(), tiles.size(), nullptr, 0, &size, nullptr) ==
          FVV_ERROR_BUFFER_TOO_SMALL);
  bytes out(size, 0xa5);
  REQUIRE(fvv_tiles_encode(tiles.data(), tiles.size(), out.data(), size, &size, nullptr) == FVV_OK);
  return out;
}

fvv_status decode(const bytes &payload, size_t size, fvv_diagnostic *d, const fvv_limits *limits = nullptr) {
  const exact block(payload, size);
  fvv_tile tiles[16];
  size_t count = 0;
  return fvv_tiles_decode(tiles, 16, &count, block.data(), size, limits, d);
}

} // namespace

TEST_CASE("a tile layout comes back byte for byte and value for value") {
  for (const size_t count : {1, 2, 7, 16}) {
    const std::vector<fvv_tile> tiles = layout(count);
    const bytes payload = encoded(tiles);
    CHECK(payload.size() == 8 + 24 * count);
    std::vector<fvv_tile> back(count);
    size_t found = 0;
    REQUIRE(fvv_tiles_decode(back.data(), count, &found, payload.data(), payload.size(), nullptr, nullptr) ==
            FVV_OK);
    CHECK(found == count);
    CHECK(memcmp(back.data(), tiles.data(), count * sizeof(fvv_tile)) == 0);
    CHECK(encoded(back) == payload);
  }
  const bytes p = encoded(layout(2));
  CHECK(fvv_get_u32(&p[0]) == 2);
  CHECK(fvv_get_u16(&p[8 + 24]) == 101);
  CHECK(fvv_get_u16(&p[8 + 24 + 4]) == 3);
  CHECK(fvv_get_u16(&p[8 + 24 + 8]) == 1920);
  CHECK(fvv_get_u16(&p[8 + 24 + 12]) == 480);
  CHECK(fvv_get_u16(&p[8 + 24 + 18]) == 270);
}

TEST_CASE("an array that is too small gets what fits and the number there is") {
  const std::vector<fvv_tile> tiles = layout(7);
  const bytes payload = encoded(tiles);
  fvv_tile back[4] = {};
  size_t count = 0;
  CHECK(fvv_tiles_decode(back, 3, &count, payload.data(), payload.size(), nullptr, nullptr) ==
        FVV_ERROR_BUFFER_TOO_SMALL);
  CHECK(count == 7);
  CHECK(memcmp(back, tiles.data(), 3 * sizeof(fvv_tile)) == 0);
  CHECK(back[3].camera_id == 0);
  CHECK(fvv_tiles_decode(nullptr, 0, &count, payload.data(), payload.size(), nullptr, nullptr) ==
        FVV_ERROR_BUFFER_TOO_SMALL);
  CHECK(count == 7);
}

TEST_CASE("every rule of TILE has its number") {
  const size_t second = FVV_TILE_SIZE + FVV_TILE_ENTRY_SIZE;
  const struct {
    const char *what;
    uint32_t issue;
    size_t offset, width;
    uint32_t value;
  } faults[] = {
      {"count 0", FVV_ISSUE_TILE_PAYLOAD, FVV_TILE_COUNT, 4, 0},
      {"one less", FVV_ISSUE_TILE_PAYLOAD, FVV_TILE_COUNT, 4, 2},
      {"one more", FVV_ISSUE_TILE_PAYLOAD, FVV_TILE_COUNT, 4, 4},
      {"24 * count right but for 2^32", FVV_ISSUE_TILE_PAYLOAD, FVV_TILE_COUNT, 4, 0x20000003},
      {"reserved", FVV_ISSUE_TILE_PAYLOAD, FVV_TILE_RESERVED, 2, 0x100},
      {"flags", FVV_ISSUE_TILE_PAYLOAD, second + FVV_TILE_ENTRY_FLAGS, 2, 1},
      {"reserved of an entry", FVV_ISSUE_TILE_PAYLOAD, second + FVV_TILE_ENTRY_RESERVED, 4, 1u << 31},
      {"empty source", FVV_ISSUE_TILE_RECT, second + FVV_TILE_ENTRY_SOURCE + 4, 2, 0},
      {"flat source", FVV_ISSUE_TILE_RECT, second + FVV_TILE_ENTRY_SOURCE + 6, 2, 0},
      {"empty destination", FVV_ISSUE_TILE_RECT, second + FVV_TILE_ENTRY_DESTINATION + 4, 2, 0},
      {"flat destination", FVV_ISSUE_TILE_RECT, second + FVV_TILE_ENTRY_DESTINATION + 6, 2, 0},
      {"x not aligned", FVV_ISSUE_TILE_RECT, second + FVV_TILE_ENTRY_DESTINATION, 2, 488},
      {"y not aligned", FVV_ISSUE_TILE_RECT, second + FVV_TILE_ENTRY_DESTINATION + 2, 2, 1},
      {"overlap", FVV_ISSUE_TILE_OVERLAP, second + FVV_TILE_ENTRY_DESTINATION, 2, 464},
      {"camera twice", FVV_ISSUE_TILE_OVERLAP, second + FVV_TILE_ENTRY_CAMERA, 2, 100},
  };
  const bytes good = encoded(layout(3));
  for (const auto &f : faults) {
    CAPTURE(f.what);
    bytes bad = good;
    if (f.width == 2) fvv_put_u16(&bad[f.offset], (uint16_t)f.value);
    if (f.width == 4) fvv_put_u32(&bad[f.offset], f.value);
    fvv_diagnostic d;
    CHECK(decode(bad, bad.size(), &d) == FVV_ERROR_INVALID);
    CHECK(d.issue == f.issue);
    CHECK(d.chunk_type == FVV_CHUNK_TILES);
    CHECK(d.offset <= bad.size());
  }
  std::vector<fvv_tile> tiles = layout(3);
  tiles[2].destination.x = 5;
  uint8_t out[200];
  size_t size;
  fvv_diagnostic d;
  CHECK(fvv_tiles_encode(tiles.data(), 3, out, sizeof out, &size, &d) == FVV_ERROR_INPUT);
  CHECK(d.issue == FVV_ISSUE_TILE_RECT);
  CHECK(fvv_tiles_encode(tiles.data(), 0, out, sizeof out, &size, &d) == FVV_ERROR_INPUT);
  CHECK(d.issue == FVV_ISSUE_TILE_PAYLOAD);
}

TEST_CASE("more tiles than cameras are allowed are refused before they are looked at") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_cameras = 3;
  fvv_diagnostic d;
  bytes payload = encoded(layout(4));
  fvv_put_u16(&payload[FVV_TILE_SIZE + FVV_TILE_ENTRY_FLAGS], 1); // would be another fault
  CHECK(decode(payload, payload.size(), &d, &limits) == FVV_ERROR_LIMIT);
  CHECK(d.issue == FVV_ISSUE_LIMIT);
  payload = encoded(layout(3));
  CHECK(decode(payload, payload.size(), &d, &limits) == FVV_OK);
}

TEST_CASE("no prefix of a tile layout decodes, and any byte of it may be anything") {
  const bytes payload = encoded(layout(7));
  fvv_diagnostic d;
  for (size_t size = 0; size < payload.size(); size++) {
    REQUIRE(decode(payload, size, &d) == FVV_ERROR_INVALID);
    REQUIRE(d.issue == FVV_ISSUE_TILE_PAYLOAD);
  }
  int accepted = 0, refused = 0;
  for (size_t i = 0; i < payload.size(); i++)
    for (int value = 0; value < 256; value++) {
      bytes q = payload;
      q[i] = (uint8_t)value;
      const fvv_status status = decode(q, q.size(), &d);
      REQUIRE((status == FVV_OK || (status == FVV_ERROR_INVALID && d.issue != 0)));
      (status == FVV_OK ? accepted : refused)++;
    }
  CHECK(accepted > 1000);
  CHECK(refused > 1000);
}
