// A small stream in memory, chunks put together by hand, and what a reader reports for bytes: shared by the
// tests here.
#pragma once

#include "fvv_catch.h"

extern "C" {
#include "base/bytes.h"
#include "container/header.h"
#include "fvv/container.h"
}

#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

using Bytes = std::vector<uint8_t>;

// An allocator that returns NULL from the n-th growing call on, and counts allocated bytes.
struct Budget {
  int left;
  long bytes;
  static void *resize(void *user, void *pointer, size_t old_size, size_t new_size) {
    auto *self = static_cast<Budget *>(user);
    if (new_size > old_size && self->left-- <= 0) return nullptr;
    self->bytes += long(new_size) - long(old_size);
    if (new_size) return realloc(pointer, new_size);
    free(pointer);
    return nullptr;
  }
};

struct MemoryOutput {
  Bytes bytes;
  static fvv_status write(void *user, const void *data, size_t size) {
    auto *self = static_cast<MemoryOutput *>(user);
    const auto *p = static_cast<const uint8_t *>(data);
    self->bytes.insert(self->bytes.end(), p, p + size);
    return FVV_OK;
  }
  fvv_output output() { return {write, this}; }
};

inline Bytes scene_payload() {
  fvv_scene scene = {{1, 25}, 1, {0.5, -1.0, 2.0}, 0.002, FVV_UP_Y, 0};
  Bytes out(FVV_SCEN_SIZE);
  size_t written = 0;
  REQUIRE(fvv_scene_encode(&scene, out.data(), out.size(), &written, nullptr) == FVV_OK);
  return out;
}

inline Bytes track_payload(uint8_t kind, const std::string &name) {
  fvv_track track = {};
  track.id = 1;
  track.kind = kind;
  track.name = name.data();
  track.name_size = name.size();
  Bytes out(FVV_TRAK_SIZE + name.size());
  size_t written = 0;
  REQUIRE(fvv_track_encode(&track, out.data(), out.size(), &written, nullptr) == FVV_OK);
  return out;
}

inline Bytes pattern(size_t size, uint32_t seed) {
  Bytes out(size);
  for (auto &b : out) b = uint8_t((seed = seed * 1664525 + 1013904223) >> 24);
  return out;
}

// Two tracks, groups of two frames each; payload sizes that need padding and such that do not.
inline Bytes small_stream(int groups = 2, bool finish = true, bool repeat = false) {
  MemoryOutput memory;
  const fvv_output output = memory.output();
  fvv_writer *writer = nullptr;
  fvv_diagnostic d;
  REQUIRE(fvv_writer_create(&output, nullptr, &writer, &d) == FVV_OK);
  const Bytes scene = scene_payload(), mesh = track_payload(FVV_TRACK_MESH, "mesh"),
              video = track_payload(FVV_TRACK_VIDEO, "all cameras");
  REQUIRE(fvv_writer_configuration(writer, FVV_CHUNK_SCENE, 0, 0, scene.data(), scene.size(), &d) == FVV_OK);
  REQUIRE(fvv_writer_configuration(writer, FVV_CHUNK_TRACK, 1, 0, mesh.data(), mesh.size(), &d) == FVV_OK);
  REQUIRE(fvv_writer_configuration(writer, FVV_CHUNK_TRACK, 2, 0, video.data(), video.size(), &d) == FVV_OK);
  REQUIRE(fvv_writer_configuration(writer, FVV_CHUNK_METADATA, 0, 0, "{}", 2, &d) == FVV_OK);
  for (int g = 0; g < groups; g++) {
    if (repeat && g) REQUIRE(fvv_writer_repeat_configuration(writer, &d) == FVV_OK);
    REQUIRE(fvv_writer_begin_group(writer, 2 * g, 2 * g + 2, &d) == FVV_OK);
    for (int f = 2 * g; f < 2 * g + 2; f++) {
      const Bytes m = pattern(24 + 3 * size_t(f), 7 + uint32_t(f)), v = pattern(40, 99 + uint32_t(f));
      REQUIRE(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 1, FVV_FLAG_KEY, f, m.data(), m.size(), &d) == FVV_OK);
      const uint8_t key = f % 2 ? 0 : FVV_FLAG_KEY;
      REQUIRE(fvv_writer_chunk(writer, FVV_CHUNK_VIDEO_PACKET, 2, key, f, v.data(), v.size(), &d) == FVV_OK);
    }
    REQUIRE(fvv_writer_end_group(writer, &d) == FVV_OK);
  }
  if (finish) REQUIRE(fvv_writer_finish(writer, &d) == FVV_OK);
  CHECK(fvv_writer_position(writer) == memory.bytes.size());
  fvv_writer_destroy(writer);
  return memory.bytes;
}

