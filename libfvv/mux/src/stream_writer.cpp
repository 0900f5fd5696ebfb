#include "mux/src/stream_writer.h"
#include "fvv/mesh.h"
#include "fvv_cxx/error.h"
#include "fvv_scene/file_io.h"
#include "mux/src/choose/choices.h"
#include "mux/src/environment.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace fvv::mux {

fvv_camera described(const scene::Capture &capture, const scene::Camera &camera) {
  fvv_camera out = camera.calibration;
  for (int64_t i = capture.frames.count; camera.moves() && i-- > 0;)
    if (camera.is_calibrated(capture.frames.number(i))) out = camera.calibration_at(capture.frames.number(i));
  out.flags = camera.moves() ? FVV_CAMERA_MOVES : 0;
  return out;
}

bool any_moves(const scene::Capture &capture) {
  return std::any_of(capture.cameras.begin(), capture.cameras.end(), [](const auto &c) { return c.moves(); });
}

std::vector<fvv_camera> MovingCameras::cameras_at(int64_t number) const {
  std::vector<fvv_camera> out;
  for (const scene::Camera &camera : capture.cameras)
    if (camera.moves() && camera.is_calibrated(number)) out.push_back(camera.calibration_at(number));
  return out;
}

MovingCameras::MovingCameras(const scene::Capture &source, double lattice_step)
    : capture(source), encoder(nullptr, fvv_calibration_destroy) {
  std::vector<fvv_camera> all;
  for (const scene::Camera &camera : capture.cameras) constant.push_back(described(capture, camera));
  for (const int64_t number : capture.frames.numbers())
    for (const fvv_camera &camera : cameras_at(number)) all.push_back(camera);
  fvv_calibration_choose(all.data(), all.size(), lattice_step / 128, calibration_error, &bits);
  fvv_calibration *created = nullptr;
  const fvv_status status = fvv_calibration_create(constant.data(), constant.size(), nullptr, &created);
  encoder.reset(created);
  fvv::check(status, capture.path, {});
}

// The values of a CALB do not depend on earlier ones, only their coding does.
std::vector<fvv_camera> MovingCameras::decoded(size_t frame) const {
  std::vector<fvv_camera> cameras = cameras_at(capture.frames.number(int64_t(frame)));
  fvv_calibration *created = nullptr;
  fvv_diagnostic diagnostic = {};
  OwnedBytes scratch;
  fvv_status status = fvv_calibration_create(constant.data(), constant.size(), nullptr, &created);
  const decltype(encoder) key(created, fvv_calibration_destroy);
  if (status == FVV_OK)
    status =
        fvv_calibration_encode(created, &bits, cameras.data(), cameras.size(), true, &scratch, &diagnostic);
  fvv::check(status, capture.path, diagnostic);
  for (fvv_camera &camera : cameras)
    fvv::check(fvv_calibration_camera(created, camera.id, &camera), capture.path, {});
  return cameras;
}

const fvv_bytes &MovingCameras::payload(size_t frame, bool key) {
  const int64_t number = capture.frames.number(int64_t(frame));
  const std::vector<fvv_camera> cameras = cameras_at(number);
  fvv_diagnostic diagnostic = {};
  const fvv_status status =
      fvv_calibration_encode(encoder.get(), &bits, cameras.data(), cameras.size(), key, &bytes, &diagnostic);
  if (status < 0) throw Error(capture.path + ": frame " + std::to_string(number) + ": " + diagnostic.message);
  return bytes;
}

namespace {

// A record from one of libfvv's encoders, which return the required size.
template <class Encode> std::vector<uint8_t> record(const std::string &name, const Encode &encode) {
  std::vector<uint8_t> out;
  size_t size = 0;
  fvv_diagnostic diagnostic = {};
  fvv_status status = encode(nullptr, 0, &size, &diagnostic);
  if (status == FVV_ERROR_BUFFER_TOO_SMALL) {
    out.resize(size);
    diagnostic = {};
    status = encode(out.data(), out.size(), &size, &diagnostic);
  }
  fvv::check(status, name, diagnostic);
  return out;
}

} // namespace

// No exception may cross libfvv: it is kept here until the writer has returned.
fvv_status StreamWriter::write(void *user, const void *bytes, size_t size) {
  auto *self = static_cast<StreamWriter *>(user);
  try {
    self->sink(bytes, size);
    return FVV_OK;
  } catch (...) {
    self->failure = std::current_exception();
    return FVV_ERROR_IO;
  }
}

