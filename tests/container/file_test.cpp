// Random access: through the index, and without it.
#include "container_fixture.h"

extern "C" {
#include "container/file.h"
}

#include <algorithm>

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

TEST_CASE("bytes after the footer are not read, however many there are") {
  // A stream, and zeros up to size.
  struct Sparse {
    Bytes stream;
    uint64_t size, read = 0;
    static fvv_status read_at(void *user, uint64_t offset, void *out, size_t count) {
      auto *self = static_cast<Sparse *>(user);
      REQUIRE(offset + count <= self->size);
      self->read += count;
      for (size_t i = 0; i < count; i++)
        static_cast<uint8_t *>(out)[i] = offset + i < self->stream.size() ? self->stream[offset + i] : 0;
      return FVV_OK;
    }
  };
  for (const bool damaged : {false, true})
    for (const uint64_t more :
         {uint64_t(1), uint64_t(8), uint64_t(65'000), uint64_t(66'000), uint64_t(64) << 30}) {
      INFO(more << " bytes follow, the first frame is damaged: " << damaged);
      Sparse sparse = {small_stream(3, true, true), 0};
      const size_t end = sparse.stream.size();
      sparse.size = end + more;
      if (damaged) sparse.stream[chunk_offsets(sparse.stream)[6] + 33] ^= 4;
      const fvv_input input = {Sparse::read_at, &sparse, sparse.size};
      fvv_file *file = nullptr;
      fvv_diagnostic diagnostic = {};
      REQUIRE(fvv_file_open(&input, nullptr, nullptr, &file, &diagnostic) == FVV_OK);
      CHECK(sparse.read < 3 * 65536 + (1 << 18) + 2 * end);
      CHECK(fvv_file_index_state(file) == FVV_INDEX_PRESENT);
      CHECK(fvv_file_group_count(file) == 3);
      REQUIRE(fvv_file_damage_count(file) == 1);
      CHECK(fvv_file_damage(file, 0)->issue == FVV_ISSUE_TRAILING);
      CHECK(fvv_file_damage(file, 0)->offset == end);
      fvv_file_close(file);
    }
  // The index of a second stream is no part of the first, and one that is lost is rebuilt up to the footer.
  const Bytes stream = small_stream(2);
  Opened joined(join({stream, small_stream(3)}));
  CHECK(joined.payloads() == expected(4));
  Bytes lost = join({stream, Bytes(100'000)});
  lost[lost.size() - 100'000 - 56 - 8] ^= 4; // of INDX
  Opened rebuilt(lost);
  CHECK(fvv_file_index_state(rebuilt.file) == FVV_INDEX_REBUILT);
  CHECK(rebuilt.payloads() == expected(4));
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

TEST_CASE("groups that moved are listed once, although the index has them elsewhere") {
  const Bytes stream = small_stream(3);
  std::vector<size_t> groups;
  for (const size_t at : chunk_offsets(stream))
    if (fvv_get_u32(stream.data() + at) == FVV_CHUNK_GROUP) groups.push_back(at);
  REQUIRE(groups.size() == 3);
  for (const size_t at : groups) {
    // The block that holds for the group, once more before it.
    Bytes longer = stream;
    const Bytes block(stream.begin() + FVV_FILE_HEADER_SIZE, stream.begin() + long(groups[0]));
    longer.insert(longer.begin() + long(at), block.begin(), block.end());
    Opened f(longer);
    INFO("group at " << at);
    REQUIRE(f.status == FVV_OK);
    CHECK(fvv_file_index_state(f.file) == FVV_INDEX_REBUILT);
    REQUIRE(fvv_file_group_count(f.file) == 3);
    for (size_t g = 0; g < 3; g++) {
      CHECK(fvv_file_group(f.file, g)->intact == 1);
      CHECK(fvv_file_group(f.file, g)->frame_count == 2);
    }
    CHECK(f.payloads() == expected(6));
  }
}

TEST_CASE("groups that changed places give no chunks by the entries of each other") {
  const Bytes stream = small_stream(3);
  std::vector<size_t> groups;
  for (const size_t at : chunk_offsets(stream)) {
    const uint32_t type = fvv_get_u32(stream.data() + at);
    if (type == FVV_CHUNK_GROUP || type == FVV_CHUNK_INDEX) groups.push_back(at);
  }
  REQUIRE(groups.size() == 4);
  // The second group is the longer one: its first bytes would pass for a whole group.
  Bytes exchanged = stream;
  std::rotate(exchanged.begin() + long(groups[0]), exchanged.begin() + long(groups[1]),
              exchanged.begin() + long(groups[2]));
  REQUIRE(groups[2] - groups[1] > groups[1] - groups[0]);
  Opened f(exchanged);
  REQUIRE(f.status == FVV_OK);
  CHECK(fvv_file_index_state(f.file) == FVV_INDEX_PRESENT);
  const std::vector<Bytes> all = expected(6);
  CHECK(f.payloads() == std::vector<Bytes>(all.begin() + 8, all.end()));
  REQUIRE(fvv_file_damage_count(f.file) == 2);
  CHECK(fvv_file_damage(f.file, 0)->issue == FVV_ISSUE_INDEX);
  CHECK(fvv_file_group(f.file, 0)->intact == 0);
  CHECK(fvv_file_group(f.file, 2)->intact == 1);
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

namespace {

// A file of groups of one second and 1 MiB each, of which only what is read exists.
struct LongStream {
  static constexpr uint64_t group_size = 1 << 20;
  uint64_t groups, index_offset, size;
  Bytes head, end; // file header and configuration; index, footer
  uint32_t digest;
  std::vector<uint64_t> asked; // sizes of reads

  explicit LongStream(uint64_t count) : groups(count) {
    const Bytes stream = small_stream(1);
    for (const size_t at : chunk_offsets(stream))
      if (fvv_get_u32(stream.data() + at) == FVV_CHUNK_GROUP) {
        head.assign(stream.begin(), stream.begin() + long(at));
        digest = fvv_get_u32(stream.data() + at + 32 + 4);
      }
    index_offset = head.size() + groups * group_size;
    Bytes index(8 + 16 + 52 * size_t(groups));
    fvv_put_u32(index.data(), uint32_t(groups));
    fvv_put_u32(index.data() + 4, 1);
    fvv_put_u64(index.data() + 8, 24);
    fvv_put_u32(index.data() + 16, uint32_t(head.size() - 24));
    fvv_put_u32(index.data() + 20, digest);
    for (uint64_t g = 0; g < groups; g++) {
      uint8_t *entry = index.data() + 24 + 52 * size_t(g);
      fvv_put_u64(entry, head.size() + g * group_size);
      fvv_put_u64(entry + 8, group_size);
      fvv_put_i64(entry + 16, int64_t(25 * g));
      fvv_put_i64(entry + 24, int64_t(25 * g + 25));
      fvv_put_u32(entry + 32, uint32_t(g));
      fvv_put_u32(entry + 36, 25);
      fvv_put_u32(entry + 44, 56);
    }
    Bytes foot(24);
    fvv_put_u64(foot.data(), index_offset);
    fvv_put_u32(foot.data() + 16, fvv_crc32c(0, index.data(), index.size()));
    end = hand_chunk("INDX", 0, 0, 0, 0, index);
    size = index_offset + end.size() + 56;
    fvv_put_u64(foot.data() + 8, size);
    const Bytes footer = hand_chunk("FOOT", 1, 1, 0, 0, foot);
    end.insert(end.end(), footer.begin(), footer.end());
  }
  static fvv_status read_at(void *user, uint64_t offset, void *out, size_t size) {
    auto *self = static_cast<LongStream *>(user);
    self->asked.push_back(size);
    const Bytes &from = offset < self->index_offset ? self->head : self->end;
    const uint64_t at = offset < self->index_offset ? offset : offset - self->index_offset;
    REQUIRE(at + size <= from.size());
    memcpy(out, from.data() + at, size);
    return FVV_OK;
  }
  fvv_input input() { return {read_at, this, size}; }
};

} // namespace

TEST_CASE("an index of 30 days of groups of one second is read within the default limits", "[slow]") {
  LongStream stream(30 * 24 * 3600);
  REQUIRE(stream.groups == 2592000);
  const fvv_input input = stream.input();
  Budget budget{1 << 30, 0};
  const fvv_allocator allocator = {Budget::resize, &budget};
  fvv_file *file = nullptr;
  fvv_diagnostic diagnostic;
  REQUIRE(fvv_file_open(&input, nullptr, &allocator, &file, &diagnostic) == FVV_OK);
  CHECK(fvv_file_index_state(file) == FVV_INDEX_PRESENT);
  REQUIRE(fvv_file_group_count(file) == stream.groups);
  const fvv_group_info &last = *fvv_file_group(file, stream.groups - 1);
  CHECK((last.sequence == stream.groups - 1 && last.end == int64_t(25 * stream.groups)));
  CHECK((last.offset + last.size == stream.index_offset && last.configuration_offset == 24));
  CHECK(last.configuration_size == stream.head.size() - 24);
  // What stays: 64 bytes of each entry and a pointer to its table.
  CHECK(budget.bytes < long(73 * stream.groups));
  const fvv_chunk_info *chunks = nullptr;
  size_t count = 0;
  CHECK(fvv_file_configuration(file, stream.groups - 1, &chunks, &count, &diagnostic) == FVV_OK);
  CHECK(count == 4);
  fvv_file_close(file);
  CHECK(budget.bytes == 0);
}

TEST_CASE("an index beyond the limit is refused before its bytes are read") {
  LongStream stream(1000);
  const fvv_input input = stream.input();
  fvv_limits limits;
  fvv_limits_default(&limits);
  fvv_file *file = nullptr;
  fvv_diagnostic diagnostic;
  // The index may be larger than other payloads.
  limits.max_payload = 1000;
  REQUIRE(fvv_file_open(&input, &limits, nullptr, &file, &diagnostic) == FVV_OK);
  fvv_file_close(file);
  limits.max_groups = 500;
  stream.asked.clear();
  CHECK(fvv_file_open(&input, &limits, nullptr, &file, &diagnostic) == FVV_ERROR_LIMIT);
  CHECK(diagnostic.issue == FVV_ISSUE_LIMIT);
  for (const uint64_t size : stream.asked) CHECK(size <= 100);
}

TEST_CASE("of many repetitions of a damaged block the nearest intact one is found through the index") {
  const Bytes stream = small_stream(60, true, true);
  Bytes bad = stream;
  std::vector<size_t> scenes;
  for (const size_t at : chunk_offsets(stream))
    if (fvv_get_u32(stream.data() + at) == FVV_CHUNK_SCENE) scenes.push_back(at);
  REQUIRE(scenes.size() == 60);
  for (size_t i = 5; i < 50; i++) bad[scenes[i] + 40] ^= 1;
  Opened f(bad);
  REQUIRE(f.status == FVV_OK);
  const fvv_chunk_info *chunks = nullptr;
  size_t count = 0;
  CHECK(fvv_file_configuration(f.file, 8, &chunks, &count, &f.diagnostic) == FVV_OK);
  CHECK((count == 4 && chunks[0].offset == scenes[4]));
  CHECK(fvv_file_configuration(f.file, 46, &chunks, &count, &f.diagnostic) == FVV_OK);
  CHECK(chunks[0].offset == scenes[50]);
  // The damage is listed, once for each block.
  CHECK(fvv_file_damage_count(f.file) == 2);
  CHECK(fvv_file_configuration(f.file, 46, &chunks, &count, &f.diagnostic) == FVV_OK);
  CHECK(fvv_file_damage_count(f.file) == 2);
  // A failing input is no damage.
  Opened g(bad);
  REQUIRE(fvv_file_configuration(g.file, 8, &chunks, &count, &g.diagnostic) == FVV_OK);
  g.memory.answer = FVV_ERROR_IO;
  CHECK(fvv_file_configuration(g.file, 46, &chunks, &count, &g.diagnostic) == FVV_ERROR_IO);
}
