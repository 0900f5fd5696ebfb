// Damaged streams: all damage has to be noticed, and what is reported as intact must be what was written.
#include "container_fixture.h"

#include <map>
#include <tuple>

namespace {

using Key = std::tuple<uint32_t, uint16_t, int64_t>;

// Payloads by type, track and time of the undamaged stream.
std::map<Key, Bytes> originals(const Bytes &stream) {
  std::map<Key, Bytes> out;
  for (const auto &seen : read_stream(stream).events)
    if (seen.event.kind == FVV_EVENT_CHUNK)
      out[{seen.event.chunk.type, seen.event.chunk.track, seen.event.chunk.time}] = seen.payload;
  return out;
}

// 1 when a chunk of a frame is called intact and is not what was written.
int silently_wrong(const std::map<Key, Bytes> &truth, const Reading &reading) {
  for (const auto &seen : reading.events) {
    const auto &chunk = seen.event.chunk;
    if (seen.event.kind != FVV_EVENT_CHUNK || !seen.event.group_intact) continue;
    if (fvv_chunk_place(chunk.type, chunk.flags) != FVV_PLACE_FRAME) continue;
    const auto it = truth.find({chunk.type, chunk.track, chunk.time});
    if (it == truth.end() || it->second != seen.payload) return 1;
  }
  return 0;
}

} // namespace

TEST_CASE("every truncation is noticed") {
  for (const bool repeat : {false, true}) {
    const Bytes stream = small_stream(2, true, repeat);
    const auto truth = originals(stream);
    for (size_t size = 0; size < stream.size(); size++) {
      const Reading reading = read_stream(stream.data(), size);
      INFO("cut to " << size << " of " << stream.size());
      CHECK_FALSE(reading.good());
      CHECK(silently_wrong(truth, reading) == 0);
    }
  }
}

TEST_CASE("every flipped bit is noticed") {
  const Bytes stream = small_stream();
  const auto truth = originals(stream);
  for (size_t bit = 0; bit < stream.size() * 8; bit++) {
    Bytes bad = stream;
    bad[bit / 8] ^= uint8_t(1 << bit % 8);
    const Reading reading = read_stream(bad);
    INFO("bit " << bit % 8 << " of byte " << bit / 8);
    CHECK(reading.first_problem() != nullptr);
    CHECK(silently_wrong(truth, reading) == 0);
  }
}

TEST_CASE("every range of chunks taken out, doubled or moved is noticed") {
  const Bytes stream = small_stream(3, true, true);
  const auto truth = originals(stream);
  std::vector<size_t> edges = chunk_offsets(stream);
  edges.push_back(stream.size());
  for (size_t a = 0; a + 1 < edges.size(); a++)
    for (size_t b = a + 1; b < edges.size(); b++) {
      const auto from = stream.begin() + long(edges[a]), to = stream.begin() + long(edges[b]);
      Bytes without(stream.begin(), from), twice(stream.begin(), to);
      without.insert(without.end(), to, stream.end());
      twice.insert(twice.end(), from, stream.end());
      INFO("chunks " << a << " to " << b);
      for (const Bytes &bad : {without, twice}) {
        const Reading reading = read_stream(bad);
        CHECK_FALSE(reading.good());
        CHECK(silently_wrong(truth, reading) == 0);
      }
      if (b + 1 < edges.size()) { // exchanged with the next chunk
        Bytes moved(stream.begin(), from);
        const auto next = stream.begin() + long(edges[b + 1]);
        moved.insert(moved.end(), to, next);
        moved.insert(moved.end(), from, to);
        moved.insert(moved.end(), next, stream.end());
        const Reading reading = read_stream(moved);
        CHECK_FALSE(reading.good());
        CHECK(silently_wrong(truth, reading) == 0);
      }
    }
}

TEST_CASE("bytes taken out, put in or overwritten anywhere cost the frames they touch and no others") {
  const Bytes stream = small_stream(4);
  const auto truth = originals(stream);
  const size_t whole = read_stream(stream).count(FVV_EVENT_CHUNK);
  for (size_t at = 24; at + 5 < stream.size(); at += 3) {
    Bytes cut = stream, grown = stream, written = stream;
    cut.erase(cut.begin() + long(at), cut.begin() + long(at) + 5);
    grown.insert(grown.begin() + long(at), 5, 0x55);
    for (size_t i = 0; i < 5; i++) written[at + i] ^= 0xa5;
    for (const Bytes &bad : {cut, grown, written}) {
      const Reading reading = read_stream(bad);
      INFO("byte " << at);
      CHECK(reading.first_problem() != nullptr);
      CHECK(silently_wrong(truth, reading) == 0);
      // Five bytes touch two chunks at the most.
      CHECK(reading.count(FVV_EVENT_CHUNK) + 2 >= whole);
    }
  }
}

