// Every allocation and every call for input or output fails once, and from then on, over whole streams:
// nothing leaks, the error says what failed, and what is returned all the same is right.
#include "../mesh/memory.h"
#include "fuzz.h"

#include "fvv/frames.h"
#include "fvv/stream.h"
#include "fvv_catch.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace {

namespace fs = std::filesystem;
using fuzz::Bytes;

constexpr size_t longest = 9000; // of a stream that is tried

struct File {
  std::string name;
  Bytes bytes;
};

// Valid streams of every kind, a few of each folder: each is read some hundred times.
std::vector<File> streams() {
  std::vector<File> out;
  std::vector<fs::path> paths;
  for (const fs::directory_entry &entry : fs::recursive_directory_iterator(FVV_CONFORMANCE))
    if (entry.path().extension() == ".fvv" && entry.file_size() <= longest) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  size_t cases = 0;
  for (const fs::path &path : paths) {
    const std::string name = fs::relative(path, FVV_CONFORMANCE).string();
    const bool is_case = name.rfind("cases/", 0) == 0;
    if (is_case && (name.rfind("cases/valid", 0) != 0 || cases++ % 2)) continue;
    std::ifstream file(path, std::ios::binary);
    out.push_back({name, Bytes(std::istreambuf_iterator<char>(file), {})});
  }
  return out;
}

// What was returned, without allocating while it is noted.
class Log {
public:
  Log() { entries_.reserve(20000); }
  void clear() { entries_.clear(); }
  // what: the place in the order of calls. data: of FVV_OK.
  void note(uint64_t what, fvv_status status, const void *data = nullptr, size_t size = 0) {
    const uint32_t crc = status == FVV_OK && size ? fvv_crc32c(0, data, size) : 0;
    if (entries_.size() < entries_.capacity()) entries_.push_back({what, status, crc});
  }
  // Every result is that of the truth, or the expected error.
  bool agrees(const Log &truth, fvv_status error, bool *failed) const {
    *failed = false;
    for (const Entry &entry : entries_) {
      const auto same = std::lower_bound(truth.entries_.begin(), truth.entries_.end(), entry.what,
                                         [](const Entry &a, uint64_t what) { return a.what < what; });
      if (entry.status == error) {
        *failed = true;
        continue;
      }
      if (same == truth.entries_.end() || same->what != entry.what || same->status != entry.status ||
          same->crc != entry.crc) {
        UNSCOPED_INFO("call " << entry.what << " returns " << entry.status);
        return false;
      }
    }
    return true;
  }

private:
  struct Entry {
    uint64_t what;
    fvv_status status;
    uint32_t crc;
  };
  std::vector<Entry> entries_; // by rising what
};

// ---- input that fails

struct Source {
  const Bytes *bytes;
  int64_t countdown; // calls until one fails; negative: none fails
  bool once;
  static fvv_status read_at(void *user, uint64_t offset, void *out, size_t size) {
    Source &self = *static_cast<Source *>(user);
    if (self.countdown == 0) {
      if (self.once) self.countdown = -1;
      return FVV_ERROR_IO;
    }
    if (self.countdown > 0) self.countdown--;
    std::memcpy(out, self.bytes->data() + offset, size);
    return FVV_OK;
  }
};

// ---- what is tried

