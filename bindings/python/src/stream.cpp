#include "stream.h"

#include "environment.h"
#include "fvv_cxx/rung.h"
#include "fvv_demux/selection.h"
#include "processes/process.h"

#include <algorithm>
#include <pybind11/stl.h>

namespace fvv::python {

// ---- video ---------------------------------------------------------------------------------------------

std::shared_ptr<const demux::VideoFrame> require_picture(const demux::PictureDecoder &decoder,
                                                         fvv_status status, const std::string &file) {
  if (status >= 0) return decoder.frame();
  if (decoder.diagnostic().status) throw Failure(decoder.diagnostic(), file);
  throw Failure(status, decoder.why(), file);
}

void check_video(const std::vector<demux::VideoViews> &tracks, const Limits &limits,
                 const std::string &file) {
  uint64_t bytes = 0;
  for (const demux::VideoViews &track : tracks) {
    const std::string name = "track " + std::to_string(track.video->track) + ": ";
    if (!media::find_video_codec(track.video->config.codec))
      throw Failure(FVV_ERROR_UNSUPPORTED, name + "the codec of the video is not known", file);
    bytes += media::decoding_memory(track.video->config);
    if (bytes > limits.max_picture_memory)
      throw Failure(FVV_ERROR_LIMIT,
                    name + "decoding takes " + std::to_string(bytes) +
                        " bytes, more than the limit max_picture_memory, which is " +
                        std::to_string(limits.max_picture_memory),
                    file);
  }
}

std::shared_ptr<Picture> picture_of(const std::shared_ptr<const demux::VideoFrame> &frame,
                                    const fvv_tile &tile, const demux::View &view,
                                    const fvv_camera *calibration) {
  auto out = std::make_shared<Picture>();
  out->frame = frame;
  out->tile = tile;
  out->whole = view.whole;
  if (calibration) {
    fvv_camera camera = fvv_camera_of_tile(calibration, &tile);
    camera.name = calibration->name;
    camera.name_size = calibration->name_size;
    out->camera = std::make_shared<Camera>(camera);
  }
  return out;
}

// ---- descriptions --------------------------------------------------------------------------------------

namespace {

py::object text_of(const char *text, size_t size) {
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(text ? text : "", Py_ssize_t(size), "replace"));
}

py::tuple pair_of(const fvv_rational &value) {
  return py::make_tuple(value.numerator, value.denominator);
}

py::list triple(const double values[3]) {
  py::list out;
  for (size_t k = 0; k < 3; k++) out.append(values[k]);
  return out;
}

} // namespace

py::dict describe(const fvv_configuration &configuration, size_t rung) {
  py::dict out;
  const fvv_scene &scene = configuration.scene;
  out["time_base"] = pair_of(scene.time_base);
  out["frame_duration"] = scene.frame_duration;
  out["origin"] = triple(scene.lattice_origin);
  out["step"] = scene.lattice_step;
  out["up"] = scene.up_axis;
  out["scale_unknown"] = (scene.flags & FVV_SCENE_SCALE_UNKNOWN) != 0;
  py::list tracks, cameras, meshes, rungs, metadata;
  for (size_t i = 0; i < configuration.track_count; i++) {
    const fvv_track &track = configuration.tracks[i];
    const bool chosen = in_rung(configuration, track.id, rung);
    if (chosen && track.kind == FVV_TRACK_MESH) meshes.append(track.id);
    tracks.append(py::make_tuple(track.id, track.kind, text_of(track.name, track.name_size),
                                 track.alternate_group, track.rank, track.bit_rate, track.size,
                                 pair_of(track.time_base.denominator ? track.time_base : scene.time_base),
                                 chosen));
  }
  for (size_t i = 0; i < configuration.camera_count; i++)
    cameras.append(py::make_tuple(configuration.cameras[i].id, text_of(configuration.cameras[i].name,
                                                                       configuration.cameras[i].name_size)));
  for (const RungInfo &info : rungs_of(configuration))
    rungs.append(py::make_tuple(info.rung, info.bit_rate, info.size,
                                info.scale > 0 ? py::object(py::float_(info.scale)) : py::object(py::none()),
                                info.tracks));
  for (size_t i = 0; i < configuration.metadata_count; i++)
    metadata.append(text_of(configuration.metadata[i].text, configuration.metadata[i].size));
  out["tracks"] = tracks;
  out["cameras"] = cameras;
  out["meshes"] = meshes;
  out["rungs"] = rungs;
  out["metadata"] = metadata;
  const fvv_texturing &texturing = configuration.texturing;
  const uint8_t *unseen = texturing.unseen;
  out["texturing"] =
      py::make_tuple(texturing.blend == FVV_BLEND_PAPER ? "paper" : "viewer", texturing.threshold,
                     texturing.best, texturing.inset, py::make_tuple(unseen[0], unseen[1], unseen[2]));
  return out;
}

