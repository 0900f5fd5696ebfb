// Writer and push reader on good streams: the round trip for any split of the bytes, from the beginning or
// joined late (clause 6.4).
#include "container_fixture.h"

#include <algorithm>

TEST_CASE("what the writer writes the reader reads, chunk by chunk") {
  const Bytes stream = small_stream();
  const Reading reading = read_stream(stream);
  CHECK(reading.status == FVV_END);
  CHECK(reading.good());
  CHECK(reading.count(FVV_EVENT_HEADER) == 1);
  CHECK(reading.count(FVV_EVENT_CHUNK) == 4 + 2 * 6 + 2);
  CHECK(reading.events.back().event.kind == FVV_EVENT_END);
  int frames = 0;
  for (const auto &seen : reading.events) {
    if (seen.event.chunk.type != FVV_CHUNK_MESH) continue;
    CHECK(seen.payload == pattern(24 + 3 * size_t(frames), 7 + uint32_t(frames)));
    CHECK(seen.event.chunk.time == frames);
    CHECK(seen.event.group_intact == 1);
    frames++;
  }
  CHECK(frames == 4);
  CHECK(stream.size() < 4096);
}

TEST_CASE("the same input gives the same bytes") {
  CHECK(small_stream(3, true, true) == small_stream(3, true, true));
}

TEST_CASE("any split of the bytes gives the same events") {
  for (const bool repeat : {false, true}) {
    const Bytes stream = small_stream(3, true, repeat);
    const Reading whole = read_stream(stream);
    REQUIRE(whole.good());
    for (const size_t step : {1, 2, 3, 5, 7, 8, 31, 32, 33, 64, 500, 1000}) {
      const Reading split = read_stream(stream, step);
      INFO("step " << step);
      CHECK(split.events == whole.events);
      CHECK(split.status == whole.status);
    }
  }
}

TEST_CASE("any split of damaged bytes gives the same events") {
  const Bytes good = small_stream(3);
  for (size_t n = 0; n < good.size(); n += 13) {
    Bytes stream = good;
    stream[n] ^= 0x40;
    if (n % 3 == 0)
      stream.erase(stream.begin() + long(n), stream.begin() + long(n) + 11 < stream.end()
                                                 ? stream.begin() + long(n) + 11
                                                 : stream.end());
    const Reading whole = read_stream(stream);
    for (const size_t step : {1, 7, 32, 100}) {
      const Reading split = read_stream(stream, step);
      INFO("byte " << n << ", step " << step);
      CHECK(split.events == whole.events);
    }
  }
}

TEST_CASE("a live stream without index is clean, but has no end") {
  const Reading reading = read_stream(small_stream(2, false));
  CHECK(reading.status == FVV_END);
  CHECK(reading.first_problem() == nullptr);
  CHECK(reading.count(FVV_EVENT_END) == 0);
  CHECK_FALSE(reading.good());
}

TEST_CASE("a reader can join at any group, and reports that it did") {
  const Bytes stream = small_stream(3, true, true);
  for (const size_t at : chunk_offsets(stream)) {
    const uint32_t type = fvv_get_u32(stream.data() + at);
    if (type != FVV_CHUNK_GROUP && type != FVV_CHUNK_SCENE) continue;
    const Reading reading = read_stream(stream.data() + at, stream.size() - at, 0, at);
    INFO("joined at " << at);
    CHECK(reading.first_problem() == nullptr);
    CHECK(reading.count(FVV_EVENT_END) == 1);
    for (const auto &seen : reading.events)
      if (seen.event.chunk.type == FVV_CHUNK_MESH) CHECK(seen.event.group_intact == 1);
  }
}