void read_frame(fvv_stream *stream, size_t number, uint64_t what, Log &log) {
  fvv_frame frame;
  const fvv_configuration *configuration = nullptr;
  fvv_status status = fvv_stream_frame(stream, number, &frame, nullptr);
  log.note(what, status, &frame.time, sizeof frame.time);
  if (status != FVV_OK) return;
  status = fvv_stream_configuration(stream, frame.group, &configuration, nullptr);
  log.note(what + 1, status);
  if (status != FVV_OK) return;
  const size_t tracks = std::min<size_t>(configuration->track_count, 20),
               cameras = std::min<size_t>(configuration->camera_count, 20);
  for (size_t i = 0; i < tracks; i++) {
    const uint16_t track = configuration->tracks[i].id;
    const uint64_t place = what + 10 * (i + 1);
    fvv_mesh mesh;
    status = fvv_stream_mesh(stream, number, track, &mesh, nullptr);
    log.note(place, status, mesh.lattice, 12 * size_t(mesh.vertex_count));
    if (status == FVV_OK) fvv_mesh_free(&mesh);
    const uint8_t *bytes = nullptr;
    size_t size = 0;
    uint32_t vertices = 0;
    int key = 0;
    const fvv_tile *tiles = nullptr;
    const fvv_visibility *visibility = nullptr;
    const fvv_environment *environment = nullptr;
    status = fvv_stream_colours(stream, number, track, &bytes, &vertices, nullptr);
    log.note(place + 1, status, bytes, 3 * size_t(vertices));
    status = fvv_stream_sample(stream, number, track, &bytes, &size, &key, nullptr);
    log.note(place + 2, status, bytes, size);
    status = fvv_stream_tiles(stream, frame.group, track, &tiles, &size, nullptr);
    log.note(place + 3, status, tiles, size * sizeof *tiles);
    status = fvv_stream_visibility(stream, number, track, &visibility, nullptr);
    log.note(place + 4, status, status == FVV_OK ? visibility->states : nullptr,
             status == FVV_OK ? size_t(visibility->header.camera_count) * visibility->header.vertex_count
                              : 0);
    status = fvv_stream_environment(stream, frame.group, track, &environment, nullptr);
    log.note(place + 5, status);
    if (status == FVV_OK && environment->part_count) {
      status = fvv_environment_mesh(environment, 0, nullptr, &environment->allocator, &mesh, nullptr);
      log.note(place + 6, status, mesh.lattice, 12 * size_t(mesh.vertex_count));
      if (status == FVV_OK) fvv_mesh_free(&mesh);
    }
  }
  for (size_t i = 0; i < cameras; i++) {
    fvv_camera camera;
    status = fvv_stream_camera(stream, number, configuration->cameras[i].id, &camera, nullptr);
    log.note(what + 500 + i, status, camera.rotation, status == FVV_OK ? sizeof camera.rotation : 0);
  }
}

void read_all(const Bytes &bytes, Source source, const fvv_allocator *allocator, Log &log) {
  const fvv_input input = {Source::read_at, &source, bytes.size()};
  fvv_stream *stream = nullptr;
  const fvv_status status = fvv_stream_open(&input, nullptr, allocator, &stream, nullptr);
  log.note(0, status);
  if (status != FVV_OK) return;
  const size_t frames = fvv_stream_frame_count(stream);
  log.note(1, FVV_OK, &frames, sizeof frames);
  for (size_t i = 0; i < std::min<size_t>(frames, 6); i++) read_frame(stream, i, 1000 * (i + 1), log);
  fvv_stream_close(stream);
}

// The results of a checker count once: until the first error.
void check(const Bytes &bytes, const fvv_allocator *allocator, Log &log) {
  fvv_check_options options;
  fvv_check_options_default(&options);
  options.decode = 1;
  fvv_checker *checker = nullptr;
  fvv_status status = fvv_checker_create(&options, nullptr, allocator, &checker);
  log.note(0, status);
  if (status != FVV_OK) return;
  status = fvv_checker_push(checker, bytes.data(), bytes.size());
  log.note(1, status);
  if (status == FVV_OK) log.note(2, status = fvv_checker_finish(checker));
  const fvv_check_summary *summary = fvv_checker_summary(checker);
  const uint64_t numbers[] = {summary->problems, summary->frames, summary->whole_frames};
  if (status == FVV_OK) log.note(3, FVV_OK, numbers, sizeof numbers);
  fvv_checker_destroy(checker);
}

