// Streams made by somebody who means it: every CRC is right, what it covers is not.
#include "stream_fixture.h"

#include <algorithm>

namespace {

struct Random {
  uint32_t state;
  size_t operator()(size_t n) { return size_t((state = state * 1664525 + 1013904223) >> 8) % n; }
};

void spoil(Bytes &bytes, Random &random) {
  if (bytes.empty()) return;
  for (size_t i = 0, edits = 1 + random(3); i < edits; i++) {
    const uint8_t values[] = {0, 1, 0x7f, 0x80, 0xff, uint8_t(random(256))};
    bytes[random(bytes.size())] = values[random(6)];
  }
}

// Peak of live bytes, for fvv's allocator.
struct Peak {
  Memory memory;
  size_t peak = 0;
  static void *resize(void *user, void *pointer, size_t old_size, size_t new_size) {
    auto *self = static_cast<Peak *>(user);
    void *out = Memory::resize(&self->memory, pointer, old_size, new_size);
    self->peak = std::max(self->peak, self->memory.live);
    return out;
  }
  fvv_allocator allocator() { return {resize, this}; }
};

// Number of problems that the checker finds; -1: reading had to stop.
int64_t check(const Bytes &stream, const fvv_allocator &allocator) {
  fvv_checker *checker = nullptr;
  REQUIRE(fvv_checker_create(nullptr, nullptr, &allocator, &checker) == FVV_OK);
  fvv_status status = fvv_checker_push(checker, stream.data(), stream.size());
  if (status >= 0) status = fvv_checker_finish(checker);
  const int64_t problems = int64_t(fvv_checker_summary(checker)->problems);
  fvv_checker_destroy(checker);
  return status < 0 ? -1 : problems;
}

// Reads everything that random access can reach.
void read_all(const Bytes &stream, const fvv_allocator &allocator) {
  const Opened file(stream, &allocator);
  if (file.status < 0) return;
  fvv_stream *opened = file.stream;
  const size_t frames = std::min<size_t>(fvv_stream_frame_count(opened), 100);
  for (size_t f = 0; f < frames; f++) {
    fvv_frame frame;
    const fvv_configuration *configuration = nullptr;
    if (fvv_stream_frame(opened, f, &frame, nullptr) == FVV_OK)
      (void)!fvv_stream_configuration(opened, frame.group, &configuration, nullptr);
    fvv_mesh mesh;
    if (fvv_stream_mesh(opened, f, 1, &mesh, nullptr) == FVV_OK) fvv_mesh_free(&mesh);
    const uint8_t *sample = nullptr;
    size_t size = 0;
    int key = 0;
    (void)!fvv_stream_sample(opened, f, 2, &sample, &size, &key, nullptr);
  }
}

void sign(Bytes &stream, const Place &place) {
  uint8_t *header = stream.data() + place.offset;
  uint64_t size = 0;
  std::memcpy(&size, header + 16, sizeof size);
  const auto put = [](uint8_t *p, uint32_t v) { std::memcpy(p, &v, sizeof v); };
  if (size <= place.extent - 32) put(header + 24, fvv_crc32c(0, header + 32, size_t(size)));
  put(header + 28, fvv_crc32c(0, header, 28));
}

constexpr size_t most_memory = size_t(64) << 20;

} // namespace

TEST_CASE("payloads that are signed and wrong cost little and never crash a reader") {
  Random random = {7};
  size_t wrong = 0;
  for (int round = 0; round < 3000; round++) {
    Stream stream = good_stream(2);
    // SCEN and TRAK the writer itself would refuse.
    const bool configuration = random(2);
    std::vector<Chunk> &chunks = configuration ? stream.configuration : stream.groups[random(2)].chunks;
    const size_t first = configuration ? 3 : 0;
    spoil(chunks[first + random(chunks.size() - first)].payload, random);
    Bytes bytes = write(stream);
    Peak peak;
    INFO("round " << round);
    wrong += check(bytes, peak.allocator()) != 0;
    read_all(bytes, peak.allocator());
    CHECK(peak.memory.live == 0);
    CHECK(peak.peak <= most_memory);
  }
  CHECK(wrong > 1000);
}

TEST_CASE("a changed chunk with a new CRC is noticed, for every chunk") {
  const Bytes good = write(good_stream(3));
  const std::vector<Place> places = chunks_of(good);
  Random random = {11};
  for (int round = 0; round < 6000; round++) {
    const Place &place = places[random(places.size())];
    Bytes bad = good;
    uint8_t *chunk = bad.data() + place.offset;
    uint64_t size = 0;
    std::memcpy(&size, chunk + 16, sizeof size);
    // Half of the time the payload, else a field of the header but its payload CRC.
    if (random(2) && size)
      chunk[32 + random(size_t(size))] ^= uint8_t(1 + random(255));
    else
      chunk[random(24)] ^= uint8_t(1 + random(255));
    sign(bad, place);
    Peak peak;
    INFO("round " << round << ", chunk at " << place.offset);
    CHECK(check(bad, peak.allocator()) != 0);
    read_all(bad, peak.allocator());
    CHECK(peak.memory.live == 0);
    CHECK(peak.peak <= most_memory);
  }
}

TEST_CASE("a frame that does not decode is not decoded again for each frame after it") {
  Stream stream = good_stream(1);
  stream.groups[0] = {0, 2000, {mesh_chunk(0, 0)}};
  for (int frame = 1; frame < 1000; frame++) {
    Chunk chunk = mesh_chunk(frame, frame);
    chunk.flags = 0; // but it is a key mesh
    stream.groups[0].chunks.push_back(chunk);
  }
  struct Counted {
    Bytes bytes;
    size_t calls = 0;
    static fvv_status read(void *user, uint64_t offset, void *out, size_t size) {
      auto *self = static_cast<Counted *>(user);
      self->calls++;
      std::memcpy(out, self->bytes.data() + offset, size);
      return FVV_OK;
    }
  } counted = {write(stream)};
  const fvv_input input = {Counted::read, &counted, counted.bytes.size()};
  fvv_stream *opened = nullptr;
  REQUIRE(fvv_stream_open(&input, nullptr, nullptr, &opened, nullptr) == FVV_OK);
  REQUIRE(fvv_stream_frame_count(opened) == 1000);
  fvv_diagnostic first = {};
  for (size_t frame = 1; frame < 1000; frame++) {
    fvv_mesh mesh;
    fvv_diagnostic diagnostic = {};
    REQUIRE(fvv_stream_mesh(opened, frame, 1, &mesh, &diagnostic) == FVV_ERROR_INVALID);
    if (frame == 1) first = diagnostic;
    CHECK(diagnostic.offset == first.offset);
    CHECK(diagnostic.issue == first.issue);
  }
  CHECK(counted.calls < 100);
  fvv_mesh mesh;
  CHECK(fvv_stream_mesh(opened, 0, 1, &mesh, nullptr) == FVV_OK);
  fvv_mesh_free(&mesh);
  fvv_stream_close(opened);
}
