#include "fvv_mux/segments.h"
#include "fvv/container.h"
#include "fvv_cxx/rung.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

namespace fvv::mux {

namespace {

using Json = nlohmann::ordered_json;

constexpr size_t portion = 1 << 20;
constexpr uint64_t chunk_header = 32, file_header = 24; // bytes
constexpr const char *configuration_name = "configuration.fvv";
constexpr uint64_t largest_configuration = 64 << 20;

std::string hex(uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof text, "%08x", value);
  return text;
}

std::string group_name(size_t index) {
  char text[32];
  std::snprintf(text, sizeof text, "group-%06zu.fvv", index);
  return text;
}

// The version of the writer. Every chunk passes the push reader, so only valid streams are cut.
struct Checked {
  uint16_t major = 0, minor = 0;
};
Checked check_stream(const InputFile &file) {
  fvv_reader *created = nullptr;
  if (fvv_reader_create(nullptr, nullptr, 0, &created) < 0) throw std::bad_alloc();
  const std::unique_ptr<fvv_reader, void (*)(fvv_reader *)> reader(created, fvv_reader_destroy);
  const fvv_input input = file.input();
  std::vector<uint8_t> bytes(portion);
  Checked checked;
  for (uint64_t offset = 0;;) {
    fvv_event event;
    fvv_diagnostic diagnostic;
    const fvv_status status = fvv_reader_next(reader.get(), &event, &diagnostic);
    if (status == FVV_END) return checked;
    if (status == FVV_NEED_DATA) {
      const size_t size = static_cast<size_t>(std::min<uint64_t>(portion, file.size() - offset));
      if (!size) {
        fvv_reader_finish(reader.get());
        continue;
      }
      if (input.read_at(input.user, offset, bytes.data(), size) < 0)
        throw Error(file.path() + ": cannot read");
      if (fvv_reader_push(reader.get(), bytes.data(), size) < 0) throw std::bad_alloc();
      offset += size;
      continue;
    }
    fvv::check(status, file.path(), diagnostic);
    if (event.kind == FVV_EVENT_DAMAGE) fvv::fail(file.path(), event.diagnostic);
    if (event.kind == FVV_EVENT_HEADER) checked = {event.written_major, event.written_minor};
  }
}

std::vector<uint8_t> read(const InputFile &file, uint64_t offset, uint64_t size) {
  std::vector<uint8_t> bytes(static_cast<size_t>(size));
  const fvv_input input = file.input();
  if (size && input.read_at(input.user, offset, bytes.data(), bytes.size()) < 0)
    throw Error(file.path() + ": cannot read");
  return bytes;
}

// Writes a file with what fill passes to its argument; returns its entry in the manifest.
Json write(const WriteFile &write_file, const std::string &name,
           const std::function<void(const Sink &)> &fill) {
  uint32_t crc = 0;
  uint64_t size = 0;
  write_file(name, [&](const Sink &sink) {
    fill([&](const void *bytes, size_t count) {
      sink(bytes, count);
      crc = fvv_crc32c(crc, bytes, count);
      size += count;
    });
  });
  return {{"file", name}, {"bytes", size}, {"crc32c", hex(crc)}};
}

// Copies a range of the stream into a file.
Json copy(const InputFile &file, uint64_t offset, uint64_t size, const WriteFile &write_file,
          const std::string &name) {
  return write(write_file, name, [&](const Sink &sink) {
    for (uint64_t done = 0; done < size;) {
      const std::vector<uint8_t> bytes = read(file, offset + done, std::min<uint64_t>(portion, size - done));
      sink(bytes.data(), bytes.size());
      done += bytes.size();
    }
  });
}

fvv_chunk_header header_of(const fvv_chunk_info &chunk) {
  fvv_chunk_header header = {};
  header.type = chunk.type;
  header.flags = chunk.flags;
  header.track = chunk.track;
  header.time = chunk.time;
  header.size = chunk.size;
  return header;
}

// The configuration block of a group: from its SCEN to the group.
std::vector<uint8_t> block_of(const InputFile &file, const fvv_group_info &group) {
  const uint64_t size = group.configuration_size;
  if (size > largest_configuration)
    throw Error(file.path() + ": a configuration of " + std::to_string(size) + " bytes, expected at most " +
                std::to_string(largest_configuration));
  return read(file, group.configuration_offset, size);
}

// The environments, each a file of its own with one chunk, for players that begin in the middle.
Json copy_environments(const InputFile &file, fvv_stream *stream, const WriteFile &write_file) {
  Json list = Json::array();
  std::vector<uint16_t> known;
  for (size_t i = 0; i < fvv_stream_group_count(stream); i++) {
    const fvv_chunk_info *chunks = nullptr;
    size_t count = 0;
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_stream_group_chunks(stream, i, &chunks, &count, &diagnostic), file.path(), diagnostic);
    for (size_t k = 0; k < count; k++) {
      const fvv_chunk_info &chunk = chunks[k];
      if (chunk.type != FVV_CHUNK_ENVIRONMENT ||
          std::find(known.begin(), known.end(), chunk.track) != known.end())
        continue;
      known.push_back(chunk.track);
      const uint64_t size = (chunk_header + chunk.size + 7) / 8 * 8;
      Json entry =
          copy(file, chunk.offset, size, write_file, "environment-" + std::to_string(chunk.track) + ".fvv");
      entry["track"] = chunk.track;
      list.push_back(std::move(entry));
    }
  }
  return list;
}

