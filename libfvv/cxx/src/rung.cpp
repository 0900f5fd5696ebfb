#include "fvv_cxx/rung.h"
#include "fvv_cxx/error.h"

#include <algorithm>
#include <cmath>

namespace fvv {

namespace {

// One byte for each track: whether the rung has it.
std::vector<uint8_t> tracks_of_rung(const fvv_track *tracks, size_t count, size_t rung) {
  std::vector<uint8_t> has(count);
  fvv_rung_tracks(tracks, count, rung, has.data());
  return has;
}

} // namespace

size_t rung_count(const fvv_track *tracks, size_t count) {
  return fvv_rung_count(tracks, count);
}

bool in_rung(const fvv_track *tracks, size_t count, const fvv_track &track, size_t rung) {
  const std::vector<uint8_t> has = tracks_of_rung(tracks, count, rung);
  for (size_t i = 0; i < count; i++)
    if (tracks[i].id == track.id) return has[i] != 0;
  return true;
}

void ConfigurationBlock::add(const fvv_chunk_header &header, const uint8_t *payload) {
  const auto size = static_cast<size_t>(header.size);
  fvv_diagnostic diagnostic = {};
  if (header.type == FVV_CHUNK_SCENE) {
    fvv_scene scene = {};
    check(fvv_scene_decode(&scene, payload, size, &diagnostic), "", diagnostic);
    ticks = scene.time_base;
  }
  if (header.type == FVV_CHUNK_TRACK) {
    fvv_track track = {};
    check(fvv_track_decode(&track, payload, size, nullptr, &diagnostic), "", diagnostic);
    track.id = header.track;
    track.name = nullptr;
    track.name_size = 0;
    tracks.push_back(track);
  }
  if (header.type == FVV_CHUNK_TILES) {
    std::vector<fvv_tile> list;
    size_t count = 0;
    fvv_status status = fvv_tiles_decode(nullptr, 0, &count, payload, size, nullptr, &diagnostic);
    if (status == FVV_ERROR_BUFFER_TOO_SMALL) {
      list.resize(count);
      status = fvv_tiles_decode(list.data(), count, &count, payload, size, nullptr, &diagnostic);
    }
    if (status == FVV_OK) layouts.push_back({header.track, std::move(list)});
  }
  chunks.push_back({header, {payload, payload + size}});
}

bool ConfigurationBlock::leaves_out(uint16_t track, size_t rung) const {
  const auto found =
      std::find_if(tracks.begin(), tracks.end(), [&](const fvv_track &one) { return one.id == track; });
  return found != tracks.end() && !in_rung(tracks.data(), tracks.size(), *found, rung);
}

std::vector<RungInfo> ConfigurationBlock::rungs() const {
  std::vector<fvv_video_layout> videos;
  for (const Layout &layout : layouts) {
    videos.push_back({});
    videos.back().track = layout.track;
    videos.back().tiles = layout.tiles.data();
    videos.back().tile_count = layout.tiles.size();
  }
  fvv_configuration configuration = {};
  configuration.tracks = tracks.data();
  configuration.track_count = tracks.size();
  configuration.videos = videos.data();
  configuration.video_count = videos.size();
  return rungs_of(configuration);
}

std::vector<RungInfo> rungs_of(const fvv_configuration &configuration) {
  std::vector<RungInfo> out;
  const size_t count = rung_count(configuration.tracks, configuration.track_count);
  for (size_t rung = 0; rung < count; rung++) {
    const std::vector<uint8_t> has = tracks_of_rung(configuration.tracks, configuration.track_count, rung);
    RungInfo info;
    info.rung = rung;
    bool known = true; // the rate of all that the rungs differ in
    for (size_t i = 0; i < configuration.track_count; i++) {
      const fvv_track &track = configuration.tracks[i];
      if (!has[i]) continue;
      info.tracks.push_back(track.id);
      info.bit_rate += track.bit_rate;
      known = known && (track.bit_rate || !track.alternate_group);
      if (track.kind == FVV_TRACK_VIDEO) info.size += track.size;
    }
    if (!known) info.bit_rate = 0;
    std::sort(info.tracks.begin(), info.tracks.end());
    double source = 0, destination = 0; // pixels
    for (size_t i = 0; i < configuration.video_count; i++) {
      const fvv_video_layout &video = configuration.videos[i];
      if (!in_rung(configuration, video.track, rung)) continue;
      for (size_t k = 0; k < video.tile_count; k++) {
        const fvv_rect &from = video.tiles[k].source, &to = video.tiles[k].destination;
        source += double(from.width) * from.height;
        destination += double(to.width) * to.height;
      }
    }
    if (source > 0) info.scale = std::sqrt(destination / source);
    out.push_back(std::move(info));
  }
  return out;
}

namespace {

fvv_status append(void *user, const void *bytes, size_t size) {
  try {
    static_cast<std::string *>(user)->append(static_cast<const char *>(bytes), size);
    return FVV_OK;
  } catch (const std::bad_alloc &) {
    return FVV_ERROR_IO;
  }
}

} // namespace

struct RungGroup::State {
  State(const ConfigurationBlock &of, size_t which)
      : block(of), rung(which), writer(nullptr, fvv_writer_destroy) {
    const fvv_output output = {append, &bytes};
    fvv_writer *created = nullptr;
    const fvv_status status = fvv_writer_create(&output, nullptr, &created, &diagnostic);
    writer.reset(created);
    check(status);
    bytes.clear(); // the file header is the stream's own
    for (const ConfigurationBlock::Chunk &chunk : block.chunks) {
      if (block.leaves_out(chunk.header.track, rung)) continue;
      const std::vector<uint8_t> payload =
          chunk.header.type == FVV_CHUNK_TRACK ? alone(chunk) : chunk.payload;
      check(fvv_writer_configuration(writer.get(), chunk.header.type, chunk.header.track, chunk.header.flags,
                                     payload.data(), payload.size(), &diagnostic));
    }
  }

