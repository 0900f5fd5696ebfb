// Streams of real meshes and samples, put together chunk by chunk so that a test can spoil one of them, and a
// checker that has seen a whole stream.
#pragma once

#include "fvv/stream.h"
#include "fvv_catch.h"

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

using Bytes = std::vector<uint8_t>;

struct Chunk {
  uint32_t type;
  uint16_t track;
  uint8_t flags;
  int64_t time;
  Bytes payload;
};

struct Group {
  int64_t start, end;
  std::vector<Chunk> chunks;
};

struct Stream {
  std::vector<Chunk> configuration;
  std::vector<Group> groups;
  bool repeat = false; // the configuration again before every group
  bool finish = true;
};

template <class Encode> Bytes record(const Encode &encode) {
  size_t size = 0;
  (void)!encode(nullptr, 0, &size);
  Bytes out(size);
  REQUIRE(encode(out.data(), out.size(), &size) == FVV_OK);
  return out;
}

inline Chunk scene_chunk() {
  const fvv_scene scene = {{1, 25}, 2, {0, 0, 0}, 0.001, FVV_UP_Y, 0};
  return {FVV_CHUNK_SCENE, 0, 0, 0, record([&](uint8_t *out, size_t n, size_t *size) {
            return fvv_scene_encode(&scene, out, n, size, nullptr);
          })};
}
inline Chunk track_chunk(uint16_t id, uint8_t kind, fvv_rational time_base = {}) {
  fvv_track track = {};
  track.id = id;
  track.kind = kind;
  track.time_base = time_base;
  track.name = "name";
  track.name_size = 4;
  return {FVV_CHUNK_TRACK, id, 0, 0, record([&](uint8_t *out, size_t n, size_t *size) {
            return fvv_track_encode(&track, out, n, size, nullptr);
          })};
}
inline Chunk camera_chunk(const fvv_camera &camera) {
  return {FVV_CHUNK_CAMERA, 0, 0, 0, record([&](uint8_t *out, size_t n, size_t *size) {
            return fvv_camera_encode(&camera, out, n, size, nullptr);
          })};
}
inline Chunk camera_chunk(uint16_t id, uint32_t width = 32, uint32_t height = 16) {
  fvv_camera camera = {};
  camera.id = id;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 20;
  camera.cx = 16;
  camera.cy = 8;
  camera.r_max = 2;
  for (const int i : {0, 4, 8}) camera.rotation[i] = 1;
  return camera_chunk(camera);
}
inline Chunk video_chunk(uint16_t track, uint8_t shows = FVV_SHOWS_TILES) {
  fvv_video_config config = {};
  config.codec = FVV_CODEC_JPEG;
  config.width = 64;
  config.height = 16;
  config.shows = shows;
  config.bit_depth = 8;
  config.colour_primaries = 1;
  config.transfer_characteristics = 13;
  config.matrix_coefficients = 5;
  config.full_range = 1;
  return {FVV_CHUNK_VIDEO_CONFIG, track, 0, 0, record([&](uint8_t *out, size_t n, size_t *size) {
            return fvv_video_config_encode(&config, out, n, size, nullptr);
          })};
}
inline Chunk tiles_chunk(uint16_t track, const std::vector<fvv_tile> &tiles) {
  return {FVV_CHUNK_TILES, track, 0, 0, record([&](uint8_t *out, size_t n, size_t *size) {
            return fvv_tiles_encode(tiles.data(), tiles.size(), out, n, size, nullptr);
          })};
}
inline const std::vector<fvv_tile> two_tiles = {{0, {0, 0, 32, 16}, {0, 0, 32, 16}},
                                                {1, {0, 0, 32, 16}, {32, 0, 32, 16}}};
inline Chunk text_chunk(const std::string &text) {
  return {FVV_CHUNK_METADATA, 0, 0, 0, Bytes(text.begin(), text.end())};
}