py::tuple describe(const fvv_diagnostic &diagnostic, const std::string &file) {
  const bool placed = diagnostic.issue || diagnostic.chunk_type;
  // Without a place the line has none either.
  const Failure failure =
      placed ? Failure(diagnostic, file) : Failure(diagnostic.status, diagnostic.message, file);
  return py::make_tuple(fvv_status_text(diagnostic.status),
                        diagnostic.issue ? py::object(py::int_(diagnostic.issue)) : py::none(),
                        chunk_name(diagnostic.chunk_type),
                        placed ? py::object(py::int_(diagnostic.offset)) : py::none(),
                        placed ? py::object(py::int_(diagnostic.chunk_offset)) : py::none(),
                        text_of(failure.line.data(), failure.line.size()));
}

// A chunk as numpy shows it; the names of the fields are those of the columns.
struct ChunkRow {
  uint32_t group;
  char type[4];
  uint16_t track;
  bool key;
  int64_t time;
  uint64_t offset, size;
};

// ---- the clip ------------------------------------------------------------------------------------------

namespace {

// The thread that has the lock.
struct Owned {
  explicit Owned(std::atomic<std::thread::id> &the_owner) : owner(the_owner) {
    owner = std::this_thread::get_id();
  }
  ~Owned() { owner = std::thread::id(); }
  std::atomic<std::thread::id> &owner;
};

} // namespace

// Calls work() without the GIL, under the lock. The GIL is never waited for with the lock unless the thread
// that has the GIL does not wait for the lock: all of them release it first.
template <class Work> auto Stream::run(const Work &work) {
  if (owner.load() == std::this_thread::get_id())
    throw Failure(FVV_ERROR_STATE, "a clip cannot be used from its own read_at", source.name());
  const auto locked = [&] {
    const py::gil_scoped_release release;
    const std::lock_guard<std::mutex> guard(lock);
    const Owned owned(owner);
    if (is_closed) throw Failure(FVV_ERROR_STATE, "the clip is closed", source.name());
    try {
      return work();
    } catch (const Failure &failure) {
      meet(failure.diagnostic);
      throw;
    }
  };
  try {
    auto result = locked();
    source.rethrow();
    return result;
  } catch (const py::error_already_set &) {
    throw;
  } catch (...) {
    source.rethrow();
    throw;
  }
}

void Stream::meet(const fvv_diagnostic &d) {
  const auto same = [&](const fvv_diagnostic &other) {
    return other.offset == d.offset && !std::strcmp(other.message, d.message);
  };
  if (d.status <= FVV_ERROR_DAMAGED && d.status > FVV_ERROR_BUG && met.size() < 1000 &&
      std::none_of(met.begin(), met.end(), same))
    met.push_back(d);
}

Stream::Stream(const py::object &object, const std::string &name, size_t the_rung, const py::dict &given)
    : limits(given), rung(the_rung), source(object, name), total(source.file().size()),
      survey(source.file(), &limits.core,
             [this](const fvv_configuration &configuration, const fvv_track &track) {
               return in_rung(configuration, track.id, rung);
             }) {
  run([&] {
    const fvv_input input = source.file().input();
    byte_count = input.size;
    fvv_stream *opened = nullptr;
    fvv_diagnostic diagnostic = {};
    call(fvv_stream_open(&input, &limits.core, nullptr, &opened, &diagnostic), diagnostic);
    stream.reset(opened);
    plan = demux::make_plan(opened, source.file(), demux::Selection(), survey);
    size_t begin = 0;
    for (const demux::GroupPlan &group : plan.groups) {
      const size_t count = fvv_stream_group(opened, group.group)->frame_count;
      if (count) places.push_back({begin, count, group});
      begin += count;
    }
    return true;
  });
}