  // TRAK of a track that has no alternatives in the stream of its rung.
  std::vector<uint8_t> alone(const ConfigurationBlock::Chunk &chunk) {
    fvv_track track = {};
    check(fvv_track_decode(&track, chunk.payload.data(), chunk.payload.size(), nullptr, &diagnostic));
    track.id = chunk.header.track;
    track.alternate_group = track.rank = 0;
    std::vector<uint8_t> out(chunk.payload.size());
    size_t size = 0;
    check(fvv_track_encode(&track, out.data(), out.size(), &size, &diagnostic));
    return out;
  }

  void check(fvv_status status) { fvv::check(status, "", diagnostic); }

  std::string take() {
    std::string out;
    out.swap(bytes);
    return out;
  }

  const ConfigurationBlock &block;
  const size_t rung;
  fvv_diagnostic diagnostic = {};
  std::string bytes; // written and not taken
  std::unique_ptr<fvv_writer, void (*)(fvv_writer *)> writer;
};

std::string ConfigurationBlock::of_rung(size_t rung) const {
  return RungGroup(*this, rung).state->take();
}

RungGroup::RungGroup(const ConfigurationBlock &block, size_t rung)
    : state(std::make_unique<State>(block, rung)) {}

RungGroup::~RungGroup() = default;

std::string RungGroup::begin(uint32_t sequence, int64_t start, int64_t end) {
  state->bytes.clear();
  state->check(fvv_writer_join(state->writer.get(), sequence));
  state->check(fvv_writer_begin_group(state->writer.get(), start, end, &state->diagnostic));
  return state->take();
}

namespace {

// The mesh track to which visibility and colours belong; 0: none, or it is not known.
uint16_t mesh_track_of(const fvv_chunk_header &header, const uint8_t *payload) {
  const auto size = static_cast<size_t>(header.size);
  fvv_visibility_header visibility = {};
  fvv_colours_header colours = {};
  if (header.type == FVV_CHUNK_VISIBILITY) {
    const fvv_status status = fvv_visibility_peek(payload, size, nullptr, &visibility, nullptr, 0, nullptr);
    return status == FVV_OK || status == FVV_ERROR_BUFFER_TOO_SMALL ? visibility.mesh_track : 0;
  }
  if (header.type != FVV_CHUNK_COLOURS) return 0;
  return fvv_colours_peek(payload, size, nullptr, &colours, nullptr) == FVV_OK ? colours.mesh_track : 0;
}

} // namespace

std::string RungGroup::chunk(const fvv_chunk_header &header, const uint8_t *payload) {
  const auto leaves_out = [&](uint16_t track) { return state->block.leaves_out(track, state->rung); };
  if (leaves_out(header.track) || leaves_out(mesh_track_of(header, payload))) return {};
  state->check(fvv_writer_chunk(state->writer.get(), header.type, header.track, header.flags, header.time,
                                payload, static_cast<size_t>(header.size), &state->diagnostic));
  return state->take();
}

std::string RungGroup::end() {
  state->check(fvv_writer_end_group(state->writer.get(), &state->diagnostic));
  return state->take();
}

} // namespace fvv