// A configuration block with the chunks that fvv_stream lists.
ConfigurationBlock configuration_of(const InputFile &file, fvv_stream *stream) {
  ConfigurationBlock block;
  const fvv_chunk_info *chunks = nullptr;
  size_t count = 0;
  fvv_diagnostic diagnostic = {};
  fvv::check(fvv_stream_configuration_chunks(stream, 0, &chunks, &count, &diagnostic), file.path(),
             diagnostic);
  const std::vector<fvv_chunk_info> list(chunks, chunks + count);
  for (const fvv_chunk_info &chunk : list) {
    const uint8_t *payload = nullptr;
    fvv::check(fvv_stream_read_chunk(stream, &chunk, &payload, &diagnostic), file.path(), diagnostic);
    block.add(header_of(chunk), payload);
  }
  return block;
}

// A rung in a folder of its own.
Json write_rung(const InputFile &file, fvv_stream *stream, const ConfigurationBlock &block,
                const RungInfo &info, const WriteFile &write_file) {
  const std::string folder = "rung-" + std::to_string(info.rung) + "/";
  Json out = json_of<Json>(info);
  out["configuration"] = write(write_file, folder + configuration_name, [&](const Sink &sink) {
    const std::vector<uint8_t> header = read(file, 0, file_header);
    const std::string bytes = block.of_rung(info.rung);
    sink(header.data(), header.size());
    sink(bytes.data(), bytes.size());
  });
  out["groups"] = Json::array();
  for (size_t i = 0; i < fvv_stream_group_count(stream); i++)
    out["groups"].push_back(write(write_file, folder + group_name(i), [&](const Sink &sink) {
      const fvv_group_info group = *fvv_stream_group(stream, i);
      const fvv_chunk_info *chunks = nullptr;
      size_t count = 0;
      fvv_diagnostic diagnostic = {};
      fvv::check(fvv_stream_group_chunks(stream, i, &chunks, &count, &diagnostic), file.path(), diagnostic);
      const auto put = [&](const std::string &bytes) { sink(bytes.data(), bytes.size()); };
      RungGroup rung(block, info.rung);
      put(rung.begin(group.sequence, group.start, group.end));
      for (size_t k = 0; k < count; k++) {
        if (block.leaves_out(chunks[k].track, info.rung)) continue;
        const uint8_t *payload = nullptr;
        fvv::check(fvv_stream_read_chunk(stream, &chunks[k], &payload, &diagnostic), file.path(), diagnostic);
        put(rung.chunk(header_of(chunks[k]), payload));
      }
      put(rung.end());
    }));
  return out;
}

uint64_t bytes_of(const Json &rung) {
  uint64_t bytes = rung["configuration"]["bytes"];
  for (const Json &group : rung["groups"]) bytes += uint64_t(group["bytes"]);
  return bytes;
}

