// A small capture with a ladder, and the chunks of a stream.
#pragma once

#include "../mux_fixture.h"

#include "fvv_cxx/rung.h"
#include "fvv_mux/segments.h"

#include <map>

inline FileOptions three_rungs(const Folder &folder, Shape shape = {}) {
  make_capture(folder, shape);
  FileOptions options = options_for(folder);
  options.quality = {false, 20};
  options.ladder = {{1}, {0.5}, {0.25}};
  options.verify = true;
  return options;
}

struct Chunk {
  uint32_t type;
  uint16_t track;
  int64_t time;
  std::string payload;

  bool operator==(const Chunk &other) const {
    return type == other.type && track == other.track && time == other.time && payload == other.payload;
  }
};

// Every chunk; damage is a failure. numbers: of the groups.
inline std::vector<Chunk> chunks_of(const std::string &bytes, bool joins,
                                    std::vector<uint32_t> *numbers = nullptr) {
  fvv_reader *reader = nullptr;
  REQUIRE(fvv_reader_create(nullptr, nullptr, 0, &reader) == FVV_OK);
  if (joins) REQUIRE(fvv_reader_join(reader) == FVV_OK);
  REQUIRE(fvv_reader_push(reader, bytes.data(), bytes.size()) == FVV_OK);
  fvv_reader_finish(reader);
  std::vector<Chunk> out;
  fvv_event event;
  fvv_diagnostic diagnostic = {};
  fvv_status status;
  while ((status = fvv_reader_next(reader, &event, &diagnostic)) == FVV_OK) {
    INFO(event.diagnostic.message);
    CHECK(event.kind != FVV_EVENT_DAMAGE);
    if (event.kind != FVV_EVENT_CHUNK) continue;
    const fvv_chunk_header &h = event.chunk;
    if (h.type == FVV_CHUNK_GROUP && numbers) numbers->push_back(event.payload[0]);
    out.push_back({h.type, h.track, h.time, {reinterpret_cast<const char *>(event.payload), size_t(h.size)}});
  }
  INFO(diagnostic.message);
  CHECK(status == FVV_END);
  fvv_reader_destroy(reader);
  return out;
}

inline bool in_group(const Chunk &chunk) {
  return chunk.type == FVV_CHUNK_MESH || chunk.type == FVV_CHUNK_VIDEO_PACKET ||
         chunk.type == FVV_CHUNK_COLOURS || chunk.type == FVV_CHUNK_VISIBILITY;
}

inline std::vector<Chunk> only(const std::vector<Chunk> &chunks,
                               const std::function<bool(const Chunk &)> &wanted) {
  std::vector<Chunk> out;
  std::copy_if(chunks.begin(), chunks.end(), std::back_inserter(out), wanted);
  return out;
}

inline std::vector<Chunk> samples_of(const std::string &path, uint16_t track) {
  return only(chunks_of(read_bytes(path), false), [&](const Chunk &chunk) {
    return chunk.type == FVV_CHUNK_VIDEO_PACKET && chunk.track == track;
  });
}

using Files = std::map<std::string, std::string>;

inline Files segments_of(const std::string &path) {
  Files files;
  mux::write_segments(
      InputFile(path), [&](const std::string &name, const std::function<void(const mux::Sink &)> &fill) {
        std::string &file = files[name];
        fill([&](const void *bytes, size_t size) { file.append(static_cast<const char *>(bytes), size); });
      });
  return files;
}