TEST_CASE("a group without its end, at any alignment, costs nothing of what follows") {
  const Bytes stream = small_stream(3, true, true);
  const size_t whole = read_stream(stream).count(FVV_EVENT_CHUNK);
  const std::vector<size_t> offsets = chunk_offsets(stream);
  for (size_t i = 0; i + 1 < offsets.size(); i++) {
    if (fvv_get_u32(stream.data() + offsets[i]) != FVV_CHUNK_GROUP_END) continue;
    for (size_t inserted = 1; inserted < 16; inserted++) {
      // Bytes before the first chunk, and nothing wrong in the group but that it does not end.
      Bytes bad(stream.begin(), stream.begin() + 24);
      bad.insert(bad.end(), inserted, 0x55);
      bad.insert(bad.end(), stream.begin() + 24, stream.begin() + long(offsets[i]));
      bad.insert(bad.end(), stream.begin() + long(offsets[i + 1]), stream.end());
      const Reading reading = read_stream(bad);
      INFO("chunk " << i << ", " << inserted << " bytes");
      CHECK(reading.count(FVV_EVENT_CHUNK) == whole - 1);
      CHECK(reading.events == read_stream(bad, 7).events);
    }
  }
}

TEST_CASE("bytes that were skipped are counted exactly") {
  const Bytes stream = small_stream(3);
  for (const size_t at : chunk_offsets(stream)) {
    Bytes bad = stream;
    bad[at + 3] ^= 1; // the header is lost, so its whole chunk is
    const size_t extent = size_t(fvv_chunk_extent(fvv_get_u64(stream.data() + at + 16)));
    const Reading reading = read_stream(bad);
    uint64_t skipped = 0;
    for (const auto &seen : reading.events) skipped += seen.event.skipped;
    INFO("chunk at " << at);
    CHECK(skipped == extent);
    REQUIRE(reading.first_problem() != nullptr);
    CHECK(reading.first_problem()->offset == at);
    CHECK(reading.first_problem()->issue == FVV_ISSUE_CHUNK_HEADER);
  }
}

TEST_CASE("one lost byte gives one message, not a cascade") {
  const Bytes stream = small_stream(3);
  for (const size_t at : chunk_offsets(stream)) {
    const uint32_t type = fvv_get_u32(stream.data() + at);
    Bytes bad = stream;
    bad[at + 35] ^= 1; // first payload bytes
    const Reading reading = read_stream(bad);
    INFO("chunk at " << at << " of type " << type);
    CHECK(reading.count(FVV_EVENT_DAMAGE) == 1);
  }
}

// What a reader reports when a range of a stream is missing.
struct Loss {
  Loss(const Bytes &stream, size_t from, size_t to) {
    Bytes bytes(stream.begin(), stream.begin() + long(from));
    bytes.insert(bytes.end(), stream.begin() + long(to), stream.end());
    for (const auto &seen : read_stream(bytes).events) {
      const auto &event = seen.event;
      if (event.kind == FVV_EVENT_DAMAGE) issues.push_back(event.diagnostic.issue);
      if (event.kind == FVV_EVENT_CHUNK && event.chunk.type == FVV_CHUNK_GROUP_END && event.group_intact)
        intact.push_back(event.chunk.time / 2 - 1);
    }
  }
  std::vector<uint32_t> issues;
  std::vector<int64_t> intact; // groups
};

TEST_CASE("a group that is missing costs itself alone, and no right index is called wrong") {
  for (const bool repeat : {false, true}) {
    const Bytes stream = small_stream(5, true, repeat);
    std::vector<size_t> begins, ends, after;
    for (const size_t at : chunk_offsets(stream)) {
      const uint32_t type = fvv_get_u32(stream.data() + at);
      const size_t next = at + size_t(fvv_chunk_extent(fvv_get_u64(stream.data() + at + 16)));
      if (type == FVV_CHUNK_GROUP) {
        begins.push_back(at);
        after.push_back(next);
      }
      if (type == FVV_CHUNK_GROUP_END) ends.push_back(next);
    }
    using Groups = std::vector<int64_t>;
    using Issues = std::vector<uint32_t>;
    // The footer no longer fits the size of the file in any case.
    const Loss one(stream, begins[1], ends[1]);
    CHECK(one.intact == Groups{0, 2, 3, 4});
    CHECK(one.issues == Issues{FVV_ISSUE_GROUP_SEQUENCE, FVV_ISSUE_FOOTER});
    const Loss two(stream, begins[1], ends[2]);
    CHECK(two.intact == Groups{0, 3, 4});
    CHECK(two.issues == Issues{FVV_ISSUE_GROUP_SEQUENCE, FVV_ISSUE_FOOTER});
    const Loss first(stream, begins[0], ends[0]);
    CHECK(first.intact == Groups{1, 2, 3, 4});
    CHECK(first.issues == Issues{FVV_ISSUE_GROUP_SEQUENCE, FVV_ISSUE_FOOTER});
    // Without GRUP its chunks are where no group is open: one message for the group.
    const Loss headless(stream, begins[1], after[1]);
    CHECK(headless.intact == Groups{0, 2, 3, 4});
    CHECK(headless.issues == Issues{FVV_ISSUE_CHUNK_PLACE, FVV_ISSUE_FOOTER});
    // Two losses with a whole group between them are two messages.
    Bytes bytes(stream.begin(), stream.begin() + long(begins[1]));
    bytes.insert(bytes.end(), stream.begin() + long(ends[1]), stream.end());
    const size_t gone = ends[1] - begins[1];
    const Loss apart(bytes, begins[3] - gone, ends[3] - gone);
    CHECK(apart.intact == Groups{0, 2, 4});
    CHECK(apart.issues == Issues{FVV_ISSUE_GROUP_SEQUENCE, FVV_ISSUE_GROUP_SEQUENCE, FVV_ISSUE_FOOTER});
  }
}