TEST_CASE("unknown ancillary chunks are skipped wherever they may stand") {
  MemoryOutput memory;
  const fvv_output output = memory.output();
  fvv_writer *writer = nullptr;
  fvv_diagnostic d;
  REQUIRE(fvv_writer_create(&output, nullptr, &writer, &d) == FVV_OK);
  const Bytes scene = scene_payload(), mesh = track_payload(FVV_TRACK_MESH, "");
  const uint32_t unknown = 0x7a7a7a7a;
  REQUIRE(fvv_writer_configuration(writer, FVV_CHUNK_SCENE, 0, 0, scene.data(), scene.size(), &d) == FVV_OK);
  REQUIRE(fvv_writer_configuration(writer, FVV_CHUNK_TRACK, 1, 0, mesh.data(), mesh.size(), &d) == FVV_OK);
  REQUIRE(fvv_writer_configuration(writer, unknown, 9, 0, "abc", 3, &d) == FVV_OK);
  REQUIRE(fvv_writer_begin_group(writer, 0, 10, &d) == FVV_OK);
  REQUIRE(fvv_writer_chunk(writer, unknown, 9, 0, 0, "abcd", 4, &d) == FVV_OK);
  REQUIRE(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 1, FVV_FLAG_KEY, 0, "m", 1, &d) == FVV_OK);
  REQUIRE(fvv_writer_end_group(writer, &d) == FVV_OK);
  REQUIRE(fvv_writer_finish(writer, &d) == FVV_OK);
  // Critical ones this writer cannot vouch for.
  fvv_writer_destroy(writer);
  CHECK(read_stream(memory.bytes).good());
}

TEST_CASE("the writer refuses what a reader would refuse, and writes nothing of it") {
  MemoryOutput memory;
  const fvv_output output = memory.output();
  fvv_writer *writer = nullptr;
  fvv_diagnostic d;
  REQUIRE(fvv_writer_create(&output, nullptr, &writer, &d) == FVV_OK);
  const auto refused = [&](fvv_status status, uint32_t issue) {
    CHECK(status == FVV_ERROR_STATE);
    CHECK(d.issue == issue);
    return d.issue == issue;
  };
  const Bytes scene = scene_payload(), mesh = track_payload(FVV_TRACK_MESH, "mesh");
  CHECK(refused(fvv_writer_configuration(writer, FVV_CHUNK_TRACK, 1, 0, mesh.data(), mesh.size(), &d),
                FVV_ISSUE_CHUNK_PLACE));
  CHECK(refused(fvv_writer_begin_group(writer, 0, 1, &d), FVV_ISSUE_NO_CONFIGURATION));
  CHECK(refused(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 1, 0, 0, "m", 1, &d), FVV_ISSUE_CHUNK_PLACE));
  REQUIRE(fvv_writer_configuration(writer, FVV_CHUNK_SCENE, 0, 0, scene.data(), scene.size(), &d) == FVV_OK);
  CHECK(refused(fvv_writer_configuration(writer, FVV_CHUNK_TRACK, 0, 0, mesh.data(), mesh.size(), &d),
                FVV_ISSUE_CHUNK_FIELDS));
  REQUIRE(fvv_writer_configuration(writer, FVV_CHUNK_TRACK, 1, 0, mesh.data(), mesh.size(), &d) == FVV_OK);
  CHECK(refused(fvv_writer_configuration(writer, FVV_CHUNK_TRACK, 1, 0, mesh.data(), mesh.size(), &d),
                FVV_ISSUE_TRACK_ID));
  CHECK(refused(fvv_writer_begin_group(writer, 5, 5, &d), FVV_ISSUE_GROUP_TIME));
  REQUIRE(fvv_writer_begin_group(writer, 0, 5, &d) == FVV_OK);
  CHECK(refused(fvv_writer_begin_group(writer, 5, 6, &d), FVV_ISSUE_GROUP_UNFINISHED));
  CHECK(refused(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 1, 0, 0, "m", 1, &d), FVV_ISSUE_TRACK_NOT_KEY));
  CHECK(refused(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 7, FVV_FLAG_KEY, 0, "m", 1, &d),
                FVV_ISSUE_TRACK_UNDECLARED));
  CHECK(refused(fvv_writer_chunk(writer, FVV_CHUNK_VIDEO_PACKET, 1, FVV_FLAG_KEY, 0, "m", 1, &d),
                FVV_ISSUE_TRACK_KIND_MISMATCH));
  CHECK(refused(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 1, FVV_FLAG_KEY, 5, "m", 1, &d),
                FVV_ISSUE_CHUNK_TIME));
  REQUIRE(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 1, FVV_FLAG_KEY, 3, "m", 1, &d) == FVV_OK);
  CHECK(refused(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 1, FVV_FLAG_KEY, 2, "m", 1, &d),
                FVV_ISSUE_CHUNK_TIME_ORDER));
  CHECK(refused(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 1, FVV_FLAG_KEY, 3, "m", 1, &d),
                FVV_ISSUE_CHUNK_TIME_ORDER));
  CHECK(refused(fvv_writer_finish(writer, &d), FVV_ISSUE_GROUP_UNFINISHED));
  REQUIRE(fvv_writer_end_group(writer, &d) == FVV_OK);
  CHECK(refused(fvv_writer_begin_group(writer, 4, 9, &d), FVV_ISSUE_GROUP_TIME));
  CHECK(fvv_writer_configuration(writer, FVV_CHUNK_MESH, 1, 0, "", 0, &d) == FVV_ERROR_ARGUMENT);
  REQUIRE(fvv_writer_finish(writer, &d) == FVV_OK);
  CHECK(refused(fvv_writer_begin_group(writer, 5, 9, &d), FVV_ISSUE_TRAILING));
  fvv_writer_destroy(writer);
  CHECK(read_stream(memory.bytes).good());
}