StreamWriter::StreamWriter(const Plan &chosen, const Decisions &decided, const Sink &out_of_here)
    : plan(chosen), decisions(decided), sink(out_of_here), sound_bytes(chosen.sounds.size()),
      writer(nullptr, fvv_writer_destroy) {
  check_groups();
  if (any_moves(plan.capture)) moving.emplace(plan.capture, plan.lattice.lattice.step);
  // First to nowhere: when a record is refused, the output has received no byte.
  open({[](void *, const void *, size_t) { return fvv_status(FVV_OK); }, nullptr});
  write_configuration();
  open({write, this});
  write_configuration();
}

// What the writer would refuse hours later.
void StreamWriter::check_groups() const {
  fvv_limits limits;
  fvv_limits_default(&limits);
  const auto check_count = [&](uint64_t count, uint32_t most, const std::string &what, const char *way_out) {
    if (count > most)
      throw Error(plan.capture.path + ": " + std::to_string(count) + " " + what +
                      ", readers accept at most " + std::to_string(most) + ": choose " + way_out,
                  Error::usage);
  };
  uint64_t frames = 0;
  for (const GroupSpan &group : plan.groups) frames = std::max<uint64_t>(frames, group.count);
  const auto meshes = std::count_if(decisions.meshes.begin(), decisions.meshes.end(),
                                    [](const MeshDecision &track) { return track.sent; });
  const uint64_t in_a_frame = uint64_t(meshes) * (1 + decisions.visibility.on + plan.colours.on) +
                              plan.tracks.size() + any_moves(plan.capture) + (plan.environment != nullptr) +
                              plan.sounds.size() + plan.data.size();
  // Besides GRUP, and a layout for each track.
  check_count(1 + plan.tracks.size() + frames * in_a_frame, limits.max_group_chunks,
              "chunks in a group of " + std::to_string(frames) + " frames", "fewer frames in a group");
  check_count(plan.group_count(), limits.max_groups, "groups", "more frames in a group");
}

void StreamWriter::open(const fvv_output &output) {
  fvv_writer *created = nullptr;
  const fvv_status status = fvv_writer_create(&output, nullptr, &created, &diagnostic);
  writer.reset(created);
  check(status);
}

void StreamWriter::check(fvv_status status) {
  if (status >= 0) return;
  if (failure) std::rethrow_exception(failure);
  fvv::check(status, "output", diagnostic);
}

void StreamWriter::configure(uint32_t type, uint16_t track, const std::vector<uint8_t> &payload) {
  check(fvv_writer_configuration(writer.get(), type, track, 0, payload.data(), payload.size(), &diagnostic));
}

void StreamWriter::write_track(uint16_t id, uint8_t kind, const std::string &name, const VideoTrack *video) {
  fvv_track track = {};
  track.id = id;
  track.kind = kind;
  track.name = name.data();
  track.name_size = name.size();
  track.bit_rate = rate_of(id);
  if (video && video->alternate_group) {
    track.alternate_group = video->alternate_group;
    track.rank = uint16_t(video->rung);
    track.size = video->tiling.width * video->tiling.height;
  }
  write_track(track);
}

uint32_t StreamWriter::rate_of(uint16_t id) const {
  const auto rate = decisions.nominal.rates.find(id);
  return rate == decisions.nominal.rates.end()
             ? 0
             : uint32_t(std::clamp(std::round(rate->second), 1.0, double(UINT32_MAX)));
}

bool StreamWriter::is_sent(const MeshTrack &track) const {
  return decisions.meshes[size_t(&track - plan.meshes.data())].sent;
}

void StreamWriter::write_mesh_track(const MeshTrack &mesh, uint8_t kind) {
  fvv_track track = {};
  track.kind = kind;
  track.id = kind == FVV_TRACK_MESH ? mesh.id : kind == FVV_TRACK_VISIBILITY ? mesh.visibility : mesh.colours;
  std::string name = kind == FVV_TRACK_MESH         ? "mesh"
                     : kind == FVV_TRACK_VISIBILITY ? "visibility"
                                                    : "colours";
  if (mesh.rung) name += ", rung " + std::to_string(mesh.rung);
  if (mesh.rung && kind == FVV_TRACK_MESH) name += ", error " + budget_text(plan, mesh.times);
  track.name = name.data();
  track.name_size = name.size();
  track.bit_rate = rate_of(track.id);
  if (decisions.has_mesh_rungs(plan)) {
    const auto videos = std::count_if(plan.tracks.begin(), plan.tracks.end(),
                                      [](const VideoTrack &video) { return !video.rung; });
    track.alternate_group = uint16_t(videos + (kind == FVV_TRACK_MESH         ? 1
                                               : kind == FVV_TRACK_VISIBILITY ? 2
                                                                              : 3));
    track.rank = uint16_t(mesh.rung);
    if (const auto size = decisions.nominal.sizes.find(track.id); size != decisions.nominal.sizes.end())
      track.size = uint32_t(std::clamp(std::round(size->second), 1.0, double(UINT32_MAX)));
  }
  write_track(track);
}