TEST_CASE("an index that leaves a group out is wrong") {
  const Bytes stream = small_stream(3);
  const std::vector<size_t> chunks = chunk_offsets(stream);
  const size_t index = chunks[chunks.size() - 2];
  Bytes bytes(stream.begin(), stream.begin() + long(index));
  Bytes payload(stream.begin() + long(index) + 32, stream.begin() + long(chunks.back()) - 56);
  fvv_put_u32(payload.data(), 2);
  const Bytes wrong = hand_chunk("INDX", 0, 0, 0, 0, payload);
  bytes.insert(bytes.end(), wrong.begin(), wrong.end());
  const Reading reading = read_stream(bytes);
  REQUIRE(reading.first_problem() != nullptr);
  CHECK(reading.first_problem()->issue == FVV_ISSUE_INDEX);
}

TEST_CASE("a header inside a payload is found only when the stream is damaged there") {
  // The payload is a whole chunk of another stream: tempting for a scanner.
  MemoryOutput memory;
  const fvv_output output = memory.output();
  fvv_writer *writer = nullptr;
  fvv_diagnostic d;
  REQUIRE(fvv_writer_create(&output, nullptr, &writer, &d) == FVV_OK);
  const Bytes scene = scene_payload(), mesh = track_payload(FVV_TRACK_MESH, "");
  const Bytes inner = hand_chunk("MESH", 3, 1, 1, 0, pattern(8, 5));
  REQUIRE(fvv_writer_configuration(writer, FVV_CHUNK_SCENE, 0, 0, scene.data(), scene.size(), &d) == FVV_OK);
  REQUIRE(fvv_writer_configuration(writer, FVV_CHUNK_TRACK, 1, 0, mesh.data(), mesh.size(), &d) == FVV_OK);
  REQUIRE(fvv_writer_begin_group(writer, 0, 9, &d) == FVV_OK);
  const uint64_t at = fvv_writer_position(writer);
  REQUIRE(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 1, FVV_FLAG_KEY, 0, inner.data(), inner.size(), &d) ==
          FVV_OK);
  REQUIRE(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 1, FVV_FLAG_KEY, 1, "m", 1, &d) == FVV_OK);
  REQUIRE(fvv_writer_end_group(writer, &d) == FVV_OK);
  REQUIRE(fvv_writer_finish(writer, &d) == FVV_OK);
  fvv_writer_destroy(writer);
  CHECK(read_stream(memory.bytes).good());
  Bytes bad = memory.bytes;
  bad[size_t(at)] ^= 1; // its header lost: the inner chunk turns up, and must not be called intact
  const Reading reading = read_stream(bad);
  CHECK(reading.first_problem() != nullptr);
  for (const auto &seen : reading.events)
    if (seen.event.chunk.type == FVV_CHUNK_MESH) CHECK(seen.event.group_intact == 0);
  bad = memory.bytes;
  bad[size_t(at) + 33] ^=
      1; // its payload damaged: the next header is where it should be, the inner one is passed over
  const Reading other = read_stream(bad);
  CHECK(other.count(FVV_EVENT_DAMAGE) == 1);
  CHECK(other.events.size() == read_stream(memory.bytes).events.size());
}

TEST_CASE("random damage never crashes a reader and never passes as good") {
  const Bytes stream = small_stream(3, true, true);
  const auto truth = originals(stream);
  uint32_t state = 20260101;
  const auto random = [&](size_t n) { return size_t((state = state * 1664525 + 1013904223) >> 8) % n; };
  for (int round = 0; round < 3000; round++) {
    Bytes bad = stream;
    for (size_t i = 0, edits = 1 + random(6); i < edits; i++) {
      const size_t at = random(bad.size()), length = 1 + random(80);
      switch (random(4)) {
      case 0:
        bad[at] = uint8_t(random(256));
        break;
      case 1:
        bad.erase(bad.begin() + long(at), bad.begin() + long(std::min(bad.size(), at + length)));
        break;
      case 2:
        bad.insert(bad.begin() + long(at), length, uint8_t(random(256)));
        break;
      default: {
        const size_t from = random(bad.size());
        const Bytes part(bad.begin() + long(from), bad.begin() + long(std::min(bad.size(), from + length)));
        bad.insert(bad.begin() + long(at), part.begin(), part.end());
      }
      }
      if (bad.empty()) bad.push_back(0);
    }
    if (bad == stream) continue;
    const Reading reading = read_stream(bad, 1 + random(200));
    INFO("round " << round);
    CHECK_FALSE(reading.good());
    CHECK(silently_wrong(truth, reading) == 0);
  }
}