void push(const Bytes &bytes, const fvv_allocator *allocator, Log &log) {
  fvv_frames *frames = nullptr;
  fvv_status status = fvv_frames_create(nullptr, nullptr, allocator, &frames);
  log.note(0, status);
  if (status != FVV_OK) return;
  uint64_t what = 1;
  size_t at = 0;
  while (status >= 0 && status != FVV_END) {
    fvv_frames_event event;
    status = fvv_frames_next(frames, &event, nullptr);
    if (status == FVV_OK) {
      log.note(what, FVV_OK, &event.offset, sizeof event.offset);
      for (size_t i = 0; event.kind == FVV_FRAMES_FRAME && i < event.chunk_count; i++)
        log.note(++what, FVV_OK, event.chunks[i].payload, size_t(event.chunks[i].header.size));
    } else if (status == FVV_NEED_DATA && at < bytes.size()) {
      const size_t step = std::min<size_t>(bytes.size() - at, 500);
      const fvv_status pushed = fvv_frames_push(frames, bytes.data() + at, step);
      if (pushed != FVV_OK) log.note(what, status = pushed);
      at += step;
    } else if (status == FVV_NEED_DATA) {
      fvv_frames_finish(frames);
    } else {
      log.note(what, status);
    }
    what++;
  }
  fvv_frames_destroy(frames);
}

// ---- writing

struct Drain {
  Bytes bytes;
  int64_t countdown = -1; // calls until one fails; negative: none fails
  bool once = false;
  static fvv_status write(void *user, const void *data, size_t size) {
    Drain &self = *static_cast<Drain *>(user);
    if (self.countdown == 0) {
      if (self.once) self.countdown = -1;
      return FVV_ERROR_IO;
    }
    if (self.countdown > 0) self.countdown--;
    const uint8_t *from = static_cast<const uint8_t *>(data);
    self.bytes.insert(self.bytes.end(), from, from + size);
    return FVV_OK;
  }
};

struct Written {
  uint32_t type;
  uint8_t flags;
  uint16_t track;
  int64_t time, end;
  Bytes payload;
};

// The chunks of a valid stream, in order.
std::vector<Written> chunks_of(const Bytes &bytes) {
  std::vector<Written> out;
  for (size_t at = 24; at + 32 <= bytes.size();) {
    Written chunk = {};
    uint64_t size = 0;
    std::memcpy(&chunk.type, &bytes[at], 4);
    chunk.flags = bytes[at + 4];
    std::memcpy(&chunk.track, &bytes[at + 6], 2);
    std::memcpy(&chunk.time, &bytes[at + 8], 8);
    std::memcpy(&size, &bytes[at + 16], 8);
    chunk.payload.assign(bytes.begin() + long(at) + 32, bytes.begin() + long(at + 32 + size));
    if (chunk.type == FVV_CHUNK_GROUP) std::memcpy(&chunk.end, chunk.payload.data() + 16, 8);
    out.push_back(chunk);
    at += size_t(32 + (size + 7) / 8 * 8);
  }
  return out;
}

fvv_status write_chunk(fvv_writer *writer, const Written &chunk) {
  const uint8_t flags = chunk.flags & FVV_FLAG_KEY;
  switch (chunk.type) {
  case FVV_CHUNK_GROUP:
    return fvv_writer_begin_group(writer, chunk.time, chunk.end, nullptr);
  case FVV_CHUNK_GROUP_END:
    return fvv_writer_end_group(writer, nullptr);
  case FVV_CHUNK_INDEX:
    return FVV_OK;
  case FVV_CHUNK_FOOTER:
    return fvv_writer_finish(writer, nullptr);
  default:
    break;
  }
  return fvv_writer_chunk(writer, chunk.type, chunk.track, flags, chunk.time, chunk.payload.data(),
                          chunk.payload.size(), nullptr);
}

// Returns the first error; careless: and goes on after it.
fvv_status write_all(const std::vector<Written> &chunks, Drain &drain, const fvv_allocator *allocator,
                     bool careless) {
  const fvv_output output = {Drain::write, &drain};
  fvv_writer *writer = nullptr;
  fvv_status first = fvv_writer_create(&output, allocator, &writer, nullptr);
  if (first != FVV_OK) return first;
  bool in_group = false;
  for (const Written &chunk : chunks) {
    in_group |= chunk.type == FVV_CHUNK_GROUP;
    const bool block = !in_group && chunk.type != FVV_CHUNK_INDEX && chunk.type != FVV_CHUNK_FOOTER;
    const fvv_status status =
        block ? fvv_writer_configuration(writer, chunk.type, chunk.track,
                                         chunk.flags & uint8_t(~FVV_FLAG_CRITICAL), chunk.payload.data(),
                                         chunk.payload.size(), nullptr)
              : write_chunk(writer, chunk);
    in_group &= chunk.type != FVV_CHUNK_GROUP_END;
    if (first == FVV_OK) first = status;
    if (first != FVV_OK && !careless) break;
  }
  fvv_writer_destroy(writer);
  return first;
}

