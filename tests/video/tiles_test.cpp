// video/: arranging tiles, checking a layout, and the TILE payload: there and back, every rule broken once,
// limits, cut and flipped bytes.
#include "exact.h"
#include "fvv/video.h"
#include "fvv_catch.h"

#include <cstring>
#include <random>
#include <string>
#include <vector>

extern "C" {
#include "base/bytes.h"
#include "base/layout.h"
}

namespace {

using tiles_t = std::vector<fvv_tile>;

fvv_tile tile(int camera, int width, int height) {
  fvv_tile t = {};
  t.camera_id = (uint16_t)camera;
  t.source = {0, 0, (uint16_t)(4 * width), (uint16_t)(4 * height)};
  t.destination = {0, 0, (uint16_t)width, (uint16_t)height};
  return t;
}

tiles_t same(size_t count, int width, int height) {
  tiles_t all;
  for (size_t i = 0; i < count; i++) all.push_back(tile((int)i + 1, width, height));
  return all;
}

struct frame {
  uint32_t width, height;
};

uint32_t up(uint32_t size) {
  return (size + 15) / 16 * 16;
}

// Arranges, and checks what holds for every arrangement by counting cells.
frame arranged(tiles_t &all, uint32_t max = 16384) {
  const tiles_t before = all;
  frame f = {};
  REQUIRE(fvv_tiles_arrange(all.data(), all.size(), max, &f.width, &f.height, nullptr) == FVV_OK);
  REQUIRE((f.width % 16 == 0 && f.height % 16 == 0));
  REQUIRE((f.width > 0 && f.height > 0 && f.width <= max && f.height <= max));
  std::vector<int> cells((size_t)f.width / 16 * (f.height / 16));
  uint32_t right = 0, bottom = 0;
  size_t errors = 0;
  for (size_t i = 0; i < all.size(); i++) {
    const fvv_rect &d = all[i].destination, &b = before[i].destination;
    errors += all[i].camera_id != before[i].camera_id || d.width != b.width || d.height != b.height;
    errors += memcmp(&all[i].source, &before[i].source, sizeof(fvv_rect)) != 0;
    errors += d.x % 16 || d.y % 16 || d.x + up(d.width) > f.width || d.y + up(d.height) > f.height;
    REQUIRE(errors == 0);
    for (uint32_t y = d.y / 16; y < (d.y + up(d.height)) / 16; y++)
      for (uint32_t x = d.x / 16; x < (d.x + up(d.width)) / 16; x++)
        errors += cells[y * (f.width / 16) + x]++ != 0;
    // The order of the input is that of reading.
    if (i) {
      const fvv_rect &p = all[i - 1].destination;
      errors += !(d.y == p.y ? d.x > p.x : d.y > p.y);
    }
    right = std::max(right, d.x + up(d.width));
    bottom = std::max(bottom, d.y + up(d.height));
  }
  REQUIRE(errors == 0);
  REQUIRE((right == f.width && bottom == f.height)); // nothing is wasted at the edges
  REQUIRE(fvv_tiles_validate(all.data(), all.size(), f.width, f.height, nullptr) == FVV_OK);
  return f;
}

} // namespace

TEST_CASE("tiles of one size make a near-square grid of little area") {
  const struct {
    size_t count;
    int width, height;
    uint32_t frame_width, frame_height;
  } known[] = {
      {1, 480, 270, 480, 272},    {2, 480, 270, 480, 544},  {3, 480, 270, 480, 816},
      {4, 480, 270, 960, 544},    {6, 480, 270, 960, 816},  {7, 480, 270, 960, 1088},
      {8, 480, 270, 960, 1088},   {9, 480, 270, 1440, 816}, {16, 512, 512, 2048, 2048},
      {64, 256, 144, 2048, 1152},
  };
  for (const auto &k : known) {
    CAPTURE(k.count);
    tiles_t all = same(k.count, k.width, k.height);
    const frame f = arranged(all);
    CHECK(f.width == k.frame_width);
    CHECK(f.height == k.frame_height);
  }
}