TEST_CASE("a failing output is reported and ends the writing") {
  struct Failing {
    size_t left;
    static fvv_status write(void *user, const void *, size_t size) {
      auto *self = static_cast<Failing *>(user);
      if (size > self->left) return FVV_ERROR_IO;
      self->left -= size;
      return FVV_OK;
    }
  } failing = {60};
  const fvv_output output = {Failing::write, &failing};
  fvv_writer *writer = nullptr;
  fvv_diagnostic d;
  REQUIRE(fvv_writer_create(&output, nullptr, &writer, &d) == FVV_OK);
  const Bytes scene = scene_payload();
  CHECK(fvv_writer_configuration(writer, FVV_CHUNK_SCENE, 0, 0, scene.data(), scene.size(), &d) ==
        FVV_ERROR_IO);
  CHECK(fvv_writer_begin_group(writer, 0, 1, &d) == FVV_ERROR_STATE);
  fvv_writer_destroy(writer);
  failing.left = 10;
  CHECK(fvv_writer_create(&output, nullptr, &writer, &d) == FVV_ERROR_IO);
  CHECK(writer == nullptr);
}

TEST_CASE("memory that runs out at any allocation is an error and no leak") {
  const Bytes stream = small_stream(2, true, true);
  bool completed = false;
  for (int budget = 0; !completed; budget++) {
    REQUIRE(budget < 1000);
    Budget state = {budget, 0};
    const fvv_allocator allocator = {Budget::resize, &state};
    fvv_reader *reader = nullptr;
    fvv_status status = fvv_reader_create(nullptr, &allocator, 0, &reader);
    if (status == FVV_OK) status = fvv_reader_push(reader, stream.data(), stream.size());
    if (status == FVV_OK) {
      fvv_reader_finish(reader);
      fvv_event event;
      while ((status = fvv_reader_next(reader, &event, nullptr)) == FVV_OK)
        CHECK(event.kind != FVV_EVENT_DAMAGE);
    }
    CHECK((status == FVV_ERROR_MEMORY || status == FVV_END));
    completed = status == FVV_END;
    fvv_reader_destroy(reader);
    CHECK(state.bytes == 0);
  }
}

// ---- Who joins late: an initialisation object and then groups from any on (clause 6.4).