void StreamWriter::write_track(const fvv_track &track) {
  configure(FVV_CHUNK_TRACK, track.id,
            record(plan.capture.path, [&](uint8_t *out, size_t size, size_t *written, fvv_diagnostic *d) {
              return fvv_track_encode(&track, out, size, written, d);
            }));
}

namespace {

// How far the meshes of the best rung are off their sources, as META has it (spec/registry.md); empty: there
// are none, or it is not known.
std::string mesh_error_of(const Plan &plan) {
  if (plan.meshes.empty()) return {};
  const MeshTrack &track = plan.meshes.front();
  // At any error; and what is followed and not decimated is off by more than rounding.
  if (track.decimation.on ? track.decimation.budget.triangles > 0 : plan.tracking.on) return {};
  std::string text = R"(,"mesh_error":{"vertex":)";
  scene::append_double(text, track.lattice.error());
  if (track.decimation.on) {
    text += track.decimation.is_length ? R"(,"metres":)" : R"(,"pixels":)";
    scene::append_double(text, track.decimation.budget.pixels);
  }
  return text + "}";
}

} // namespace

void StreamWriter::write_configuration() {
  const scene::Capture &capture = plan.capture;
  fvv_scene scene = {};
  scene.time_base = capture.frame_duration;
  scene.frame_duration = 1;
  std::copy_n(plan.lattice.lattice.origin, 3, scene.lattice_origin);
  scene.lattice_step = plan.lattice.lattice.step;
  scene.up_axis = capture.up;
  scene.flags = capture.scale_unknown ? FVV_SCENE_SCALE_UNKNOWN : 0;
  configure(FVV_CHUNK_SCENE, 0,
            record(capture.path, [&](uint8_t *out, size_t size, size_t *written, fvv_diagnostic *d) {
              return fvv_scene_encode(&scene, out, size, written, d);
            }));
  if (plan.has_meshes()) write_mesh_track(plan.meshes[0], FVV_TRACK_MESH);
  for (const VideoTrack *track : video_tracks())
    if (track->id < calibration_track) write_video_track(*track);
  if (moving) write_track(calibration_track, FVV_TRACK_CALIBRATION, "calibration");
  if (decisions.visibility.on) write_mesh_track(plan.meshes[0], FVV_TRACK_VISIBILITY);
  if (plan.environment) write_track(environment_track, FVV_TRACK_ENVIRONMENT, "environment");
  if (plan.colours.on) write_mesh_track(plan.meshes[0], FVV_TRACK_COLOURS);
  for (const VideoTrack *track : video_tracks())
    if (track->id > calibration_track) write_video_track(*track);
  for (const MeshTrack &track : plan.meshes) {
    if (!is_sent(track) || !track.rung) continue;
    write_mesh_track(track, FVV_TRACK_MESH);
    if (decisions.visibility.on) write_mesh_track(track, FVV_TRACK_VISIBILITY);
    if (plan.colours.on) write_mesh_track(track, FVV_TRACK_COLOURS);
  }
  for (size_t i = 0; i < plan.sounds.size(); i++) write_sound_track(i);
  for (size_t i = 0; i < plan.data.size(); i++) write_data_track(i);
  for (const scene::Camera &source : capture.cameras) {
    const fvv_camera camera = described(capture, source);
    const std::string name = capture.path + ": camera " + std::to_string(camera.id);
    configure(FVV_CHUNK_CAMERA, 0,
              record(name, [&](uint8_t *out, size_t size, size_t *written, fvv_diagnostic *d) {
                return fvv_camera_encode(&camera, out, size, written, d);
              }));
  }
  for (const VideoTrack *track : video_tracks()) write_video(*track);
  for (size_t i = 0; i < plan.sounds.size(); i++) write_sound(i);
  for (size_t i = 0; i < plan.data.size(); i++) write_data(i);
  if (const std::optional<fvv_texturing> texturing = texturing_of(plan))
    configure(FVV_CHUNK_TEXTURING, 0,
              record(capture.path, [&](uint8_t *out, size_t size, size_t *written, fvv_diagnostic *d) {
                return fvv_texturing_encode(&*texturing, out, size, written, d);
              }));
  // Not one object of nlohmann's: its destructor allocates, and ends the program where memory is short.
  const auto quoted = [](const std::string &text) { return nlohmann::json(text).dump(); };
  const std::string text =
      R"({"generator":)" + quoted(std::string("fvvmux ") + fvv_version()) + R"(,"name":)" +
      quoted(capture.name) + R"(,"frame_numbers":{"first":)" + std::to_string(capture.frames.first) +
      R"(,"step":)" + std::to_string(capture.frames.step) + "}" +
      (plan.first_view ? R"(,"view":{"camera":)" + std::to_string(*plan.first_view) + "}" : "") +
      mesh_error_of(plan) + "}";
  configure(FVV_CHUNK_METADATA, 0, {text.begin(), text.end()});
  // A text of its own: readers of the other one need not parse it.
  if (!plan.objects.empty()) configure(FVV_CHUNK_METADATA, 0, {plan.objects.begin(), plan.objects.end()});
}