// A tetrahedron, another size for each n; with texture bits it has texture coordinates, with normal bits
// normals.
inline Chunk mesh_chunk(int64_t time, int n, uint16_t track = 1, uint8_t texture_bits = 0,
                        uint8_t normal_bits = 0) {
  int32_t positions[12] = {0, 0, 0, 10 + n, 0, 0, 0, 20, 0, 0, 0, 30};
  uint32_t faces[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  uint32_t texture[8] = {0, 1, 1, 0, 1, 2, 2, 1};
  uint32_t normals[8] = {0, 1, 1, 0, 1, 2, 2, 1};
  const fvv_mesh mesh = {positions,
                         faces,
                         4,
                         4,
                         texture_bits ? texture : nullptr,
                         texture_bits,
                         normal_bits ? normals : nullptr,
                         normal_bits,
                         {}};
  fvv_bytes payload = {};
  REQUIRE(fvv_mesh_encode(&mesh, FVV_MESH_RAW, 0, nullptr, &payload, nullptr) == FVV_OK);
  Chunk out = {FVV_CHUNK_MESH, track, FVV_FLAG_KEY, time, Bytes(payload.data, payload.data + payload.size)};
  fvv_bytes_free(&payload);
  return out;
}
// As much of a JPEG file as can be checked without decoding; n is in a comment.
inline Chunk sample_chunk(int64_t time, int n, uint16_t track = 2) {
  return {FVV_CHUNK_VIDEO_PACKET, track, FVV_FLAG_KEY, time, {0xff,       0xd8, 0xff, 0xfe, 0,  3,
                                                              uint8_t(n), 0xff, 0xc0, 0,    11, 8,
                                                              0,          16,   0,    64,   1,  1,
                                                              0x11,       0,    0xff, 0xd9}};
}

// groups of 3 frames of 2 ticks with a mesh and a sample each; frame 1 of each group has no mesh, frame 2 no
// sample.
inline Stream good_stream(int groups = 3) {
  Stream out;
  out.configuration = {scene_chunk(),
                       track_chunk(1, FVV_TRACK_MESH),
                       track_chunk(2, FVV_TRACK_VIDEO),
                       camera_chunk(0),
                       camera_chunk(1),
                       video_chunk(2),
                       tiles_chunk(2, two_tiles),
                       text_chunk("{\"a\": 1}")};
  for (int g = 0; g < groups; g++) {
    Group group = {6 * g, 6 * g + 6, {}};
    for (int f = 0; f < 3; f++) {
      if (f != 1) group.chunks.push_back(mesh_chunk(6 * g + 2 * f, 3 * g + f));
      if (f != 2) group.chunks.push_back(sample_chunk(6 * g + 2 * f, 3 * g + f));
    }
    out.groups.push_back(group);
  }
  return out;
}

inline fvv_status append(void *user, const void *data, size_t size) {
  auto &out = *static_cast<Bytes *>(user);
  out.insert(out.end(), static_cast<const uint8_t *>(data), static_cast<const uint8_t *>(data) + size);
  return FVV_OK;
}

inline Bytes write(const Stream &stream) {
  Bytes bytes;
  const fvv_output output = {append, &bytes};
  fvv_writer *writer = nullptr;
  REQUIRE(fvv_writer_create(&output, nullptr, &writer, nullptr) == FVV_OK);
  for (const Chunk &chunk : stream.configuration)
    REQUIRE(fvv_writer_configuration(writer, chunk.type, chunk.track, chunk.flags, chunk.payload.data(),
                                     chunk.payload.size(), nullptr) == FVV_OK);
  for (const Group &group : stream.groups) {
    if (stream.repeat && group.start) REQUIRE(fvv_writer_repeat_configuration(writer, nullptr) == FVV_OK);
    REQUIRE(fvv_writer_begin_group(writer, group.start, group.end, nullptr) == FVV_OK);
    for (const Chunk &chunk : group.chunks)
      REQUIRE(fvv_writer_chunk(writer, chunk.type, chunk.track, chunk.flags, chunk.time, chunk.payload.data(),
                               chunk.payload.size(), nullptr) == FVV_OK);
    REQUIRE(fvv_writer_end_group(writer, nullptr) == FVV_OK);
  }
  if (stream.finish) REQUIRE(fvv_writer_finish(writer, nullptr) == FVV_OK);
  fvv_writer_destroy(writer);
  return bytes;
}

struct Place {
  size_t offset, extent; // header and padding included
  uint32_t type;
};
inline std::vector<Place> chunks_of(const Bytes &stream) {
  std::vector<Place> out;
  for (size_t at = 24; at < stream.size();) {
    uint32_t type;
    uint64_t size;
    std::memcpy(&type, stream.data() + at, sizeof type);
    std::memcpy(&size, stream.data() + at + 16, sizeof size);
    out.push_back({at, size_t((32 + size + 7) / 8 * 8), type});
    at += out.back().extent;
  }
  return out;
}

// Fails the n-th allocation and all after it; counts what is live.
struct Memory {
  int64_t left = INT64_MAX;
  size_t live = 0;
  static void *resize(void *user, void *pointer, size_t old_size, size_t new_size) {
    auto *self = static_cast<Memory *>(user);
    if (new_size && self->left-- <= 0) return nullptr;
    self->live += new_size;
    self->live -= old_size;
    if (new_size) return std::realloc(pointer, new_size);
    std::free(pointer);
    return nullptr;
  }
  fvv_allocator allocator() { return {resize, this}; }
};

// After a change of the format: tests that are tagged "[.][make]" write their vector again.
inline void write_vector(const char *path, const Bytes &bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char *>(bytes.data()), std::streamsize(bytes.size()));
  REQUIRE(file.good());
}