bool is_prefix(const Bytes &bytes, const Bytes &of) {
  return bytes.size() <= of.size() && std::equal(bytes.begin(), bytes.end(), of.begin());
}

// Calls attempt(n, once) for n = 0, 1, ... until it returns that nothing failed.
template <class Attempt> void for_each_failure(const Attempt &attempt) {
  for (const bool once : {false, true})
    for (int64_t n = 0;; n++) {
      REQUIRE(n < 100000);
      INFO("call " << n << (once ? " alone fails" : " and all after it fail"));
      if (!attempt(n, once)) break;
    }
}

} // namespace

TEST_CASE("every allocation fails while a stream is read", "[slow]") {
  Log truth, log;
  const fvv_allocator allocator = memory::allocator();
  for (const File &file : streams()) {
    INFO(file.name);
    const auto random_access = [&](Log &to) {
      read_all(file.bytes, {&file.bytes, -1, false}, &allocator, to);
    };
    const auto checking = [&](Log &to) { check(file.bytes, &allocator, to); };
    const auto pushing = [&](Log &to) { push(file.bytes, &allocator, to); };
    const auto try_all = [&](const auto &run) {
      truth.clear();
      run(truth);
      for_each_failure([&](int64_t n, bool once) {
        log.clear();
        const size_t before = memory::state.live;
        memory::reset(n, 0, once);
        run(log);
        const bool reached = once ? memory::state.countdown < 0 : memory::state.countdown == 0;
        const size_t after = memory::state.live;
        memory::reset();
        bool failed = false;
        REQUIRE(log.agrees(truth, FVV_ERROR_MEMORY, &failed));
        CHECK(after == before);
        // What is kept for later may fail to be kept without an error, but a run never fails without a
        // reason.
        CHECK((reached || !failed));
        return reached;
      });
    };
    try_all(random_access);
    try_all(checking);
    try_all(pushing);
  }
}

TEST_CASE("every read of the input fails") {
  Log truth, log;
  for (const File &file : streams()) {
    INFO(file.name);
    truth.clear();
    read_all(file.bytes, {&file.bytes, -1, false}, nullptr, truth);
    for_each_failure([&](int64_t n, bool once) {
      log.clear();
      read_all(file.bytes, {&file.bytes, n, once}, nullptr, log);
      bool failed = false;
      REQUIRE(log.agrees(truth, FVV_ERROR_IO, &failed));
      return failed;
    });
  }
}

TEST_CASE("every allocation and every write fails while a stream is written") {
  for (const File &file : streams()) {
    const std::vector<Written> chunks = chunks_of(file.bytes);
    Drain whole;
    whole.bytes.reserve(2 * longest);
    // Streams that the writer would write otherwise, such as joined ones, are left out.
    if (write_all(chunks, whole, nullptr, false) != FVV_OK || whole.bytes != file.bytes) continue;
    INFO(file.name);
    for_each_failure([&](int64_t n, bool once) {
      Drain drain;
      drain.countdown = n;
      drain.once = once;
      const fvv_status status = write_all(chunks, drain, nullptr, true);
      CHECK(is_prefix(drain.bytes, file.bytes));
      CHECK((status == FVV_ERROR_IO || drain.bytes == file.bytes));
      return status != FVV_OK;
    });
    const fvv_allocator allocator = memory::allocator();
    for_each_failure([&](int64_t n, bool once) {
      Drain drain;
      drain.bytes.reserve(2 * longest); // the drain's own memory does not fail
      const size_t before = memory::state.live;
      memory::reset(n, 0, once);
      const fvv_status status = write_all(chunks, drain, &allocator, false);
      const size_t after = memory::state.live;
      memory::reset();
      CHECK(after == before);
      CHECK(is_prefix(drain.bytes, file.bytes));
      CHECK((status == FVV_ERROR_MEMORY || drain.bytes == file.bytes));
      return status != FVV_OK;
    });
  }
}
