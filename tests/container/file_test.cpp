// Random access: through the index, and without it.
#include "container_fixture.h"

namespace {

struct MemoryInput {
  Bytes bytes;
  fvv_status answer = FVV_OK;
  static fvv_status read_at(void *user, uint64_t offset, void *out, size_t size) {
    auto *self = static_cast<MemoryInput *>(user);
    if (self->answer != FVV_OK) return self->answer;
    // Never called for bytes at or beyond the size.
    REQUIRE(offset <= self->bytes.size());
    REQUIRE(size <= self->bytes.size() - offset);
    memcpy(out, self->bytes.data() + offset, size);
    return FVV_OK;
  }
  fvv_input input() { return {read_at, this, bytes.size()}; }
};

struct Opened {
  MemoryInput memory;
  fvv_file *file = nullptr;
  fvv_diagnostic diagnostic{};
  fvv_status status;
  explicit Opened(Bytes bytes) : memory{std::move(bytes)} {
    const fvv_input input = memory.input();
    status = fvv_file_open(&input, nullptr, nullptr, &file, &diagnostic);
  }
  ~Opened() { fvv_file_close(file); }
  // Payloads of all frame chunks that can be read, in order of the file.
  std::vector<Bytes> payloads(size_t *unreadable = nullptr) {
    std::vector<Bytes> out;
    for (size_t g = 0; g < fvv_file_group_count(file); g++) {
      const fvv_chunk_info *chunks = nullptr;
      size_t count = 0;
      if (fvv_file_group_chunks(file, g, &chunks, &count, &diagnostic) != FVV_OK) {
        if (unreadable) ++*unreadable;
        continue;
      }
      for (size_t c = 0; c < count; c++) {
        const uint8_t *payload = nullptr;
        const fvv_status read = fvv_file_read_chunk(file, &chunks[c], &payload, &diagnostic);
        if (read == FVV_OK)
          out.emplace_back(payload, payload + chunks[c].size);
        else if (unreadable)
          ++*unreadable;
      }
    }
    return out;
  }
};

std::vector<Bytes> expected(int frames) {
  std::vector<Bytes> out;
  for (int f = 0; f < frames; f++) {
    out.push_back(pattern(24 + 3 * size_t(f), 7 + uint32_t(f)));
    out.push_back(pattern(40, 99 + uint32_t(f)));
  }
  return out;
}

} // namespace

TEST_CASE("every chunk is reached through the index") {
  Opened f(small_stream(3, true, true));
  REQUIRE(f.status == FVV_OK);
  CHECK(fvv_file_index_state(f.file) == FVV_INDEX_PRESENT);
  REQUIRE(fvv_file_group_count(f.file) == 3);
  const fvv_group_info *group = fvv_file_group(f.file, 1);
  CHECK(group->start == 2);
  CHECK(group->end == 4);
  CHECK(group->frame_count == 2);
  CHECK(group->sequence == 1);
  CHECK(group->intact == 1);
  CHECK(f.payloads() == expected(6));
  CHECK(fvv_file_damage_count(f.file) == 0);
  const fvv_chunk_info *chunks = nullptr;
  size_t count = 0;
  REQUIRE(fvv_file_configuration(f.file, 1, &chunks, &count, &f.diagnostic) == FVV_OK);
  REQUIRE(count == 4);
  CHECK(chunks[0].type == FVV_CHUNK_SCENE);
  CHECK(chunks[2].track == 2);
  CHECK(fvv_file_group(f.file, 3) == nullptr);
  CHECK(fvv_file_group_chunks(f.file, 3, &chunks, &count, &f.diagnostic) == FVV_ERROR_ARGUMENT);
}