void Stream::call(fvv_status status, const fvv_diagnostic &diagnostic) const {
  require(status, diagnostic, source.name());
}

void Stream::close() {
  if (is_closed) return;
  run([&] {
    videos.clear();
    stream.reset();
    is_closed = true;
    return true;
  });
  {
    const std::lock_guard<std::mutex> guard(kept_lock);
    kept.reset();
  }
  source.close();
}

const Stream::Place &Stream::place_of(size_t i) const {
  const auto after = std::upper_bound(places.begin(), places.end(), i,
                                      [](size_t frame, const Place &place) { return frame < place.begin; });
  if (after == places.begin() || i >= std::prev(after)->begin + std::prev(after)->count)
    throw Failure(FVV_ERROR_ARGUMENT, "frame " + std::to_string(i) + " of " + std::to_string(size()),
                  source.name());
  return *std::prev(after);
}

// Throws when the frame is not whole.
Stream::Located Stream::locate(size_t i) {
  const Place &place = place_of(i);
  const size_t inside = i - place.begin;
  fvv_frame info;
  fvv_diagnostic diagnostic = {};
  call(fvv_stream_frame(stream.get(), place.plan.frame + inside, &info, &diagnostic), diagnostic);
  // Only now it is known whether the group's table is valid.
  const fvv_group_info &group = *fvv_stream_group(stream.get(), place.plan.group);
  if (!place.plan.complete || !group.intact) {
    const demux::Survey::Group surveyed = survey.group(group.offset);
    if (inside >= surveyed.whole) {
      if (surveyed.reason.status) throw Failure(surveyed.reason, source.name());
      throw Failure(FVV_ERROR_TRUNCATED, "the stream ends within the frame's group", source.name());
    }
  }
  return {place.plan.frame + inside, place.plan.frame, place.plan.group, info.time,
          place.plan.number + int64_t(inside)};
}

const fvv_configuration &Stream::configuration_of(size_t group) {
  const fvv_configuration *configuration = nullptr;
  fvv_diagnostic diagnostic = {};
  call(fvv_stream_configuration(stream.get(), group, &configuration, &diagnostic), diagnostic);
  return *configuration;
}

py::tuple Stream::frame(size_t i) {
  const Located found = run([&] { return locate(i); });
  return py::make_tuple(found.ticks, found.number, found.group);
}

int64_t Stream::number(size_t i) {
  return run([&] {
    const Place &place = place_of(i);
    return place.plan.number + int64_t(i - place.begin);
  });
}

size_t Stream::at(int64_t ticks) {
  return run([&] {
    const auto time = [&](size_t i) {
      const Place &place = place_of(i);
      fvv_frame info;
      fvv_diagnostic diagnostic = {};
      call(fvv_stream_frame(stream.get(), place.plan.frame + i - place.begin, &info, &diagnostic),
           diagnostic);
      return info.time;
    };
    const auto start = [&](const Place &place) {
      return fvv_stream_group(stream.get(), place.plan.group)->start;
    };
    size_t low = 0, high = places.size(); // places before low begin no later
    while (low < high) {
      const size_t middle = (low + high) / 2;
      if (start(places[middle]) <= ticks)
        low = middle + 1;
      else
        high = middle;
    }
    // A group may begin before its first frame.
    while (low && time(places[low - 1].begin) > ticks) low--;
    if (!low) throw Failure(FVV_ERROR_ARGUMENT, "the time is before the first frame", source.name());
    const Place &place = places[low - 1];
    size_t first = place.begin, end = place.begin + place.count; // time(first) <= ticks
    while (end - first > 1) {
      const size_t middle = (first + end) / 2;
      if (time(middle) <= ticks)
        first = middle;
      else
        end = middle;
    }
    return first;
  });
}

py::tuple Stream::span() {
  const auto [start, end] = run([&] {
    if (places.empty()) return std::pair<int64_t, int64_t>(0, 0);
    return std::pair(fvv_stream_group(stream.get(), places.front().plan.group)->start,
                     fvv_stream_group(stream.get(), places.back().plan.group)->end);
  });
  return py::make_tuple(start, end);
}