TEST_CASE("arrangements of any count neither overlap nor leave the frame, and are near square") {
  const int sizes[][2] = {{480, 270}, {270, 480}, {16, 16}, {1, 1}, {320, 240}, {333, 77}, {960, 540}};
  for (const auto &size : sizes)
    for (size_t count = 1; count <= 80; count++) {
      CAPTURE(size[0], size[1], count);
      tiles_t all = same(count, size[0], size[1]);
      const frame f = arranged(all);
      const double cell = (double)up((uint32_t)size[0]) * up((uint32_t)size[1]),
                   area = (double)f.width * f.height;
      // No full row is empty, so that the waste is less than a row; and no longer than twice its height where
      // the count allows it.
      REQUIRE(area / cell - (double)count < std::max(f.width / up((uint32_t)size[0]), 1u));
      if (count > 12) REQUIRE(std::max(f.width, f.height) <= 2 * std::min(f.width, f.height));
    }
}

TEST_CASE("where every frame is long, the most nearly square one is taken, not the smallest") {
  tiles_t all = {tile(1, 1600, 16), tile(2, 16, 16), tile(3, 16, 16)};
  const frame f = arranged(all);
  CHECK((f.width == 1600 && f.height == 32)); // 1632 x 16 has half the area
}

TEST_CASE("tiles of different sizes are placed in rows, the same each time") {
  std::mt19937 random(3);
  for (int n = 0; n < 300; n++) {
    CAPTURE(n);
    tiles_t all;
    const size_t count = 1 + random() % 40;
    uint64_t used = 0;
    for (size_t i = 0; i < count; i++) {
      all.push_back(tile((int)(count - i), 1 + (int)(random() % 500), 1 + (int)(random() % 300)));
      used += (uint64_t)up(all[i].destination.width) * up(all[i].destination.height);
    }
    tiles_t again = all;
    const frame f = arranged(all), g = arranged(again);
    REQUIRE((f.width == g.width && f.height == g.height));
    REQUIRE(memcmp(all.data(), again.data(), count * sizeof(fvv_tile)) == 0);
    if (count > 20) REQUIRE((uint64_t)f.width * f.height < 3 * used);
  }
}

TEST_CASE("a frame is no larger than the limit, and a tile that does not fit is named") {
  tiles_t all = same(7, 480, 270);
  frame f = arranged(all, 1088);
  CHECK(f.height == 1088);
  all = same(6, 480, 270);
  f = arranged(all, 1087);
  CHECK((f.width == 960 && f.height == 816));

  // 1087 holds 1072 as a multiple of 16: two columns of three, and a seventh tile too many.
  const auto refused = [](tiles_t tiles, uint32_t max) {
    const tiles_t before = tiles;
    fvv_diagnostic d;
    uint32_t width, height;
    REQUIRE(fvv_tiles_arrange(tiles.data(), tiles.size(), max, &width, &height, &d) == FVV_ERROR_INPUT);
    for (size_t i = 0; i < tiles.size(); i++) REQUIRE(memcmp(&tiles[i], &before[i], sizeof(fvv_tile)) == 0);
    return d;
  };
  CHECK(std::string(refused(same(7, 480, 270), 1087).message) ==
        "7 tiles of together 913920 pixels do not fit a frame of 1072 x 1072 in rows: make them smaller");
  CHECK(std::string(refused({tile(1, 16, 16), tile(9, 100, 300)}, 256).message) ==
        "the tile of camera 9 takes 112 x 304 pixels, a frame can have at most 256 a side");
  CHECK(refused(same(1, 16, 16), 0).status == FVV_ERROR_INPUT);
  CHECK(refused(same(1, 65535, 16), UINT32_MAX).status == FVV_ERROR_INPUT);
  // More pixels than any frame has are refused before rows are tried.
  CHECK(refused(same(60000, 4000, 4000), 65535).status == FVV_ERROR_INPUT);

  CHECK(refused({}, 4096).issue == FVV_ISSUE_TILE_PAYLOAD);
  CHECK(refused({tile(1, 0, 16)}, 4096).issue == FVV_ISSUE_TILE_RECT);
  CHECK(refused({tile(1, 16, 16), tile(1, 16, 16)}, 4096).issue == FVV_ISSUE_TILE_OVERLAP);
}