TEST_CASE("a damaged configuration block is replaced by a repetition of it") {
  const Bytes stream = small_stream(3, true, true);
  const auto offsets = chunk_offsets(stream);
  int tried = 0;
  for (const size_t at : offsets) {
    const uint32_t type = fvv_get_u32(stream.data() + at);
    if (fvv_chunk_place(type, 0) != FVV_PLACE_CONFIGURATION) continue;
    Bytes bad = stream;
    bad[at + 33] ^= 4;
    for (const size_t cut : {size_t(0), size_t(4)}) {
      bad.resize(stream.size() - cut);
      Opened f(bad);
      REQUIRE(f.status == FVV_OK);
      INFO("chunk at " << at << ", cut " << cut);
      for (size_t g = 0; g < 3; g++) {
        const fvv_chunk_info *chunks = nullptr;
        size_t count = 0;
        CHECK(fvv_file_configuration(f.file, g, &chunks, &count, &f.diagnostic) == FVV_OK);
        CHECK(count == 4);
      }
      CHECK(f.payloads() == expected(6));
      tried++;
    }
  }
  CHECK(tried == 24);
  Bytes only = small_stream(3);
  only[chunk_offsets(only)[1] + 33] ^= 4;
  Opened f(only);
  REQUIRE(f.status == FVV_OK);
  const fvv_chunk_info *chunks = nullptr;
  size_t count = 0;
  CHECK(fvv_file_configuration(f.file, 1, &chunks, &count, &f.diagnostic) == FVV_ERROR_DAMAGED);
  CHECK(f.diagnostic.issue == FVV_ISSUE_GROUP_CONFIGURATION);
}

TEST_CASE("a live file has its index rebuilt") {
  Opened f(small_stream(3, false));
  REQUIRE(f.status == FVV_OK);
  CHECK(fvv_file_index_state(f.file) == FVV_INDEX_REBUILT);
  CHECK(fvv_file_damage_count(f.file) == 0);
  REQUIRE(fvv_file_group_count(f.file) == 3);
  CHECK(fvv_file_group(f.file, 2)->intact == 1);
  CHECK(fvv_file_group(f.file, 2)->frame_count == 2);
  CHECK(f.payloads() == expected(6));
}

TEST_CASE("a rebuilt index equals the one in the file") {
  const Bytes whole = small_stream(4, true, true);
  Bytes cut = whole;
  cut.resize(cut.size() - 8);
  Opened a(whole), b(cut);
  REQUIRE(a.status == FVV_OK);
  REQUIRE(b.status == FVV_OK);
  CHECK(fvv_file_index_state(b.file) == FVV_INDEX_REBUILT);
  REQUIRE(fvv_file_group_count(a.file) == fvv_file_group_count(b.file));
  for (size_t g = 0; g < 4; g++) {
    const auto *x = fvv_file_group(a.file, g), *y = fvv_file_group(b.file, g);
    CHECK(x->offset == y->offset);
    CHECK(x->size == y->size);
    CHECK(x->start == y->start);
    CHECK(x->end == y->end);
    CHECK(x->sequence == y->sequence);
    CHECK(x->frame_count == y->frame_count);
    CHECK(x->intact == y->intact);
    CHECK(x->configuration_offset == y->configuration_offset);
  }
}

TEST_CASE("no single flipped bit makes random access yield other bytes") {
  const Bytes stream = small_stream(2);
  const auto truth = expected(4);
  size_t full = 0;
  for (size_t bit = 0; bit < stream.size() * 8; bit += 3) {
    Bytes bad = stream;
    bad[bit / 8] ^= uint8_t(1 << bit % 8);
    Opened f(bad);
    if (f.status != FVV_OK) continue;
    size_t unreadable = 0;
    const auto payloads = f.payloads(&unreadable);
    INFO("bit " << bit % 8 << " of byte " << bit / 8);
    for (const auto &payload : payloads) CHECK(std::find(truth.begin(), truth.end(), payload) != truth.end());
    CHECK(payloads.size() + 1 >= truth.size()); // one bit costs one chunk at the most
    full += payloads.size() == truth.size();
  }
  CHECK(full > 0);
}

TEST_CASE("a stream that has lost every GRUP is listed by its index") {
  Bytes stream = small_stream(3);
  for (const size_t at : chunk_offsets(stream)) {
    const uint32_t type = fvv_get_u32(stream.data() + at);
    if (type == FVV_CHUNK_GROUP || type == FVV_CHUNK_FOOTER) stream[at + 1] ^= 0x10;
  }
  Opened f(stream);
  REQUIRE(f.status == FVV_OK);
  CHECK(fvv_file_index_state(f.file) == FVV_INDEX_REBUILT);
  REQUIRE(fvv_file_group_count(f.file) == 3);
  for (size_t g = 0; g < 3; g++) CHECK(!fvv_file_group(f.file, g)->intact);
}