// What attempt does with an allocator that fails from the n-th allocation on leaves nothing allocated.
template <class Attempt> void with_failing_memory(int64_t n, const Attempt &attempt) {
  Memory memory;
  memory.left = n;
  const fvv_allocator allocator = memory.allocator();
  attempt(&allocator);
  CHECK(memory.live == 0);
}

// A stream of these bytes, or why there is none.
struct Opened {
  Bytes bytes;
  fvv_stream *stream = nullptr;
  fvv_diagnostic diagnostic = {};
  fvv_status status;

  static fvv_status read(void *user, uint64_t offset, void *out, size_t size) {
    const Bytes &from = *static_cast<Bytes *>(user);
    REQUIRE(offset + size <= from.size());
    std::memcpy(out, from.data() + offset, size);
    return FVV_OK;
  }
  explicit Opened(Bytes given, const fvv_allocator *allocator = nullptr, const fvv_limits *limits = nullptr)
      : bytes(std::move(given)) {
    const fvv_input input = {read, &bytes, bytes.size()};
    status = fvv_stream_open(&input, limits, allocator, &stream, &diagnostic);
  }
  Opened(const Opened &) = delete;
  ~Opened() { fvv_stream_close(stream); }
};

// ---- A checker that has seen a whole stream, and its report.

struct Check {
  const fvv_limits *limits = nullptr;
  const fvv_allocator *allocator = nullptr;
  size_t step = 0; // bytes pushed at a time, 0: all
  bool decode = true;
};

// A checker that has seen all bytes.
class Checked {
public:
  explicit Checked(const Bytes &bytes, const Check &how = {}) {
    fvv_check_options options;
    fvv_check_options_default(&options);
    options.decode = how.decode;
    status = fvv_checker_create(&options, how.limits, how.allocator, &checker);
    if (status < 0) return;
    for (size_t at = 0; at < bytes.size();) {
      const size_t n = how.step && how.step < bytes.size() - at ? how.step : bytes.size() - at;
      // A block of exactly this size lets a sanitizer see any read beyond it.
      const Bytes part(bytes.begin() + std::ptrdiff_t(at), bytes.begin() + std::ptrdiff_t(at + n));
      const fvv_status pushed = fvv_checker_push(checker, part.data(), n);
      if (status >= 0) status = pushed;
      at += n;
    }
    const fvv_status finished = fvv_checker_finish(checker);
    if (status >= 0) status = finished;
  }
  Checked(const Checked &) = delete;
  ~Checked() { fvv_checker_destroy(checker); }
  const fvv_check_summary &summary() const { return *fvv_checker_summary(checker); }
  size_t problem_count() const { return fvv_checker_problem_count(checker); }
  const fvv_diagnostic &problem(size_t i) const { return *fvv_checker_problem(checker, i); }