py::dict Stream::configuration(std::optional<size_t> group) {
  return run([&] {
    const fvv_configuration *found = nullptr;
    if (group) {
      found = &configuration_of(*group);
    } else {
      const size_t count = fvv_stream_group_count(stream.get());
      for (size_t g = 0; g < count && !found; g++)
        if (g + 1 == count || fvv_stream_configuration(stream.get(), g, &found, nullptr) != FVV_OK)
          found = g + 1 == count ? &configuration_of(g) : nullptr;
      if (!found) throw Failure(FVV_ERROR_DAMAGED, "the stream has no group", source.name());
    }
    // Objects of Python while the lock keeps the configuration.
    const py::gil_scoped_acquire acquire;
    return describe(*found, rung);
  });
}

uint64_t Stream::configuration_offset(size_t group) {
  return run([&] {
    const fvv_group_info *info = fvv_stream_group(stream.get(), group);
    if (!info) throw Failure(FVV_ERROR_ARGUMENT, "there is no such group", source.name());
    return info->configuration_offset;
  });
}

std::shared_ptr<Mesh> Stream::mesh(size_t i, uint16_t track) {
  return run([&]() -> std::shared_ptr<Mesh> {
    const Located found = locate(i);
    auto out = std::make_shared<Mesh>();
    fvv_diagnostic diagnostic = {};
    const fvv_status status = fvv_stream_mesh(stream.get(), found.frame, track, &out->mesh, &diagnostic);
    call(status, diagnostic);
    if (status == FVV_END) return nullptr;
    const uint8_t *colours = nullptr;
    uint32_t count = 0;
    const fvv_status coloured =
        fvv_stream_colours(stream.get(), found.frame, track, &colours, &count, &diagnostic);
    call(coloured, diagnostic);
    if (coloured == FVV_OK) out->colours.assign(colours, colours + 3 * size_t(count));
    const fvv_scene &scene = configuration_of(found.group).scene;
    std::copy(scene.lattice_origin, scene.lattice_origin + 3, out->origin);
    out->step = scene.lattice_step;
    out->track = track;
    return out;
  });
}

std::shared_ptr<Camera> Stream::camera(size_t i, uint16_t id) {
  return run([&]() -> std::shared_ptr<Camera> {
    const Located found = locate(i);
    fvv_camera camera;
    fvv_diagnostic diagnostic = {};
    const fvv_status status = fvv_stream_camera(stream.get(), found.frame, id, &camera, &diagnostic);
    call(status, diagnostic);
    return status == FVV_END ? nullptr : std::make_shared<Camera>(camera);
  });
}

py::object Stream::visibility(size_t i, uint16_t mesh_track, uint16_t camera) {
  std::optional<std::vector<uint8_t>> weights;
  run([&] {
    const Located found = locate(i);
    const fvv_configuration &configuration = configuration_of(found.group);
    for (size_t k = 0; k < configuration.track_count && !weights; k++) {
      const fvv_track &track = configuration.tracks[k];
      if (track.kind != FVV_TRACK_VISIBILITY || !in_rung(configuration, track.id, rung)) continue;
      const fvv_visibility *visibility = nullptr;
      fvv_diagnostic diagnostic = {};
      const fvv_status status =
          fvv_stream_visibility(stream.get(), found.frame, track.id, &visibility, &diagnostic);
      call(status, diagnostic);
      if (status == FVV_END || visibility->header.mesh_track != mesh_track) continue;
      const size_t count = visibility->header.vertex_count;
      const uint16_t *end = visibility->cameras + visibility->header.camera_count;
      const uint16_t *row = std::find(visibility->cameras, const_cast<uint16_t *>(end), camera);
      if (row == end) continue;
      weights.emplace(count);
      fvv_visibility_weights(visibility->states + size_t(row - visibility->cameras) * count, count,
                             weights->data());
    }
    return true;
  });
  if (!weights) return py::none();
  py::array_t<uint8_t> out(py::ssize_t(weights->size()), weights->data());
  out.attr("flags").attr("writeable") = false;
  return std::move(out);
}