TEST_CASE("a layout's faults have their numbers") {
  tiles_t good = same(4, 480, 270);
  const frame f = arranged(good);
  const auto verdict = [&](const tiles_t &all, uint32_t width, uint32_t height) {
    fvv_diagnostic d;
    const fvv_status status = fvv_tiles_validate(all.data(), all.size(), width, height, &d);
    if (status != FVV_OK) REQUIRE((status == FVV_ERROR_INVALID && d.chunk_type == FVV_CHUNK_TILES));
    return d.issue;
  };
  CHECK(verdict(good, f.width, f.height) == 0);
  CHECK(verdict(good, f.width, f.height - 3) == FVV_ISSUE_TILE_RECT);
  CHECK(verdict(good, f.width - 1, f.height) == FVV_ISSUE_TILE_RECT);
  CHECK(verdict({}, f.width, f.height) == FVV_ISSUE_TILE_PAYLOAD);
  tiles_t bad = good;
  bad[1].destination.x += 8;
  CHECK(verdict(bad, 4096, 4096) == FVV_ISSUE_TILE_RECT);
  bad = good;
  bad[1].destination.y += 1;
  CHECK(verdict(bad, 4096, 4096) == FVV_ISSUE_TILE_RECT);
  for (int field = 0; field < 4; field++) {
    bad = good;
    fvv_rect &r = field < 2 ? bad[2].source : bad[2].destination;
    (field & 1 ? r.height : r.width) = 0;
    CHECK(verdict(bad, f.width, f.height) == FVV_ISSUE_TILE_RECT);
  }
  bad = good;
  bad[3].destination = bad[0].destination;
  CHECK(verdict(bad, f.width, f.height) == FVV_ISSUE_TILE_OVERLAP);
  bad = good;
  bad[1].destination.x -= 16;
  CHECK(verdict(bad, f.width, f.height) == FVV_ISSUE_TILE_OVERLAP);
  bad = good;
  bad[3].camera_id = bad[0].camera_id;
  CHECK(verdict(bad, f.width, f.height) == FVV_ISSUE_TILE_OVERLAP);
  bad = good;
  bad[3].destination.x = 65520;
  bad[3].destination.width = 65535;
  CHECK(verdict(bad, 65535, 65535) == FVV_ISSUE_TILE_RECT);
  // Tiles that touch do not overlap; one inside another does.
  bad = {tile(1, 16, 16), tile(2, 16, 16)};
  bad[1].destination.x = 16;
  CHECK(verdict(bad, 32, 16) == 0);
  bad[0].destination.width = 64;
  CHECK(verdict(bad, 64, 16) == FVV_ISSUE_TILE_OVERLAP);
}

// ---- video/: the TILE payload: there and back, every rule broken once, limits, cut and flipped bytes.

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

TEST_CASE("more tiles than cameras are refused before they are checked") {
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

TEST_CASE("a layout that readers with default limits refuse is not encoded") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  for (const size_t more : {0, 1}) {
    tiles_t all = same(limits.max_cameras + more, 16, 16);
    uint32_t width, height;
    REQUIRE(fvv_tiles_arrange(all.data(), all.size(), 16384, &width, &height, nullptr) == FVV_OK);
    size_t size = 0;
    fvv_diagnostic d = {};
    CHECK(fvv_tiles_encode(all.data(), all.size(), nullptr, 0, &size, &d) ==
          (more ? FVV_ERROR_INPUT : FVV_ERROR_BUFFER_TOO_SMALL));
    CHECK((d.issue == FVV_ISSUE_LIMIT) == (more > 0));
  }
}