struct Seen {
  fvv_event event;
  Bytes payload;
  bool operator==(const Seen &other) const {
    const auto &a = event, &b = other.event;
    return a.kind == b.kind && a.offset == b.offset && a.chunk.type == b.chunk.type &&
           a.skipped == b.skipped && a.has_chunk == b.has_chunk && a.group_intact == b.group_intact &&
           a.diagnostic.issue == b.diagnostic.issue && a.diagnostic.offset == b.diagnostic.offset &&
           std::string(a.diagnostic.message) == b.diagnostic.message && payload == other.payload;
  }
};

struct Reading {
  std::vector<Seen> events;
  fvv_status status = FVV_OK; // FVV_END or the final error
  fvv_diagnostic diagnostic{};

  size_t count(fvv_event_kind kind) const {
    size_t n = 0;
    for (const auto &seen : events) n += seen.event.kind == kind;
    return n;
  }
  const fvv_diagnostic *first_problem() const {
    for (const auto &seen : events)
      if (seen.event.kind == FVV_EVENT_DAMAGE) return &seen.event.diagnostic;
    return status < 0 ? &diagnostic : nullptr;
  }
  // What a checking tool calls good: nothing wrong, and the footer was seen.
  bool good() const { return !first_problem() && count(FVV_EVENT_END) == 1; }
};

inline Reading read_stream(const uint8_t *bytes, size_t size, size_t step = 0, uint64_t start = 0,
                           const fvv_limits *limits = nullptr) {
  Reading reading;
  fvv_reader *reader = nullptr;
  REQUIRE(fvv_reader_create(limits, nullptr, start, &reader) == FVV_OK);
  size_t at = 0;
  for (;;) {
    Seen seen{};
    reading.status = fvv_reader_next(reader, &seen.event, &reading.diagnostic);
    if (reading.status == FVV_NEED_DATA) {
      if (at == size) {
        fvv_reader_finish(reader);
        continue;
      }
      const size_t n = step && step < size - at ? step : size - at;
      // A block of exactly this size lets a sanitizer see any read beyond it.
      const Bytes part(bytes + at, bytes + at + n);
      REQUIRE(fvv_reader_push(reader, part.data(), n) == FVV_OK);
      at += n;
      continue;
    }
    if (reading.status != FVV_OK) break;
    if (seen.event.kind == FVV_EVENT_CHUNK) {
      CHECK((reinterpret_cast<uintptr_t>(seen.event.payload) & 7) == 0);
      seen.payload.assign(seen.event.payload, seen.event.payload + seen.event.chunk.size);
    }
    seen.event.payload = nullptr;
    reading.events.push_back(seen);
    REQUIRE(reading.events.size() < 100000);
  }
  fvv_reader_destroy(reader);
  return reading;
}

inline Reading read_stream(const Bytes &bytes, size_t step = 0, const fvv_limits *limits = nullptr) {
  return read_stream(bytes.data(), bytes.size(), step, 0, limits);
}

// One chunk as the specification has it, written without the library's writer.
inline Bytes hand_chunk(const char *type, uint8_t flags, uint8_t counter, uint16_t track, int64_t time,
                        const Bytes &payload) {
  Bytes out(32);
  memcpy(out.data(), type, 4);
  out[4] = flags;
  out[5] = counter;
  fvv_put_u16(out.data() + 6, track);
  fvv_put_i64(out.data() + 8, time);
  fvv_put_u64(out.data() + 16, payload.size());
  fvv_put_u32(out.data() + 24, fvv_crc32c(0, payload.data(), payload.size()));
  fvv_put_u32(out.data() + 28, fvv_crc32c(0, out.data(), 28));
  out.insert(out.end(), payload.begin(), payload.end());
  out.resize((out.size() + 7) / 8 * 8);
  return out;
}

inline Bytes hand_file_header(uint16_t reader_major = 0, uint16_t reader_minor = 2, uint32_t reserved = 0) {
  Bytes out = {0x89, 'F', 'V', 'V', '\r', '\n', 0x1a, '\n'};
  out.resize(24);
  fvv_put_u16(out.data() + 10, 2);
  fvv_put_u16(out.data() + 12, reader_major);
  fvv_put_u16(out.data() + 14, reader_minor);
  fvv_put_u32(out.data() + 16, reserved);
  fvv_put_u32(out.data() + 20, fvv_crc32c(0, out.data(), 20));
  return out;
}

inline Bytes join(std::initializer_list<Bytes> parts) {
  Bytes out;
  for (const auto &part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

// Offsets of all chunk headers of a good stream.
inline std::vector<size_t> chunk_offsets(const Bytes &stream) {
  std::vector<size_t> out;
  for (size_t at = 24; at < stream.size();) {
    out.push_back(at);
    at += size_t(fvv_chunk_extent(fvv_get_u64(stream.data() + at + 16)));
  }
  return out;
}