std::vector<uint16_t> Stream::picture_cameras(size_t i) {
  return run([&] {
    std::vector<uint16_t> out;
    const Located found = locate(i);
    for (const demux::VideoViews &track :
         demux::views_of(configuration_of(found.group), rung, demux::Selection(), nullptr)) {
      const uint8_t *sample = nullptr;
      size_t size = 0;
      int key = 0;
      fvv_diagnostic diagnostic = {};
      // One that is damaged is reported when its pixels are wanted.
      if (fvv_stream_sample(stream.get(), found.frame, track.video->track, &sample, &size, &key,
                            &diagnostic) == FVV_END)
        continue;
      for (const demux::View &view : track.views) {
        std::optional<fvv_tile> tile;
        call(demux::tile_in_group(stream.get(), found.group, *track.video, view, tile, diagnostic),
             diagnostic);
        if (tile) out.push_back(view.tile.camera_id);
      }
    }
    return out;
  });
}

std::shared_ptr<Picture> Stream::picture(size_t i, uint16_t camera) {
  return run([&]() -> std::shared_ptr<Picture> {
    const Located found = locate(i);
    const fvv_configuration &configuration = configuration_of(found.group);
    const auto tracks = demux::views_of(configuration, rung, demux::Selection(), nullptr);
    check_video(tracks, limits, source.name());
    const uint64_t block = fvv_stream_group(stream.get(), found.group)->configuration_offset;
    if (block != video_configuration) videos.clear();
    video_configuration = block;
    for (const demux::VideoViews &track : tracks)
      for (const demux::View &view : track.views) {
        if (view.tile.camera_id != camera) continue;
        std::optional<fvv_tile> tile;
        fvv_diagnostic diagnostic = {};
        call(demux::tile_in_group(stream.get(), found.group, *track.video, view, tile, diagnostic),
             diagnostic);
        if (!tile) return nullptr;
        const uint16_t id = track.video->track;
        auto decoder = videos.find(id);
        if (decoder == videos.end()) decoder = videos.try_emplace(id, *track.video).first;
        const auto frame = require_picture(
            decoder->second, decoder->second.decode(stream.get(), found.first, found.frame), source.name());
        if (!frame) return nullptr;
        fvv_camera calibration;
        const fvv_status status =
            camera == demux::no_camera
                ? FVV_END
                : fvv_stream_camera(stream.get(), found.frame, camera, &calibration, &diagnostic);
        call(status, diagnostic);
        return picture_of(frame, *tile, view, status == FVV_OK ? &calibration : nullptr);
      }
    return nullptr;
  });
}

py::object Stream::environment(size_t i) {
  Environment found;
  const bool any = run([&] {
    const size_t group = locate(i).group;
    const fvv_configuration &configuration = configuration_of(group);
    bool some = false;
    for (size_t k = 0; k < configuration.track_count; k++) {
      const fvv_track &track = configuration.tracks[k];
      if (track.kind == FVV_TRACK_ENVIRONMENT && in_rung(configuration, track.id, rung))
        some |= add_environment(stream.get(), group, track.id, limits, source.name(), found);
    }
    return some;
  });
  if (!any) return py::none();
  return described(std::move(found));
}

std::vector<std::shared_ptr<Sound>> Stream::sounds() {
  return run([&] {
    std::vector<std::shared_ptr<Sound>> out;
    sound_losses.clear();
    for (size_t first = 0, last; first < places.size(); first = last + 1) {
      const auto group = [&](size_t place) { return places[place].plan.group; };
      const auto block = [&](size_t place) {
        return fvv_stream_group(stream.get(), group(place))->configuration_offset;
      };
      last = first;
      while (last + 1 < places.size() && block(last + 1) == block(first)) last++;
      const fvv_configuration *configuration = nullptr;
      if (fvv_stream_configuration(stream.get(), group(first), &configuration, nullptr) != FVV_OK) continue;
      const fvv_rational base = configuration->scene.time_base;
      const int64_t start = fvv_stream_group(stream.get(), group(first))->start;
      demux::UnpackedSounds unpacked =
          demux::unpack_sounds(source.file(), group(first), group(last), &limits.core);
      sound_losses.insert(sound_losses.end(), unpacked.losses.begin(), unpacked.losses.end());
      std::map<uint16_t, int> parts;
      for (demux::UnpackedSound &sound : unpacked.sounds) {
        const media::SoundPackets &packets = sound.packets;
        const double begin = double(start) * base.numerator / base.denominator * packets.format.rate;
        // After a gap the decoder begins within the sound.
        const int64_t heard = parts[sound.track]++ ? packets.start + int64_t(packets.format.preroll) *
                                                                         packets.format.packet_duration
                                                   : int64_t(std::llround(begin));
        const int64_t from = std::clamp(heard, packets.start, packets.end());
        out.push_back(std::make_shared<Sound>(Sound{std::move(sound), from, base}));
      }
    }
    return out;
  });
}