std::vector<const VideoTrack *> StreamWriter::video_tracks() const {
  std::vector<const VideoTrack *> out;
  for (const VideoTrack &track : plan.tracks) out.push_back(&track);
  std::sort(out.begin(), out.end(), [](const auto *a, const auto *b) { return a->id < b->id; });
  return out;
}

void StreamWriter::write_video_track(const VideoTrack &track) {
  std::string name = track.is_atlas() ? "atlas"
                     : track.part     ? "cameras " + std::to_string(track.part + 1)
                                      : "cameras";
  if (track.rung) name += ", rung " + std::to_string(track.rung);
  write_track(track.id, FVV_TRACK_VIDEO, name, &track);
}

void StreamWriter::write_video(const VideoTrack &track) {
  media::EncodedGroup group;
  const VideoDecision &video = decisions.videos[size_t(&track - plan.tracks.data())];
  group.record = video.record;
  group.codec_string = video.codec_string;
  fvv_video_config config = media::config_of(video.settings, group);
  if (track.encoded) {
    const fvv_video_config &given = track.encoded->config;
    config.colour_primaries = given.colour_primaries;
    config.transfer_characteristics = given.transfer_characteristics;
    config.matrix_coefficients = given.matrix_coefficients;
    config.full_range = given.full_range;
  }
  config.shows = track.shows;
  configure(FVV_CHUNK_VIDEO_CONFIG, track.id,
            record(plan.capture.path, [&](uint8_t *out, size_t size, size_t *written, fvv_diagnostic *d) {
              return fvv_video_config_encode(&config, out, size, written, d);
            }));
  if (track.is_atlas()) return;
  configure(FVV_CHUNK_TILES, track.id, layout_record(track.tiling.tiles));
}

void StreamWriter::write_sound_track(size_t number) {
  const SoundTrack &sound = plan.sounds[number];
  fvv_track track = {};
  track.id = sound_track_id(number);
  track.kind = FVV_TRACK_AUDIO;
  track.time_base = time_base_of(sound);
  track.bit_rate = bit_rate_of(sound);
  track.name = sound.source.title.data();
  track.name_size = sound.source.title.size();
  write_track(track);
}

void StreamWriter::write_sound(size_t number) {
  const fvv_audio_config config = config_of(plan.sounds[number]);
  configure(FVV_CHUNK_AUDIO_CONFIG, sound_track_id(number),
            record(plan.capture.resolve(plan.sounds[number].source.file),
                   [&](uint8_t *out, size_t size, size_t *written, fvv_diagnostic *d) {
                     return fvv_audio_config_encode(&config, out, size, written, d);
                   }));
}

void StreamWriter::write_data_track(size_t number) {
  write_track(data_track_id(number), FVV_TRACK_DATA, plan.data[number].name);
}

void StreamWriter::write_data(size_t number) {
  const fvv_data_config config = config_of(plan.data[number]);
  configure(
      FVV_CHUNK_DATA_CONFIG, data_track_id(number),
      record(plan.data[number].name, [&](uint8_t *out, size_t size, size_t *written, fvv_diagnostic *d) {
        return fvv_data_config_encode(&config, out, size, written, d);
      }));
}

std::vector<uint8_t> StreamWriter::layout_record(const std::vector<fvv_tile> &tiles) const {
  return record(plan.capture.path, [&](uint8_t *out, size_t size, size_t *written, fvv_diagnostic *d) {
    return fvv_tiles_encode(tiles.data(), tiles.size(), out, size, written, d);
  });
}

void StreamWriter::join(size_t group) {
  check(fvv_writer_join(writer.get(), uint32_t(group)));
}

void StreamWriter::repeat_configuration() {
  check(fvv_writer_repeat_configuration(writer.get(), &diagnostic));
}