TEST_CASE("a group whose GRUP or GEND is lost still gives its chunks") {
  const Bytes stream = small_stream(3);
  for (const size_t at : chunk_offsets(stream)) {
    const uint32_t type = fvv_get_u32(stream.data() + at);
    if (type != FVV_CHUNK_GROUP && type != FVV_CHUNK_GROUP_END) continue;
    for (const size_t cut : {size_t(0), size_t(4)}) { // with the index, and with the footer gone as well
      Bytes bad = stream;
      bad[at + 1] ^= 0x10;
      bad.resize(bad.size() - cut);
      Opened f(bad);
      INFO("chunk at " << at << ", cut " << cut);
      REQUIRE(f.status == FVV_OK);
      CHECK(fvv_file_index_state(f.file) == (cut ? FVV_INDEX_REBUILT : FVV_INDEX_PRESENT));
      CHECK(fvv_file_group_count(f.file) == 3);
      CHECK(f.payloads() == expected(6));
      CHECK(fvv_file_damage_count(f.file) >= 1);
      int intact = 0;
      for (size_t g = 0; g < 3; g++) intact += fvv_file_group(f.file, g)->intact;
      CHECK(intact == 2);
    }
  }
}

TEST_CASE("every truncation opens with the rest, or is reported as no stream") {
  const Bytes stream = small_stream(2);
  const auto truth = expected(4);
  for (size_t size = 0; size < stream.size(); size++) {
    Opened f(Bytes(stream.begin(), stream.begin() + long(size)));
    INFO("cut to " << size);
    CHECK((f.status == FVV_OK) == (size >= 24));
    if (f.status != FVV_OK) {
      CHECK(f.status == FVV_ERROR_TRUNCATED);
      continue;
    }
    CHECK(fvv_file_index_state(f.file) == FVV_INDEX_REBUILT);
    const auto payloads = f.payloads();
    REQUIRE(payloads.size() <= truth.size());
    for (size_t i = 0; i < payloads.size(); i++) CHECK(payloads[i] == truth[i]);
  }
}

TEST_CASE("an input that fails is an error, not damage") {
  Opened f(small_stream(2));
  REQUIRE(f.status == FVV_OK);
  f.memory.answer = FVV_ERROR_IO;
  const fvv_chunk_info *chunks = nullptr;
  size_t count = 0;
  CHECK(fvv_file_group_chunks(f.file, 0, &chunks, &count, &f.diagnostic) == FVV_ERROR_IO);
  MemoryInput failing{small_stream(1)};
  failing.answer = FVV_ERROR_IO;
  const fvv_input input = failing.input();
  fvv_file *file = nullptr;
  CHECK(fvv_file_open(&input, nullptr, nullptr, &file, &f.diagnostic) == FVV_ERROR_IO);
  CHECK(file == nullptr);
}

TEST_CASE("memory that runs out while opening is an error and no leak") {
  for (const bool finished : {true, false}) {
    MemoryInput memory{small_stream(2, finished)};
    bool completed = false;
    for (int budget = 0; !completed; budget++) {
      REQUIRE(budget < 1000);
      Budget state = {budget, 0};
      const fvv_allocator allocator = {Budget::resize, &state};
      const fvv_input input = memory.input();
      fvv_file *file = nullptr;
      fvv_status status = fvv_file_open(&input, nullptr, &allocator, &file, nullptr);
      const fvv_chunk_info *chunks = nullptr;
      size_t count = 0;
      if (status == FVV_OK) status = fvv_file_group_chunks(file, 0, &chunks, &count, nullptr);
      CHECK((status == FVV_OK || status == FVV_ERROR_MEMORY));
      completed = status == FVV_OK;
      fvv_file_close(file);
      CHECK(state.bytes == 0);
    }
  }
}
