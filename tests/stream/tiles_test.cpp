// Layouts of groups: they hold for their group alone, in any order of access, and are never guessed
// after damage.
#include "stream_fixture.h"

#include <algorithm>
#include <map>
#include <sstream>

namespace {

constexpr uint16_t video = 2;

Chunk layout_chunk(int64_t time, const std::vector<fvv_tile> &tiles, uint16_t track = video) {
  Chunk out = tiles_chunk(track, tiles);
  out.type = FVV_CHUNK_TILES;
  out.flags = FVV_FLAG_KEY;
  out.time = time;
  return out;
}

// A crop of each camera, another one for each group; the third group shows one camera only.
std::vector<fvv_tile> crops(int group) {
  std::vector<fvv_tile> out = {{1, {uint16_t(group), 2, 12, 9}, {0, 0, 12, 9}}};
  if (group != 2) out.push_back({0, {3, uint16_t(group), 20, 10}, {16, 0, 30, 15}});
  return out;
}

// Groups 1, 2 and 4 have a layout of their own, 0 and 3 have not. A mesh precedes it.
Stream cropped_stream() {
  Stream out = good_stream(5);
  for (const int group : {1, 2, 4}) {
    std::vector<Chunk> &chunks = out.groups[size_t(group)].chunks;
    chunks.insert(chunks.begin() + 1, layout_chunk(6 * group, crops(group)));
  }
  return out;
}

std::vector<fvv_tile> expected(int group) {
  return group == 0 || group == 3 ? two_tiles : crops(group);
}

bool same(const fvv_rect &a, const fvv_rect &b) {
  return a.x == b.x && a.y == b.y && a.width == b.width && a.height == b.height;
}

// The layout of a group by the stream: the status, and the number of the rule if it is an error.
std::pair<fvv_status, uint32_t> ask(fvv_stream *stream, size_t group, std::vector<fvv_tile> *out = nullptr,
                                    uint16_t track = video) {
  const fvv_tile *tiles = nullptr;
  size_t count = 0;
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_stream_tiles(stream, group, track, &tiles, &count, &diagnostic);
  CHECK((status == FVV_OK) == (count > 0));
  if (status < 0 && status != FVV_ERROR_MEMORY) CHECK(diagnostic.status == status);
  if (out) out->assign(tiles, tiles + count);
  return {status, status < 0 ? diagnostic.issue : 0};
}

void expect_group(fvv_stream *stream, int group) {
  std::vector<fvv_tile> tiles;
  INFO("group " << group);
  REQUIRE(ask(stream, size_t(group), &tiles).first == FVV_OK);
  const std::vector<fvv_tile> wanted = expected(group);
  REQUIRE(tiles.size() == wanted.size());
  for (size_t i = 0; i < tiles.size(); i++) {
    CHECK(tiles[i].camera_id == wanted[i].camera_id);
    CHECK(same(tiles[i].source, wanted[i].source));
    CHECK(same(tiles[i].destination, wanted[i].destination));
  }
}

const fvv_track_summary &track_of(const Checked &checked, uint16_t track) {
  size_t i = 0;
  while (fvv_checker_track(checked.checker, i)->track != track) i++;
  return *fvv_checker_track(checked.checker, i);
}

uint32_t first_issue(const Bytes &stream) {
  const Checked checked(stream);
  return checked.problem_count() ? checked.problem(0).issue : 0;
}

constexpr uint32_t disguise = 0x656c6974; // tile

uint32_t signed_anew(uint8_t *chunk) {
  uint64_t size;
  std::memcpy(&size, chunk + 16, sizeof size);
  const uint32_t payload = fvv_crc32c(0, chunk + 32, size_t(size));
  std::memcpy(chunk + 24, &payload, sizeof payload);
  const uint32_t header = fvv_crc32c(0, chunk, 28);
  std::memcpy(chunk + 28, &header, sizeof header);
  return payload;
}

// The writer refuses what the checker finds: layouts are written as a private type, and changed afterwards,
// with their entries in the ends of groups and in the index.
Bytes forged(const Stream &stream) {
  Stream disguised = stream;
  for (Group &group : disguised.groups)
    for (Chunk &chunk : group.chunks)
      if (chunk.type == FVV_CHUNK_TILES) chunk.type = disguise;
  Bytes bytes = write(disguised);
  std::vector<uint32_t> chains;
  uint32_t chain = 0, index_crc = 0;
  for (const Place &place : chunks_of(bytes)) {
    uint8_t *chunk = bytes.data() + place.offset, *payload = chunk + 32;
    if (place.type == disguise) {
      std::memcpy(chunk, "TILE", 4);
      chunk[4] |= FVV_FLAG_CRITICAL;
      signed_anew(chunk);
    } else if (place.type == FVV_CHUNK_GROUP) {
      chain = 0;
    } else if (place.type == FVV_CHUNK_GROUP_END) {
      std::memcpy(payload + 8, &chain, sizeof chain);
      for (size_t row = 0; row < payload[16]; row++)
        if (!std::memcmp(payload + 24 + 8 * row, "tile", 4)) {
          std::memcpy(payload + 24 + 8 * row, "TILE", 4);
          payload[24 + 8 * row + 6] |= FVV_FLAG_CRITICAL;
        }
      signed_anew(chunk);
      chains.push_back(chain);
    } else if (place.type == FVV_CHUNK_INDEX) {
      for (size_t i = 0; i < chains.size(); i++)
        std::memcpy(payload + 8 + 56 * i + 40, &chains[i], sizeof chains[i]);
      index_crc = signed_anew(chunk);
    } else if (place.type == FVV_CHUNK_FOOTER) {
      std::memcpy(payload + 16, &index_crc, sizeof index_crc);
      signed_anew(chunk);
    }
    chain = fvv_crc32c(chain, chunk, 28);
  }
  return bytes;
}

Bytes vector_file() {
  std::ifstream file(FVV_CASES "/vector_tiles_crops/input.fvv", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

} // namespace

TEST_CASE("a layout holds for its group alone, in any order of access") {
  const Opened file(write(cropped_stream()));
  REQUIRE(file.status == FVV_OK);
  for (const int group : {0, 1, 2, 3, 4, 4, 1, 0, 2, 2, 3, 1}) expect_group(file.stream, group);
  CHECK(ask(file.stream, 1, nullptr, 1).first == FVV_END);
  CHECK(ask(file.stream, 1, nullptr, 77).first == FVV_END);
  CHECK(ask(file.stream, 5).first == FVV_ERROR_ARGUMENT);
  // Samples and meshes are where they were.
  const uint8_t *sample;
  size_t size;
  int key;
  CHECK(fvv_stream_frame_count(file.stream) == 15);
  CHECK(fvv_stream_sample(file.stream, 3, video, &sample, &size, &key, nullptr) == FVV_OK);
}

TEST_CASE("the checker counts layouts apart from samples") {
  const Checked checked(write(cropped_stream()));
  CHECK(checked.problem_count() == 0);
  CHECK(checked.summary().whole_frames == 15);
  const fvv_track_summary &track = track_of(checked, video);
  CHECK(track.chunks == 10);
  CHECK(track.key_chunks == 10);
  CHECK(track.smallest == track.largest);
  CHECK(track.layouts == 3);
  CHECK(track.least_tile_pixels == 12 * 9);
  CHECK(track.most_tile_pixels == 12 * 9 + 30 * 15);
  CHECK(track.bytes == 10 * track.largest + 3 * 8 + 5 * 24);
}

TEST_CASE("live streams and repeated configurations have layouts as well") {
  Stream stream = cropped_stream();
  stream.finish = false;
  stream.repeat = true;
  const Opened file(write(stream));
  REQUIRE(file.status == FVV_OK);
  for (const int group : {4, 1, 0, 2, 3}) expect_group(file.stream, group);
}

TEST_CASE("the writer and the checker refuse a layout in the wrong place") {
  struct Case {
    const char *name;
    uint32_t issue;
    void (*spoil)(std::vector<Chunk> &chunks);
  };
  const Case cases[] = {
      {"second", FVV_ISSUE_CHUNK_TIME_ORDER,
       [](std::vector<Chunk> &c) { c.insert(c.begin() + 2, layout_chunk(6, crops(1))); }},
      {"after a sample", FVV_ISSUE_TILE_GROUP,
       [](std::vector<Chunk> &c) {
         c.erase(c.begin() + 1);
         c.insert(c.begin() + 2, layout_chunk(6, crops(1)));
       }},
      {"at another time than the sample", FVV_ISSUE_TILE_GROUP, [](std::vector<Chunk> &c) { c[2].time = 7; }},
      {"of a mesh track", FVV_ISSUE_TRACK_KIND_MISMATCH, [](std::vector<Chunk> &c) { c[1].track = 1; }},
      {"of no track", FVV_ISSUE_TRACK_UNDECLARED, [](std::vector<Chunk> &c) { c[1].track = 9; }}};
  for (const Case &one : cases) {
    INFO(one.name);
    Stream stream = cropped_stream();
    one.spoil(stream.groups[1].chunks);
    const Bytes bytes = forged(stream);
    CHECK(first_issue(bytes) == one.issue);
    const Opened file(bytes);
    REQUIRE(file.status == FVV_OK);
    const auto [status, issue] = ask(file.stream, 1);
    if (std::string(one.name) == "second" || std::string(one.name) == "after a sample") {
      CHECK(status == FVV_ERROR_INVALID);
      CHECK(issue == FVV_ISSUE_TILE_GROUP);
    }
    expect_group(file.stream, 2);
    // The writer checks each chunk.
    Bytes out;
    const fvv_output output = {append, &out};
    fvv_writer *writer = nullptr;
    REQUIRE(fvv_writer_create(&output, nullptr, &writer, nullptr) == FVV_OK);
    for (const Chunk &chunk : stream.configuration)
      REQUIRE(fvv_writer_configuration(writer, chunk.type, chunk.track, 0, chunk.payload.data(),
                                       chunk.payload.size(), nullptr) == FVV_OK);
    REQUIRE(fvv_writer_begin_group(writer, 6, 12, nullptr) == FVV_OK);
    fvv_status written = FVV_OK;
    fvv_diagnostic diagnostic = {};
    for (const Chunk &chunk : stream.groups[1].chunks)
      if (written == FVV_OK)
        written = fvv_writer_chunk(writer, chunk.type, chunk.track, chunk.flags, chunk.time,
                                   chunk.payload.data(), chunk.payload.size(), &diagnostic);
    CHECK(written < 0);
    CHECK(diagnostic.issue == one.issue);
    fvv_writer_destroy(writer);
  }
}

TEST_CASE("without the key flag a layout belongs to a configuration") {
  const Stream stream = cropped_stream();
  Bytes bytes = write(stream);
  for (const Place &place : chunks_of(bytes)) {
    uint8_t *chunk = bytes.data() + place.offset;
    if (place.type != FVV_CHUNK_TILES || !(chunk[4] & FVV_FLAG_KEY)) continue;
    chunk[4] = FVV_FLAG_CRITICAL;
    std::memset(chunk + 8, 0, 8); // time
    signed_anew(chunk);
    break;
  }
  CHECK(first_issue(bytes) == FVV_ISSUE_GROUP_UNFINISHED);
  Bytes out;
  const fvv_output output = {append, &out};
  fvv_writer *writer = nullptr;
  REQUIRE(fvv_writer_create(&output, nullptr, &writer, nullptr) == FVV_OK);
  fvv_diagnostic diagnostic = {};
  for (const Chunk &chunk : stream.configuration) {
    const bool is_layout = chunk.type == FVV_CHUNK_TILES;
    if (is_layout) {
      CHECK(fvv_writer_configuration(writer, chunk.type, chunk.track, FVV_FLAG_KEY, chunk.payload.data(),
                                     chunk.payload.size(), &diagnostic) == FVV_ERROR_ARGUMENT);
      CHECK(diagnostic.issue == FVV_ISSUE_CHUNK_PLACE);
    }
    REQUIRE(fvv_writer_configuration(writer, chunk.type, chunk.track, 0, chunk.payload.data(),
                                     chunk.payload.size(), nullptr) == FVV_OK);
  }
  REQUIRE(fvv_writer_begin_group(writer, 6, 12, nullptr) == FVV_OK);
  const Chunk &layout = stream.groups[1].chunks[1];
  CHECK(fvv_writer_chunk(writer, layout.type, layout.track, 0, 6, layout.payload.data(),
                         layout.payload.size(), &diagnostic) == FVV_ERROR_ARGUMENT);
  CHECK(diagnostic.issue == FVV_ISSUE_CHUNK_PLACE);
  fvv_writer_destroy(writer);
}

TEST_CASE("a layout keeps to the rules of TILE, and a wrong one takes its frames with it") {
  const std::map<std::string, std::pair<std::vector<fvv_tile>, uint32_t>> cases = {
      {"camera", {{{7, {0, 0, 12, 9}, {0, 0, 12, 9}}}, FVV_ISSUE_TILE_SHOWN}},
      {"picture", {{{1, {21, 0, 12, 9}, {0, 0, 12, 9}}}, FVV_ISSUE_TILE_RECT}},
      {"frame", {{{1, {0, 0, 12, 9}, {64, 0, 12, 9}}}, FVV_ISSUE_TILE_RECT}},
      {"height", {{{1, {0, 0, 12, 9}, {0, 0, 12, 17}}}, FVV_ISSUE_TILE_RECT}}};
  for (const auto &[name, wrong] : cases) {
    INFO(name);
    Stream stream = cropped_stream();
    stream.groups[1].chunks[1] = layout_chunk(6, wrong.first);
    const Bytes bytes = write(stream);
    const Checked checked(bytes);
    REQUIRE(checked.problem_count() == 1);
    CHECK(checked.problem(0).issue == wrong.second);
    CHECK(checked.problem(0).chunk_type == FVV_CHUNK_TILES);
    // Frames 3 and 4 have samples, 5 has a mesh alone.
    CHECK(checked.summary().whole_frames == 13);
    const Opened file(bytes);
    REQUIRE(file.status == FVV_OK);
    CHECK(ask(file.stream, 1) == std::pair<fvv_status, uint32_t>(FVV_ERROR_INVALID, wrong.second));
    for (const int group : {0, 2, 1, 4})
      if (group != 1) expect_group(file.stream, group);
  }
}

TEST_CASE("a track that shows something else has no layout") {
  Stream stream = cropped_stream();
  stream.configuration[5] = video_chunk(video, FVV_SHOWS_ATLAS);
  stream.configuration.erase(stream.configuration.begin() + 6);
  const Bytes bytes = write(stream);
  CHECK(first_issue(bytes) == FVV_ISSUE_TILE_SHOWN);
  const Opened file(bytes);
  REQUIRE(file.status == FVV_OK);
  CHECK(ask(file.stream, 1).first == FVV_END);
}

TEST_CASE("where a layout may have been lost, the configuration's is not used") {
  const Bytes good = write(cropped_stream());
  const std::vector<Place> places = chunks_of(good);
  for (size_t i = 0; i < places.size(); i++) {
    if (places[i].type != FVV_CHUNK_TILES || !(good[places[i].offset + 4] & FVV_FLAG_KEY)) continue;
    INFO("layout at " << places[i].offset);
    for (const bool index : {true, false})
      for (const int kind : {0, 1, 2}) {
        Bytes bad = good;
        if (!index) bad.resize(places[places.size() - 2].offset); // no INDX, no FOOT
        const auto at = bad.begin() + std::ptrdiff_t(places[i].offset);
        if (kind == 0) at[40] ^= 1;
        if (kind == 1) at[3] ^= 1;
        if (kind == 2) bad.erase(at, at + std::ptrdiff_t(places[i].extent));
        const Opened file(bad);
        REQUIRE(file.status == FVV_OK);
        size_t wrong = 0;
        for (size_t group = 0; group < fvv_stream_group_count(file.stream); group++) {
          const auto status = ask(file.stream, group).first;
          if (status == FVV_OK)
            expect_group(file.stream, int(fvv_stream_group(file.stream, group)->sequence));
          else
            wrong++;
        }
        CHECK(wrong == 1);
        CHECK(Checked(bad).problem_count() > 0);
      }
  }
}

namespace {

constexpr uint16_t other_video = 3;

// The same with another video track, whose layouts and samples come before those of the first, and with
// chunks of an unknown type between them.
Stream crowded_stream() {
  Stream out = cropped_stream();
  std::vector<Chunk> &block = out.configuration;
  block.insert(block.begin() + 3, track_chunk(other_video, FVV_TRACK_VIDEO));
  block.insert(block.end() - 1, video_chunk(other_video));
  block.insert(block.end() - 1, tiles_chunk(other_video, two_tiles));
  for (int group = 0; group < 5; group++) {
    std::vector<Chunk> &chunks = out.groups[size_t(group)].chunks;
    const Chunk added[] = {layout_chunk(6 * group, crops(4 - group), other_video),
                           sample_chunk(6 * group, group, other_video),
                           {0x58585858, 1, 0, 6 * group, Bytes(20)}};
    chunks.insert(chunks.begin() + 1, std::begin(added), std::end(added));
  }
  return out;
}

bool is_layout(const Bytes &stream, const Place &place, uint16_t track) {
  return place.type == FVV_CHUNK_TILES && stream[place.offset + 4] & FVV_FLAG_KEY &&
         stream[place.offset + 6] == track;
}

// Groups whose layout is an error; that of each other is the one that was written.
size_t groups_without_layout(const Bytes &bytes) {
  const Opened file(bytes);
  REQUIRE(file.status == FVV_OK);
  REQUIRE(fvv_stream_group_count(file.stream) == 5);
  size_t wrong = 0;
  for (size_t group = 0; group < 5; group++)
    if (ask(file.stream, group).first == FVV_OK)
      expect_group(file.stream, int(group));
    else
      wrong++;
  return wrong;
}

} // namespace

TEST_CASE("a damaged chunk that is no layout of the track costs no layout") {
  const Bytes good = write(crowded_stream());
  const std::vector<Place> places = chunks_of(good);
  const size_t index = places[places.size() - 2].offset;
  size_t groups = 0, payloads = 0, headers = 0;
  Place group{}, end{};
  for (size_t i = 0; i < places.size(); i++) {
    const Place &place = places[i];
    if (place.type == FVV_CHUNK_GROUP) {
      group = place;
      groups++;
      size_t last = i;
      while (places[last].type != FVV_CHUNK_GROUP_END) last++;
      end = places[last];
    }
    if (!groups || place.offset <= group.offset || place.offset >= end.offset) continue;
    INFO("chunk at " << place.offset);
    const bool is_own = is_layout(good, place, video);
    // Without an index, and with one that names a group whose table is damaged.
    for (const bool cut : {true, false}) {
      Bytes bad = good;
      bad[place.offset + 33] ^= 1;
      if (cut)
        bad.resize(index);
      else
        bad[end.offset + 40] ^= 1;
      CHECK(groups_without_layout(bad) == (is_own ? 1 : 0));
      payloads++;
      // Another one of the group.
      if (places[i + 1].offset < end.offset && !is_own && !is_layout(good, places[i + 1], video)) {
        bad[places[i + 1].offset + 33] ^= 1;
        CHECK(groups_without_layout(bad) == 0);
      }
    }
    // Without its header it may be the layout, if it is before the first sample and none is there.
    Bytes bad(good.begin(), good.begin() + std::ptrdiff_t(index));
    bad[place.offset + 3] ^= 1;
    const bool has_own = std::any_of(places.begin(), places.end(), [&](const Place &one) {
      return one.offset > group.offset && one.offset < end.offset && is_layout(good, one, video);
    });
    bool is_before = false;
    for (size_t k = i + 1; places[k].offset < end.offset; k++)
      is_before |= places[k].type == FVV_CHUNK_VIDEO_PACKET && good[places[k].offset + 6] == video;
    bool is_first = true;
    for (size_t k = i; places[k].type != FVV_CHUNK_GROUP; k--)
      is_first &= k == i || places[k].type != FVV_CHUNK_VIDEO_PACKET || good[places[k].offset + 6] != video;
    CHECK(groups_without_layout(bad) == (is_own || (!has_own && is_before && is_first) ? 1 : 0));
    headers++;
  }
  CHECK((groups == 5 && payloads == 2 * headers && headers > 35));
}

TEST_CASE("a cut stream keeps the layouts that it has") {
  const Bytes good = write(cropped_stream());
  for (size_t size = 24; size < good.size(); size += 5) {
    const Opened file(Bytes(good.begin(), good.begin() + std::ptrdiff_t(size)));
    if (file.status < 0) continue;
    INFO("cut to " << size);
    for (size_t frame = 0; frame < fvv_stream_frame_count(file.stream); frame++) {
      const uint8_t *sample;
      size_t bytes;
      int key;
      fvv_frame info;
      if (fvv_stream_sample(file.stream, frame, video, &sample, &bytes, &key, nullptr) != FVV_OK) continue;
      REQUIRE(fvv_stream_frame(file.stream, frame, &info, nullptr) == FVV_OK);
      expect_group(file.stream, int(info.group));
    }
  }
}

TEST_CASE("payloads of layouts that are spoiled and signed cost little") {
  uint32_t state = 5;
  const auto random = [&](size_t n) { return size_t((state = state * 1664525 + 1013904223) >> 8) % n; };
  size_t refused = 0;
  for (int round = 0; round < 1000; round++) {
    Stream stream = cropped_stream();
    Bytes &payload = stream.groups[1].chunks[1].payload;
    if (random(4) == 0)
      payload.resize(random(payload.size()));
    else
      for (size_t i = 0; i < 1 + random(2); i++) payload[random(payload.size())] ^= uint8_t(1 + random(255));
    Memory memory;
    const fvv_allocator allocator = memory.allocator();
    {
      const Opened file(write(stream), &allocator);
      REQUIRE(file.status == FVV_OK);
      refused += ask(file.stream, 1).first < 0;
      expect_group(file.stream, 2);
    }
    CHECK(memory.live == 0);
  }
  CHECK(refused > 600);
}

TEST_CASE("failing memory leaks nothing") {
  const Bytes good = write(cropped_stream());
  for (int64_t n = 0; n < 60; n++)
    with_failing_memory(n, [&](const fvv_allocator *allocator) {
      const Opened file(good, allocator);
      if (file.status < 0) return;
      for (size_t group = 0; group < 5; group++) {
        const auto status = ask(file.stream, group).first;
        CHECK((status == FVV_OK || status == FVV_ERROR_MEMORY));
      }
    });
}

TEST_CASE("the vector agrees with the plain reader") {
  const Bytes bytes = vector_file();
  REQUIRE(bytes == write(cropped_stream()));
  const Opened file(bytes);
  REQUIRE(file.status == FVV_OK);
  std::ifstream listed(FVV_LISTINGS "/tiles_crops.txt");
  std::string line;
  std::ostringstream ours;
  for (size_t group = 0; group < 5; group++) {
    std::vector<fvv_tile> tiles;
    REQUIRE(ask(file.stream, group, &tiles).first == FVV_OK);
    for (const fvv_tile &tile : tiles) {
      ours << group << " " << tile.camera_id;
      for (const fvv_rect &r : {tile.source, tile.destination})
        ours << "  " << r.x << " " << r.y << " " << r.width << " " << r.height;
      ours << "\n";
    }
  }
  const std::string text((std::istreambuf_iterator<char>(listed)), {});
  CHECK(ours.str() == text);
}

TEST_CASE("write the vector", "[.][make]") {
  write_vector(FVV_CASES "/vector_tiles_crops/input.fvv", write(cropped_stream()));
}