void StreamWriter::begin_group(size_t group) {
  const GroupSpan &span = plan.groups[group];
  check(fvv_writer_begin_group(writer.get(), span.start, span.end, &diagnostic));
}

void StreamWriter::mesh(const MeshTrack &track, size_t frame, const std::vector<uint8_t> &payload, bool key) {
  check(fvv_writer_chunk(writer.get(), FVV_CHUNK_MESH, track.id, key ? FVV_FLAG_KEY : 0, plan.tick_of(frame),
                         payload.data(), payload.size(), &diagnostic));
}

uint64_t StreamWriter::calibration(size_t frame, bool key) {
  if (!moving) return 0;
  const fvv_bytes &payload = moving->payload(frame, key);
  check(fvv_writer_chunk(writer.get(), FVV_CHUNK_CALIBRATION, calibration_track, key ? FVV_FLAG_KEY : 0,
                         plan.tick_of(frame), payload.data, payload.size, &diagnostic));
  return payload.size;
}

bool StreamWriter::layout(const VideoTrack &track, size_t group) {
  if (track.is_atlas()) return false;
  const std::vector<uint8_t> payload = layout_record(track.tiles_of(group));
  if (payload == layout_record(track.tiling.tiles)) return false;
  check(fvv_writer_chunk(writer.get(), FVV_CHUNK_TILES, track.id, FVV_FLAG_KEY,
                         plan.tick_of(plan.first_of(group)), payload.data(), payload.size(), &diagnostic));
  return true;
}

void StreamWriter::visibility(const MeshTrack &track, size_t frame, const std::vector<uint8_t> &payload,
                              bool key) {
  check(fvv_writer_chunk(writer.get(), FVV_CHUNK_VISIBILITY, track.visibility, key ? FVV_FLAG_KEY : 0,
                         plan.tick_of(frame), payload.data(), payload.size(), &diagnostic));
}

void StreamWriter::colours(const MeshTrack &track, size_t frame, const std::vector<uint8_t> &payload) {
  check(fvv_writer_chunk(writer.get(), FVV_CHUNK_COLOURS, track.colours, FVV_FLAG_KEY, plan.tick_of(frame),
                         payload.data(), payload.size(), &diagnostic));
}

void StreamWriter::sample(const VideoTrack &track, size_t frame, const media::Sample &sample) {
  check(fvv_writer_chunk(writer.get(), FVV_CHUNK_VIDEO_PACKET, track.id, sample.key ? FVV_FLAG_KEY : 0,
                         plan.tick_of(frame), sample.bytes.data(), sample.bytes.size(), &diagnostic));
}

uint64_t StreamWriter::environment(size_t frame) {
  if (!plan.environment) return 0;
  const std::vector<uint8_t> &payload = plan.environment->payload;
  check(fvv_writer_chunk(writer.get(), FVV_CHUNK_ENVIRONMENT, environment_track, FVV_FLAG_KEY,
                         plan.tick_of(frame), payload.data(), payload.size(), &diagnostic));
  return payload.size();
}

void StreamWriter::sound(const SoundChunk &chunk) {
  check(fvv_writer_chunk(writer.get(), FVV_CHUNK_AUDIO, sound_track_id(chunk.track),
                         chunk.key ? FVV_FLAG_KEY : 0, chunk.time, chunk.payload.data(), chunk.payload.size(),
                         &diagnostic));
  sound_bytes[chunk.track].add(chunk.payload.size());
}

void StreamWriter::data(const DataChunk &chunk) {
  check(fvv_writer_chunk(writer.get(), FVV_CHUNK_DATA, data_track_id(chunk.track), FVV_FLAG_KEY, chunk.time,
                         chunk.payload.data(), chunk.payload.size(), &diagnostic));
}

void StreamWriter::chunk(const fvv_chunk_header &header, const uint8_t *payload) {
  check(fvv_writer_chunk(writer.get(), header.type, header.track, header.flags, header.time, payload,
                         size_t(header.size), &diagnostic));
}

void StreamWriter::end_group() {
  check(fvv_writer_end_group(writer.get(), &diagnostic));
}

uint64_t StreamWriter::finish() {
  // Without it nothing would say that the stage stays empty till the end.
  if (const int64_t end = plan.groups.back().end; end < plan.end()) {
    check(fvv_writer_begin_group(writer.get(), end, plan.end(), &diagnostic));
    for (const SoundChunk &chunk : sound_chunks(plan, {plan.frame_count() - 1, 1, end, plan.end()}))
      sound(chunk);
    end_group();
  }
  if (!plan.options.live) check(fvv_writer_finish(writer.get(), &diagnostic));
  return fvv_writer_position(writer.get());
}

} // namespace fvv::mux