py::list Stream::problems() {
  struct Found {
    std::vector<fvv_diagnostic> diagnostics;
    std::vector<std::string> texts;
  };
  const std::string &name = source.name();
  const Found found = run([&] {
    Found all;
    for (size_t k = 0; k < fvv_stream_damage_count(stream.get()); k++)
      all.diagnostics.push_back(*fvv_stream_damage(stream.get(), k));
    for (const fvv_diagnostic &one : met)
      if (std::none_of(all.diagnostics.begin(), all.diagnostics.end(), [&](const fvv_diagnostic &other) {
            return other.offset == one.offset && !std::strcmp(other.message, one.message);
          }))
        all.diagnostics.push_back(one);
    if (plan.rebuilt && !fvv_stream_damage_count(stream.get()))
      all.texts.push_back("no footer: the stream is live or truncated");
    for (const demux::Loss &loss : plan.losses)
      all.texts.push_back((loss.first == loss.last ? "frame " + std::to_string(loss.first) + " is lost: "
                                                   : "frames " + std::to_string(loss.first) + " to " +
                                                         std::to_string(loss.last) + " are lost: ") +
                          loss.why);
    if (!plan.uncertain.empty()) all.texts.push_back(plan.uncertain);
    all.texts.insert(all.texts.end(), sound_losses.begin(), sound_losses.end());
    return all;
  });
  py::list out;
  for (const fvv_diagnostic &one : found.diagnostics) out.append(describe(one, name));
  for (const std::string &text : found.texts)
    out.append(py::make_tuple(fvv_status_text(FVV_ERROR_DAMAGED), py::none(), py::none(), py::none(),
                              py::none(),
                              text_of((name + ": " + text).data(), name.size() + 2 + text.size())));
  return out;
}

py::array Stream::chunks(std::optional<size_t> wanted) {
  const std::vector<ChunkRow> rows = run([&] {
    std::vector<ChunkRow> out;
    // A handle of its own: that of the stream is not to be used beside it.
    const fvv_input input = source.file().input();
    fvv_stream *opened = nullptr;
    fvv_diagnostic diagnostic = {};
    call(fvv_stream_open(&input, &limits.core, nullptr, &opened, &diagnostic), diagnostic);
    const std::unique_ptr<fvv_stream, void (*)(fvv_stream *)> file(opened, fvv_stream_close);
    const size_t count = fvv_stream_group_count(opened);
    if (wanted && *wanted >= count)
      throw Failure(FVV_ERROR_ARGUMENT, "group " + std::to_string(*wanted) + " of " + std::to_string(count),
                    source.name());
    for (size_t group = wanted.value_or(0); group < (wanted ? *wanted + 1 : count); group++) {
      const fvv_chunk_info *chunks = nullptr;
      size_t chunk_count = 0;
      diagnostic = {};
      const fvv_status status = fvv_stream_group_chunks(opened, group, &chunks, &chunk_count, &diagnostic);
      if (!wanted && status <= FVV_ERROR_DAMAGED && status > FVV_ERROR_BUG) {
        meet(diagnostic);
        continue;
      }
      call(status, diagnostic);
      for (size_t i = 0; i < chunk_count; i++) {
        const fvv_chunk_info &chunk = chunks[i];
        ChunkRow row = {};
        row.group = uint32_t(group);
        for (int k = 0; k < 4; k++) row.type[k] = char(chunk.type >> 8 * k & 0xff);
        row.track = chunk.track;
        row.key = (chunk.flags & FVV_FLAG_KEY) != 0;
        row.time = chunk.time;
        row.offset = chunk.offset;
        row.size = chunk.size;
        out.push_back(row);
      }
    }
    for (size_t k = 0; k < fvv_stream_damage_count(opened); k++) meet(*fvv_stream_damage(opened, k));
    return out;
  });
  return py::array_t<ChunkRow>(py::ssize_t(rows.size()), rows.data());
}

