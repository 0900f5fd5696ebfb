// Groups and chunks of a stream: they can be had without what frames need.
#include "stream_fixture.h"

namespace {

// Where a stream was read.
struct Reads {
  const Bytes &bytes;
  std::vector<Place> places = {};
  static fvv_status read_at(void *user, uint64_t offset, void *out, size_t size) {
    auto *self = static_cast<Reads *>(user);
    self->places.push_back({size_t(offset), size, 0});
    REQUIRE(offset + size <= self->bytes.size());
    std::memcpy(out, self->bytes.data() + offset, size);
    return FVV_OK;
  }
  fvv_input input() { return {read_at, this, bytes.size()}; }
};

} // namespace

TEST_CASE("groups, their chunks and payloads are what was written") {
  const Stream written = good_stream();
  for (const bool finished : {true, false}) {
    Stream stream = written;
    stream.finish = finished;
    Opened opened(write(stream));
    REQUIRE(opened.status == FVV_OK);
    fvv_stream *s = opened.stream;
    CHECK(fvv_stream_index_state(s) == (finished ? FVV_INDEX_PRESENT : FVV_INDEX_REBUILT));
    CHECK((fvv_stream_damage_count(s) == 0 && !fvv_stream_damage(s, 0)));
    REQUIRE(fvv_stream_group_count(s) == stream.groups.size());
    CHECK(!fvv_stream_group(s, stream.groups.size()));
    const fvv_chunk_info *chunks = nullptr;
    const uint8_t *payload = nullptr;
    size_t count = 0;
    const auto expect = [&](const std::vector<Chunk> &wanted) {
      REQUIRE(count == wanted.size());
      for (size_t i = 0; i < count; i++) {
        CHECK((chunks[i].type == wanted[i].type && chunks[i].track == wanted[i].track));
        REQUIRE(fvv_stream_read_chunk(s, &chunks[i], &payload, &opened.diagnostic) == FVV_OK);
        CHECK(Bytes(payload, payload + chunks[i].size) == wanted[i].payload);
      }
    };
    for (size_t g = 0; g < stream.groups.size(); g++) {
      const fvv_group_info &group = *fvv_stream_group(s, g);
      CHECK((group.start == stream.groups[g].start && group.end == stream.groups[g].end && group.intact));
      REQUIRE(fvv_stream_group_chunks(s, g, &chunks, &count, &opened.diagnostic) == FVV_OK);
      expect(stream.groups[g].chunks);
      REQUIRE(fvv_stream_configuration_chunks(s, g, &chunks, &count, &opened.diagnostic) == FVV_OK);
      expect(stream.configuration);
    }
    CHECK(fvv_stream_group_chunks(s, 9, &chunks, &count, &opened.diagnostic) == FVV_ERROR_ARGUMENT);
    CHECK(fvv_stream_configuration_chunks(s, 9, &chunks, &count, &opened.diagnostic) == FVV_ERROR_ARGUMENT);
  }
}

TEST_CASE("opening a stream reads its header and index, and keeps nothing else") {
  Stream stream = good_stream(1);
  const Group group = stream.groups[0];
  for (int64_t g = 1; g < 1000; g++) {
    stream.groups.push_back({6 * g, 6 * g + 6, {group.chunks[0]}});
    stream.groups.back().chunks[0].time = 6 * g;
  }
  const Bytes bytes = write(stream);
  Reads reads = {bytes};
  Memory memory;
  const fvv_input input = reads.input();
  const fvv_allocator allocator = memory.allocator();
  fvv_stream *opened = nullptr;
  REQUIRE(fvv_stream_open(&input, nullptr, &allocator, &opened, nullptr) == FVV_OK);
  size_t index = 0;
  for (const Place &place : chunks_of(bytes))
    if (place.type == FVV_CHUNK_INDEX) index = place.offset;
  for (const Place &place : reads.places) CHECK((place.offset == 0 || place.offset >= index));
  // 64 bytes of each entry and a pointer to its table; the numbers of frames come with the first frame.
  CHECK(memory.live < 72 * stream.groups.size() + 4000);
  fvv_frame frame;
  REQUIRE(fvv_stream_frame(opened, 999, &frame, nullptr) == FVV_OK);
  CHECK((frame.group == 997 && frame.time == 6 * 997));
  fvv_stream_close(opened);
  CHECK(memory.live == 0);
}

TEST_CASE("a stream opens although its configuration is damaged, and its chunks can be read") {
  Bytes bytes = write(good_stream());
  for (const Place &place : chunks_of(bytes))
    if (place.type == FVV_CHUNK_VIDEO_CONFIG) bytes[place.offset + 32] ^= 1;
  Opened opened(bytes);
  REQUIRE(opened.status == FVV_OK);
  const fvv_configuration *configuration = nullptr;
  const fvv_chunk_info *chunks = nullptr;
  const uint8_t *payload = nullptr;
  size_t count = 0;
  CHECK(fvv_stream_configuration(opened.stream, 0, &configuration, nullptr) == FVV_ERROR_DAMAGED);
  CHECK(fvv_stream_configuration_chunks(opened.stream, 0, &chunks, &count, nullptr) == FVV_ERROR_DAMAGED);
  REQUIRE(fvv_stream_group_chunks(opened.stream, 1, &chunks, &count, nullptr) == FVV_OK);
  REQUIRE(count == good_stream().groups[1].chunks.size());
  CHECK(fvv_stream_read_chunk(opened.stream, &chunks[0], &payload, nullptr) == FVV_OK);
}