namespace {

// Where the groups of small_stream begin.
std::vector<size_t> group_offsets(const Bytes &stream) {
  std::vector<size_t> out;
  for (const size_t at : chunk_offsets(stream))
    if (fvv_get_u32(stream.data() + at) == FVV_CHUNK_GROUP) out.push_back(at);
  return out;
}

Bytes part(const Bytes &stream, size_t from, size_t to) {
  return Bytes(stream.begin() + long(from), stream.begin() + long(to));
}

// All events of a reader that joins, with bytes pushed in steps.
Reading join_stream(const Bytes &bytes, size_t step) {
  Reading reading;
  fvv_reader *reader = nullptr;
  REQUIRE(fvv_reader_create(nullptr, nullptr, 0, &reader) == FVV_OK);
  REQUIRE(fvv_reader_join(reader) == FVV_OK);
  for (size_t at = 0;;) {
    Seen seen{};
    reading.status = fvv_reader_next(reader, &seen.event, &reading.diagnostic);
    if (reading.status == FVV_NEED_DATA && at < bytes.size()) {
      const size_t n = std::min(step, bytes.size() - at);
      REQUIRE(fvv_reader_push(reader, bytes.data() + at, n) == FVV_OK);
      at += n;
      continue;
    }
    if (reading.status == FVV_NEED_DATA) {
      fvv_reader_finish(reader);
      continue;
    }
    if (reading.status != FVV_OK) break;
    if (seen.event.kind == FVV_EVENT_CHUNK)
      seen.payload.assign(seen.event.payload, seen.event.payload + seen.event.chunk.size);
    seen.event.payload = nullptr;
    reading.events.push_back(seen);
  }
  fvv_reader_destroy(reader);
  return reading;
}

uint32_t issue_of(const Reading &reading) {
  const fvv_diagnostic *problem = reading.first_problem();
  return problem ? problem->issue : 0;
}

} // namespace

TEST_CASE("a reader that joins takes any group after the configuration, with index and footer") {
  const Bytes stream = small_stream(4);
  const std::vector<size_t> groups = group_offsets(stream);
  const Bytes head = part(stream, 0, groups[0]);
  for (size_t first = 0; first < groups.size(); first++) {
    INFO("group " << first);
    const Bytes joined = join({head, part(stream, groups[first], stream.size())});
    const Reading reading = join_stream(joined, joined.size());
    CHECK(reading.good());
    CHECK(reading.count(FVV_EVENT_HEADER) == 1);
    CHECK(reading.count(FVV_EVENT_CHUNK) == 4 + 6 * (groups.size() - first) + 2);
    for (const Seen &seen : reading.events)
      if (seen.event.chunk.type == FVV_CHUNK_MESH) CHECK(seen.event.group_intact == 1);
    CHECK(join_stream(joined, 7).events == reading.events);
    // A reader of the whole stream misses the groups before.
    CHECK(issue_of(read_stream(joined)) == uint32_t(first ? FVV_ISSUE_GROUP_SEQUENCE : 0));
  }
}

TEST_CASE("after the group with which it joined a reader reports missing groups as always") {
  const Bytes stream = small_stream(4, false);
  const std::vector<size_t> groups = group_offsets(stream);
  const Bytes head = part(stream, 0, groups[0]), third = part(stream, groups[2], groups[3]);
  const auto issue = [&](std::initializer_list<Bytes> parts) {
    return issue_of(join_stream(join(parts), 100000));
  };
  CHECK(issue({head, part(stream, groups[1], groups[2]), part(stream, groups[3], stream.size())}) ==
        FVV_ISSUE_GROUP_SEQUENCE);
  CHECK(issue({head, third, third}) == FVV_ISSUE_GROUP_TIME);
  CHECK(issue({head, third, part(stream, groups[1], groups[2])}) == FVV_ISSUE_GROUP_TIME);
  // The file header and the digest of the configuration hold for it too.
  CHECK(issue({third}) == FVV_ISSUE_SIGNATURE);
  Bytes other = head;
  other[24 + 32 + 48] ^= 3; // SCEN: another up axis, with good CRCs
  fvv_put_u32(other.data() + 24 + 24, fvv_crc32c(0, other.data() + 24 + 32, FVV_SCEN_SIZE));
  fvv_put_u32(other.data() + 24 + 28, fvv_crc32c(0, other.data() + 24, 28));
  CHECK(issue({other, third}) == FVV_ISSUE_GROUP_CONFIGURATION);
}

TEST_CASE("joining is decided before the first byte") {
  fvv_reader *reader = nullptr;
  REQUIRE(fvv_reader_create(nullptr, nullptr, 24, &reader) == FVV_OK);
  CHECK(fvv_reader_join(reader) == FVV_ERROR_STATE);
  fvv_reader_destroy(reader);
  REQUIRE(fvv_reader_create(nullptr, nullptr, 0, &reader) == FVV_OK);
  REQUIRE(fvv_reader_push(reader, "x", 1) == FVV_OK);
  CHECK(fvv_reader_join(reader) == FVV_ERROR_STATE);
  fvv_reader_destroy(reader);
}
