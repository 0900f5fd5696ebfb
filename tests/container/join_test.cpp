// Who joins late: an initialisation object and then groups from any on (clause 6.4).
#include "container_fixture.h"

#include <algorithm>

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

TEST_CASE("a reader that joins takes any group behind the configuration, with index and footer") {
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
    // A reader of the whole stream misses what is in front.
    CHECK(issue_of(read_stream(joined)) == uint32_t(first ? FVV_ISSUE_GROUP_SEQUENCE : 0));
  }
}

TEST_CASE("behind the group with which it joined a reader misses groups as always") {
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