Json scene_of(const InputFile &file, fvv_stream *stream) {
  const fvv_chunk_info *chunks = nullptr;
  size_t count = 0;
  const uint8_t *payload = nullptr;
  fvv_diagnostic diagnostic = {};
  fvv_scene scene;
  fvv::check(fvv_stream_configuration_chunks(stream, 0, &chunks, &count, &diagnostic), file.path(),
             diagnostic);
  fvv::check(fvv_stream_read_chunk(stream, &chunks[0], &payload, &diagnostic), file.path(), diagnostic);
  fvv::check(fvv_scene_decode(&scene, payload, static_cast<size_t>(chunks[0].size), &diagnostic), file.path(),
             diagnostic);
  return {{"time_base", {scene.time_base.numerator, scene.time_base.denominator}},
          {"frame_duration", std::to_string(scene.frame_duration)}};
}

} // namespace

bool is_stream(const std::string &path) {
  constexpr std::string_view extension = ".fvv";
  return path.size() > extension.size() &&
         path.compare(path.size() - extension.size(), extension.size(), extension) == 0;
}

Segments write_segments(const InputFile &file, const WriteFile &write_file) {
  const std::string &stream = file.path();
  const Checked checked = check_stream(file);
  const fvv_input input = file.input();
  fvv_stream *opened = nullptr;
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_stream_open(&input, nullptr, nullptr, &opened, &diagnostic);
  const std::unique_ptr<fvv_stream, void (*)(fvv_stream *)> handle(opened, fvv_stream_close);
  fvv::check(status, stream, diagnostic);
  const size_t groups = fvv_stream_group_count(opened);
  if (!groups) throw Error(stream + ": there are no groups to make segments of");
  const fvv_group_info first = *fvv_stream_group(opened, 0);
  const std::vector<uint8_t> block = block_of(file, first);

  Json manifest = {{"fvv_segments", 1},
                   {"media_type", "model/vnd.fvv"},
                   {"format", std::to_string(checked.major) + "." + std::to_string(checked.minor)}};
  manifest.update(scene_of(file, opened));
  const ConfigurationBlock ladder = configuration_of(file, opened);
  const std::vector<RungInfo> infos = ladder.rungs();
  Json rungs = Json::array();
  uint64_t bytes = 0;
  for (size_t i = 0; i < infos.size() && infos.size() > 1; i++) {
    rungs.push_back(write_rung(file, opened, ladder, infos[i], write_file));
    bytes += bytes_of(rungs.back());
  }
  // Of a ladder a reader that does not know rungs takes the best one.
  const auto part = [&](const Json &of_rung, uint64_t offset, uint64_t size, const std::string &name) {
    if (!rungs.empty()) return of_rung;
    bytes += size;
    return copy(file, offset, size, write_file, name);
  };
  manifest["configuration"] =
      part(rungs.empty() ? Json() : rungs[0]["configuration"], 0, first.offset, configuration_name);
  manifest["groups"] = Json::array();
  uint64_t known = first.configuration_offset; // of the block that was compared last
  for (size_t i = 0; i < groups; i++) {
    const fvv_group_info &group = *fvv_stream_group(opened, i);
    if (group.configuration_offset != known && block_of(file, group) != block)
      throw Error(stream + ": the configuration changes before group " + std::to_string(i) +
                  ": segments have one for all groups");
    known = group.configuration_offset;
    Json entry =
        part(rungs.empty() ? Json() : rungs[0]["groups"][i], group.offset, group.size, group_name(i));
    entry["sequence"] = group.sequence;
    entry["start"] = std::to_string(group.start);
    entry["end"] = std::to_string(group.end);
    entry["frames"] = group.frame_count;
    manifest["groups"].push_back(std::move(entry));
  }
  if (!rungs.empty()) manifest["rungs"] = std::move(rungs);
  const Json environments = copy_environments(file, opened, write_file);
  if (!environments.empty()) manifest["environments"] = environments;
  const std::string text = manifest.dump(1) + "\n";
  write_file("manifest.json", [&](const Sink &sink) { sink(text.data(), text.size()); });
  return {groups, bytes, infos.size()};
}

} // namespace fvv::mux