py::bytes Stream::read_at(uint64_t offset, size_t size) {
  std::string out;
  run([&] {
    if (offset > byte_count || size > byte_count - offset)
      throw Failure(FVV_ERROR_ARGUMENT,
                    std::to_string(size) + " bytes at " + std::to_string(offset) + " of " +
                        std::to_string(byte_count),
                    source.name());
    out.resize(size);
    const fvv_input input = source.file().input();
    if (size) call(input.read_at(input.user, offset, out.data(), size), {});
    return true;
  });
  return py::bytes(out);
}

// Called without the GIL, as run() locks.
fvv_status Stream::read_in_turn(void *user, uint64_t offset, void *out, size_t size) {
  auto &self = *static_cast<Stream *>(user);
  const std::lock_guard<std::mutex> guard(self.lock);
  const Owned owned(self.owner);
  if (self.is_closed) return FVV_ERROR_IO;
  const fvv_input input = self.source.file().input();
  return input.read_at(input.user, offset, out, size);
}

fvv_input Stream::reading() {
  return {read_in_turn, this, total};
}

void Stream::check_reading() {
  source.rethrow();
  if (is_closed) throw Failure(FVV_ERROR_STATE, "the clip is closed", source.name());
}

void Stream::check_pictures(size_t i) {
  run([&] {
    const fvv_configuration &configuration = configuration_of(place_of(i).plan.group);
    check_video(demux::views_of(configuration, rung, demux::Selection(), nullptr), limits, source.name());
    return true;
  });
}

std::shared_ptr<const view::Frame> Stream::loaded(int64_t frame_number, bool pictures) {
  {
    const std::lock_guard<std::mutex> guard(kept_lock);
    if (kept && kept->number == frame_number && kept_pictures == pictures) return kept;
  }
  const fvv_input input = reading();
  const InputFile file(input, source.name());
  view::LoadOptions options;
  options.memory = {limits.max_picture_memory, "the limit max_picture_memory"};
  options.pictures = pictures;
  options.rung = rung;
  options.limits = &limits.core;
  auto frame = std::make_shared<const view::Frame>(view::load_frame(file, frame_number, options));
  const std::lock_guard<std::mutex> guard(kept_lock);
  if (is_closed) return frame;
  kept = frame;
  kept_pictures = pictures;
  return frame;
}

void register_stream(py::module_ &module) {
  PYBIND11_NUMPY_DTYPE(ChunkRow, group, type, track, key, time, offset, size);
  py::class_<Stream, std::shared_ptr<Stream>>(module, "Stream")
      .def(py::init(&make_for_this_process<Stream, const py::object &, const std::string &, size_t,
                                           const py::dict &>),
           py::arg("source"), py::arg("name"), py::arg("rung"), py::arg("limits"))
      .def("close", &Stream::close)
      .def_property_readonly("closed", &Stream::closed)
      .def("__len__", &Stream::size)
      .def("frame", &Stream::frame, py::arg("frame"))
      .def("number", &Stream::number, py::arg("frame"))
      .def("at", &Stream::at, py::arg("ticks"))
      .def("span", &Stream::span)
      .def("configuration", &Stream::configuration, py::arg("group") = py::none())
      .def("configuration_offset", &Stream::configuration_offset, py::arg("group"))
      .def("mesh", &Stream::mesh, py::arg("frame"), py::arg("track"))
      .def("camera", &Stream::camera, py::arg("frame"), py::arg("camera"))
      .def("visibility", &Stream::visibility, py::arg("frame"), py::arg("mesh_track"), py::arg("camera"))
      .def("picture_cameras", &Stream::picture_cameras, py::arg("frame"))
      .def("picture", &Stream::picture, py::arg("frame"), py::arg("camera"))
      .def("environment", &Stream::environment, py::arg("frame"))
      .def("sounds", &Stream::sounds)
      .def("problems", &Stream::problems)
      .def("chunks", &Stream::chunks, py::arg("group") = py::none())
      .def_property_readonly("byte_count", &Stream::bytes_in_all)
      .def("read_at", &Stream::read_at, py::arg("offset"), py::arg("size"));
}

} // namespace fvv::python