  // Everything that it reports.
  std::string report() const {
    std::ostringstream out;
    const fvv_check_summary &s = summary();
    out << status << ' ' << s.bytes << ' ' << s.chunks << ' ' << s.groups << ' ' << s.frames << ' '
        << s.whole_frames << ' ' << s.payload_bytes << ' ' << s.problems << ' ' << s.start << ' ' << s.end
        << ' ' << s.written_major << '.' << s.written_minor << ' ' << s.configurations << ' ' << s.has_footer
        << ' ' << s.truncated << '\n';
    for (size_t i = 0; i < fvv_checker_problem_count(checker); i++) {
      char line[512];
      fvv_diagnostic_format(fvv_checker_problem(checker, i), "in", line, sizeof line);
      out << line << '\n';
    }
    for (size_t i = 0; i < fvv_checker_track_count(checker); i++) {
      const fvv_track_summary &t = *fvv_checker_track(checker, i);
      out << t.track << ' ' << int(t.kind) << ' ' << t.chunks << ' ' << t.key_chunks << ' ' << t.bytes << ' '
          << t.smallest << ' ' << t.largest << ' ' << t.min_vertices << ' ' << t.max_vertices << ' '
          << t.min_faces << ' ' << t.max_faces << ' ' << t.vertices << ' ' << t.faces << ' ' << t.textured
          << ' ' << int(t.min_texture_bits) << ' ' << int(t.max_texture_bits) << ' ' << t.with_normals << ' '
          << int(t.min_normal_bits) << ' ' << int(t.max_normal_bits) << ' ' << t.layouts << ' '
          << t.least_tile_pixels << ' ' << t.most_tile_pixels << '\n';
    }
    for (size_t i = 0; i < fvv_checker_run_count(checker); i++) {
      const fvv_frame_run &r = *fvv_checker_run(checker, i);
      out << r.first << '+' << r.count << ' ' << r.first_time << ".." << r.last_time << '\n';
    }
    return out.str();
  }

  fvv_checker *checker = nullptr;
  fvv_status status;
};

// Checks that a checker that decodes finds the issue, and one that does not if without_decoding.
inline void check_finds(const Bytes &bytes, uint32_t issue, bool without_decoding) {
  for (const bool decode : {true, false}) {
    Check how;
    how.decode = decode;
    const Checked checked(bytes, how);
    INFO(checked.report());
    bool found = false;
    for (size_t i = 0; i < checked.problem_count(); i++) found |= checked.problem(i).issue == issue;
    CHECK(found == (decode || without_decoding));
  }
}

// The times of whole frames, 2 ticks apart.
inline std::vector<int64_t> whole_times(const Checked &checked) {
  std::vector<int64_t> out;
  uint64_t count = 0;
  for (size_t i = 0; i < fvv_checker_run_count(checked.checker); i++) {
    const fvv_frame_run *run = fvv_checker_run(checked.checker, i);
    CHECK(run->last_time - run->first_time == 2 * int64_t(run->count - 1));
    for (uint64_t f = 0; f < run->count; f++) out.push_back(run->first_time + 2 * int64_t(f));
    count += run->count;
  }
  CHECK(count == checked.summary().whole_frames);
  CHECK(!fvv_checker_run(checked.checker, fvv_checker_run_count(checked.checker)));
  return out;
}

inline bool has_problem(const Checked &checked, uint32_t issue, uint64_t offset) {
  for (size_t i = 0; i < fvv_checker_problem_count(checked.checker); i++) {
    const fvv_diagnostic *problem = fvv_checker_problem(checked.checker, i);
    if (problem->issue == issue && problem->offset == offset) return true;
  }
  return false;
}
