#include "fvvdemux/demux.h"
#include "cli/cli.h"
#include "cli/output.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/parallel.h"
#include "fvv_demux/data.h"
#include "fvv_demux/meshes.h"
#include "fvv_demux/sounds.h"
#include "fvv_demux/views.h"
#include "fvvdemux/animations.h"
#include "fvvdemux/films.h"
#include "fvvdemux/group.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

namespace fvv::demux {

namespace {

using Json = nlohmann::json;

// Metadata is untrusted text: deeper levels than needed are not built.
Json parse(const fvv_text &text) {
  const auto shallow = [](int depth, Json::parse_event_t, Json &) { return depth <= 2; };
  return Json::parse(text.text, text.text + text.size, shallow, false);
}

std::optional<int64_t> integer(const Json &object, const char *key, int64_t least) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_integer()) return {};
  if (found->is_number_unsigned() && found->get<uint64_t>() > uint64_t(INT32_MAX)) return {};
  const int64_t value = found->get<int64_t>();
  return value < least || value > INT32_MAX ? std::optional<int64_t>() : value;
}

scene::Pattern pattern(const std::string &text) {
  std::string what;
  return scene::Pattern::parse(text, &what).value();
}

// duration = ticks * time base, in lowest terms; none if it does not fit.
std::optional<fvv_rational> seconds(uint64_t ticks, const fvv_rational &base) {
  if (!ticks) return {};
  // Dividing crosswise first keeps the product small: base need not be in lowest terms.
  const uint64_t own = std::gcd(uint64_t(base.numerator), uint64_t(base.denominator));
  const uint64_t numerator = base.numerator / own, denominator = base.denominator / own;
  const uint64_t common = std::gcd(ticks, denominator);
  const uint64_t left = ticks / common;
  if (left > UINT32_MAX || left * numerator > UINT32_MAX) return {};
  return fvv_rational{uint32_t(left * numerator), uint32_t(denominator / common)};
}

} // namespace

FileNumbers file_numbers(const fvv_configuration &configuration, int64_t count,
                         std::vector<std::string> &warnings) {
  for (size_t i = 0; i < configuration.metadata_count; i++) {
    const Json document = parse(configuration.metadata[i]);
    if (!document.is_object() || !document.contains("frame_numbers")) continue;
    const Json &numbers = document["frame_numbers"];
    const auto first = integer(numbers, "first", 0), step = integer(numbers, "step", 1);
    // Both factors are below 2^31.
    if (first && step && *first + *step * (count - 1) <= INT32_MAX) return {*first, *step};
    warnings.push_back("frame_numbers in the stream's metadata do not number " + std::to_string(count) +
                       " frames: file names count from 0");
    return {};
  }
  return {};
}

std::optional<scene::Seconds> sound_offset(int64_t tick, const fvv_rational &base,
                                           const media::SoundPackets &packets) {
  __extension__ using Wide = __int128;
  const uint32_t rate = packets.format.rate;
  Wide numerator = Wide(tick) * base.numerator * rate -
                   Wide(packets.start + packets.format.delay()) * base.denominator,
       denominator = Wide(base.denominator) * rate;
  for (Wide a = numerator < 0 ? -numerator : numerator, b = denominator; b;) {
    const Wide rest = a % b;
    a = b;
    b = rest;
    if (b) continue;
    numerator /= a;
    denominator /= a;
  }
  if (numerator > UINT32_MAX || -numerator > UINT32_MAX || denominator > UINT32_MAX) return {};
  return scene::Seconds{int64_t(numerator), uint32_t(denominator)};
}

namespace {

std::string numbered(const View &view, const VideoViews &track, const Options &options) {
  return view.folder + "/%04d." + extension_of(files_of(options.pictures, track.video->config));
}

} // namespace

scene::Capture describe_scene(const fvv_configuration &configuration, const Options &options) {
  scene::Capture out;
  out.path = "capture.json";
  out.scale_unknown = (configuration.scene.flags & FVV_SCENE_SCALE_UNKNOWN) != 0;
  out.up = configuration.scene.up_axis;
  const fvv_scene &scene = configuration.scene;
  out.lattice = lattice_of(scene.lattice_origin, scene.lattice_step);
  const bool described =
      options.meshes == Meshes::ply || options.meshes == Meshes::obj || options.meshes == Meshes::drc;
  if (described && mesh_track_of(configuration, options.rung, nullptr))
    out.meshes = pattern(options.meshes == Meshes::ply   ? "meshes/%04d.ply"
                         : options.meshes == Meshes::obj ? "meshes/%04d.obj"
                                                         : "meshes/%04d.drc");
  std::vector<VideoViews> tracks;
  if (options.pictures != Pictures::none)
    tracks = views_of(configuration, options.rung, options.cameras, nullptr);
  for (const VideoViews &track : tracks)
    for (const View &view : track.views)
      if (view.tile.camera_id == no_camera && out.meshes)
        out.atlas = {pattern(numbered(view, track, options)), {}};
  for (size_t i = 0; i < configuration.camera_count; i++) {
    const fvv_camera &source = configuration.cameras[i];
    if (!options.cameras.has(source.id)) continue;
    scene::Camera camera;
    camera.calibration = source;
    for (const VideoViews &track : tracks)
      for (const View &view : track.views)
        if (view.tile.camera_id == source.id) {
          camera.calibration = fvv_camera_of_tile(&source, &view.whole);
          camera.pictures = pattern(numbered(view, track, options));
        }
    camera.calibration.flags = 0; // per_frame says it
    camera.set_name(std::string(source.name ? source.name : "", source.name_size));
    out.cameras.push_back(camera);
  }
  return out;
}

void describe_motion(const fvv_configuration &configuration, const Options &options,
                     const std::vector<WrittenFrame> &frames, const FileNumbers &numbers,
                     scene::Capture &capture) {
  std::map<uint16_t, fvv_tile> tiles;
  if (options.pictures != Pictures::none)
    for (const VideoViews &track : views_of(configuration, options.rung, options.cameras, nullptr))
      for (const View &view : track.views) tiles.emplace(view.tile.camera_id, view.whole);
  for (scene::Camera &camera : capture.cameras) {
    const uint16_t id = camera.calibration.id;
    const fvv_camera *source = fvv_configuration_camera(&configuration, id);
    if (!source || !(source->flags & FVV_CAMERA_MOVES)) continue;
    for (const WrittenFrame &frame : frames) {
      const int64_t number = numbers.of(frame.number);
      const auto found = frame.moving.find(id);
      if (found == frame.moving.end()) {
        camera.lost.insert(number);
        continue;
      }
      fvv_camera now = found->second;
      now.flags = 0;
      const auto tile = tiles.find(id);
      if (tile != tiles.end()) now = fvv_camera_of_tile(&now, &tile->second);
      camera.per_frame[number] = now;
    }
  }
}

namespace {

// capture.json names each place without a frame; two damaged times can be 2^31 places apart.
constexpr uint64_t most_places_left = 1 << 20; // 11.6 hours of 25 frames per second

} // namespace

std::vector<int64_t> places_of(fvv_stream *stream, int64_t &end) {
  const size_t groups = fvv_stream_group_count(stream), count = fvv_stream_frame_count(stream);
  const fvv_configuration *configuration = nullptr;
  if (!count || fvv_stream_index_state(stream) != FVV_INDEX_PRESENT ||
      fvv_stream_group(stream, 0)->sequence ||
      fvv_stream_configuration(stream, 0, &configuration, nullptr) != FVV_OK)
    return {};
  const auto duration = uint64_t(configuration->scene.frame_duration),
             start = uint64_t(fvv_stream_group(stream, 0)->start);
  const uint64_t span = uint64_t(fvv_stream_group(stream, groups - 1)->end) - start;
  if (span % duration || span / duration <= count || span / duration > uint64_t(INT32_MAX) ||
      span / duration - count > most_places_left)
    return {};
  std::vector<int64_t> places;
  for (size_t i = 0; i < count; i++) {
    fvv_frame frame;
    if (fvv_stream_frame(stream, i, &frame, nullptr) != FVV_OK) return {};
    const uint64_t since = uint64_t(frame.time) - start;
    if (since % duration) return {};
    places.push_back(int64_t(since / duration));
  }
  end = int64_t(span / duration);
  return places;
}

namespace {

// What numbers of files have no more than.
constexpr double furthest_place = 2147483648.0;

// Of a stream all of whose frames were written, and in which some places have no frame.
FrameSpan span_with_gaps(const std::vector<WrittenFrame> &frames, const FileNumbers &numbers, int64_t ticks,
                         bool meshes_alone) {
  FrameSpan out = {{numbers.first, numbers.end, numbers.step}, {}};
  std::set<int64_t> left_out;
  size_t next = 0;
  for (int64_t place = 0; place < numbers.end; place++) {
    const int64_t number = numbers.first + numbers.step * place;
    if (next < frames.size() && numbers.place(frames[next].number) == place) {
      if (frames[next++].empty) out.empty.insert(number);
      continue;
    }
    const WrittenFrame *before = next ? &frames[next - 1] : nullptr;
    const bool valid =
        before && (place - numbers.place(before->number)) * ticks < before->valid_until - before->time;
    (meshes_alone && !valid ? out.empty : left_out).insert(number);
  }
  out.frames.leave_out(left_out);
  return out;
}

} // namespace

std::optional<FrameSpan> span_of(const std::vector<WrittenFrame> &frames, const FileNumbers &numbers,
                                 const fvv_scene &scene, std::string &reason, bool meshes_alone) {
  for (const WrittenFrame &frame : frames)
    if (!frame.complete && reason.empty())
      reason = "frame " + std::to_string(frame.number) + " has not all files that other frames have";
  if (frames.empty() && reason.empty()) reason = "no frame has a file of its own";
  if (!reason.empty()) return {};
  if (!numbers.places.empty() && frames.size() == numbers.places.size()) {
    FrameSpan out = span_with_gaps(frames, numbers, scene.frame_duration, meshes_alone);
    const auto duration = seconds(uint64_t(scene.frame_duration), scene.time_base);
    if (!duration) reason = "its frame rate is no fraction of 32-bit numbers";
    if (duration) out.duration = *duration;
    return reason.empty() ? std::optional(std::move(out)) : std::nullopt;
  }
  for (const WrittenFrame &frame : frames)
    if (std::abs(double(numbers.place(frame.number))) > furthest_place) {
      reason = "frame " + std::to_string(frame.number) + " is further from the first than 2^31 frames";
      return {};
    }
  const int64_t count = int64_t(frames.size()), first = numbers.place(frames[0].number);
  const int64_t stride = count > 1 ? numbers.place(frames[1].number) - first : 1;
  const uint64_t ticks =
      count > 1 ? uint64_t(frames[1].time) - uint64_t(frames[0].time) : uint64_t(scene.frame_duration);
  for (int64_t i = 0; i < count; i++) {
    const WrittenFrame &frame = frames[size_t(i)];
    if (numbers.place(frame.number) != first + i * stride)
      reason = "no step leads from frame to frame";
    else if (uint64_t(frame.time) != uint64_t(frames[0].time) + ticks * uint64_t(i))
      reason = "the frames are not evenly spaced in time";
    if (!reason.empty()) return {};
  }
  const auto duration = seconds(ticks, scene.time_base);
  if (!duration) {
    reason = "its frame rate is no fraction of 32-bit numbers";
    return {};
  }
  FrameSpan out = {{numbers.first + numbers.step * first, count, numbers.step * stride}, *duration};
  for (const WrittenFrame &frame : frames)
    if (frame.empty) out.empty.insert(numbers.of(frame.number));
  return out;
}

namespace {

// Streams that threads take and give back: opening one reads the index.
class Streams {
public:
  explicit Streams(const InputFile &input) : file(input) {}
  Stream take() {
    {
      const std::lock_guard<std::mutex> guard(lock);
      if (!idle.empty()) {
        Stream stream = std::move(idle.back());
        idle.pop_back();
        return stream;
      }
    }
    return open_stream(file);
  }
  void give(Stream stream) {
    const std::lock_guard<std::mutex> guard(lock);
    idle.push_back(std::move(stream));
  }
  // All have been given back.
  const std::vector<Stream> &all() const { return idle; }

private:
  const InputFile &file;
  std::mutex lock;
  std::vector<Stream> idle;
};

std::string ids_of(const fvv_configuration &configuration) {
  std::string out;
  for (size_t i = 0; i < configuration.camera_count; i++)
    out += (i ? ", " : "") + std::to_string(configuration.cameras[i].id);
  return out.empty() ? "none" : out;
}

void check_cameras(const fvv_configuration &configuration, const Selection &cameras) {
  for (const auto &range : cameras.within(0, INT32_MAX))
    for (int64_t id = range.first; id <= range.last && !cameras.everything(); id++)
      if (id > UINT16_MAX || !fvv_configuration_camera(&configuration, uint16_t(id)))
        throw Error("--cameras: camera " + std::to_string(id) + " is not in the stream, which has " +
                        ids_of(configuration),
                    Error::usage);
}

// The first configuration that can be read. It gives the file numbers for any selection of frames.
const fvv_configuration *first_configuration(fvv_stream *stream) {
  uint64_t tried = 0;
  for (size_t g = 0; g < fvv_stream_group_count(stream); g++) {
    const uint64_t offset = fvv_stream_group(stream, g)->configuration_offset;
    const fvv_configuration *configuration;
    if (offset == tried) continue;
    if (fvv_stream_configuration(stream, g, &configuration, nullptr) == FVV_OK) return configuration;
    tried = offset;
  }
  return nullptr;
}

// As many groups at a time as memory allows. Error, naming the track, when it does not allow one.
uint32_t threads_within_memory(fvv_stream *stream, const std::string &name, const Plan &plan,
                               const Options &options) {
  if (options.pictures == Pictures::none) return options.threads;
  uint64_t most = 1, last = 0;
  for (const GroupPlan &group : plan.groups) {
    const fvv_configuration *configuration;
    const uint64_t offset = fvv_stream_group(stream, group.group)->configuration_offset;
    if (offset == last || fvv_stream_configuration(stream, group.group, &configuration, nullptr) != FVV_OK)
      continue;
    last = offset;
    const auto tracks = views_of(*configuration, options.rung, options.cameras, nullptr);
    most = std::max(most, decoding_memory(name, tracks, options.memory));
  }
  return uint32_t(std::clamp<uint64_t>(options.memory.bytes / most, 1, options.threads));
}

class DemuxRun {
public:
  DemuxRun(const std::string &input, const Options &chosen, Result &out)
      : result(out), options(chosen), file(input),
        survey(file, nullptr,
               [this](const fvv_configuration &configuration, const fvv_track &track) {
                 return writes_track(configuration, track, options.rung);
               }),
        stream(open_stream(file)), plan(make_plan(stream.get(), file, options.frames, survey)) {
    const int64_t last = options.frames.everything() ? -1 : options.frames.largest();
    if (last >= plan.count && !plan.rebuilt)
      throw Error("--frames: frame " + std::to_string(last) + " is not in the stream, which has " +
                      std::to_string(plan.count),
                  Error::usage);
    const fvv_configuration *configuration = first_configuration(stream.get());
    if (configuration) {
      check_cameras(*configuration, options.cameras);
      int64_t end = std::max<int64_t>(plan.count, 1);
      std::vector<int64_t> places = places_of(stream.get(), end);
      numbers = file_numbers(*configuration, end, result.warnings);
      numbers.places = std::move(places);
      numbers.end = end;
      if (options.meshes != Meshes::none) mesh_track_of(*configuration, options.rung, &result.warnings);
      if (options.pictures != Pictures::none)
        views_of(*configuration, options.rung, options.cameras, &result.warnings);
    }
    if (options.mp4) check_whole_groups(plan, options.frames);
    threads = threads_within_memory(stream.get(), file.path(), plan, options);
    result.frames_in_stream = plan.count;
  }

  void unpack(cli::OutputFolder &folder) {
    const FileName name = file_name();
    Streams streams(file);
    std::vector<GroupResult> results(plan.groups.size());
    cli::Progress progress(file.path(), plan.groups.size(), "groups");
    fvv::parallel(
        threads, plan.groups.size(),
        [&](size_t i) {
          Stream own = streams.take();
          results[i] = unpack_group(own.get(), plan.groups[i], options, survey, name, folder);
          streams.give(std::move(own));
        },
        [&] { progress.step(); });
    for (const Stream &one : streams.all()) note_damage(one.get());
    note_damage(stream.get());
    for (size_t i = 0; i < results.size(); i++) {
      if (!results[i].frames.empty()) used.push_back(plan.groups[i].group);
      frames.insert(frames.end(), results[i].frames.begin(), results[i].frames.end());
      result.local_origin = result.local_origin || results[i].local_origin;
      plan.losses.insert(plan.losses.end(), results[i].losses.begin(), results[i].losses.end());
      for (const auto &[camera, count] : results[i].pictures)
        (camera == no_camera ? result.atlases : result.pictures[camera]) += count;
    }
  }

  void write_animations(cli::OutputFolder &folder) {
    if (options.meshes == Meshes::gltf)
      result.mesh_files =
          fvv::demux::write_animations(stream.get(), plan, frames, options, file_name(), folder, result);
    else
      for (const WrittenFrame &frame : frames) result.mesh_files += frame.mesh;
  }

  void write_films(cli::OutputFolder &folder) {
    if (options.mp4)
      result.films = fvv::demux::write_films(stream.get(), file.path(), plan, options, folder, result);
  }

  void tell() {
    result.frames_written = int64_t(frames.size());
    for (const WrittenFrame &frame : frames) result.meshes += frame.mesh;
    std::vector<std::string> &lines = result.losses;
    if (plan.rebuilt) lines.push_back(file.path() + ": the index was rebuilt: " + plan.rebuilt_why);
    std::sort(plan.losses.begin(), plan.losses.end(),
              [](const Loss &a, const Loss &b) { return a.first < b.first; });
    for (const Loss &loss : plan.losses)
      for (const auto &range : options.frames.within(loss.first, loss.last))
        lines.push_back(file.path() +
                        (range.first == range.last ? ": frame " + std::to_string(range.first) + " is lost: "
                                                   : ": frames " + std::to_string(range.first) + " to " +
                                                         std::to_string(range.last) + " are lost: ") +
                        loss.why);
    if (!options.frames.everything() && options.frames.largest() >= plan.count)
      lines.push_back(file.path() + ": frames from " + std::to_string(plan.count) +
                      " on are not in what is left of the stream");
    if (!plan.uncertain.empty()) lines.push_back(file.path() + ": " + plan.uncertain);
    for (const auto &[offset, text] : damage)
      if (std::none_of(lines.begin(), lines.end(), [what = text](const std::string &line) {
            return line.find(what) != std::string::npos;
          }))
        lines.push_back(file.path() + ": " + text);
  }

  void check_written() const {
    if (result.meshes || result.atlases || result.films || !result.pictures.empty()) return;
    throw Error(file.path() + ": " +
                (frames.empty() && !result.losses.empty() ? "no frame is whole"
                 : frames.empty()                         ? "the stream has no frames"
                                                          : "nothing of what was selected is in the stream") +
                ": nothing written");
  }

  void describe(cli::OutputFolder &folder) {
    std::string reason;
    auto capture = capture_of(reason);
    if (const auto environment = write_environment(folder); environment && capture)
      capture->environment = environment;
    if (options.sound && !used.empty()) write_sounds(folder, capture ? &*capture : nullptr);
    if (options.data && !used.empty()) write_data(folder);
    result.capture = capture.has_value();
    if (capture)
      folder.write("capture.json", scene::format_capture(*capture));
    else
      result.warnings.push_back("no capture.json: " + reason);
  }

private:
  FileName file_name() const {
    return [this](const std::string &sub, int64_t number, const char *extension) {
      return pattern(sub + "/%04d." + extension).file(numbers.of(number));
    };
  }

  // What the index shows as whole and is not, such as a configuration block that a repetition replaces.
  void note_damage(const fvv_stream *one) {
    for (size_t i = 0; !plan.rebuilt && i < fvv_stream_damage_count(one); i++)
      damage.emplace(fvv_stream_damage(one, i)->offset, text_of(*fvv_stream_damage(one, i)));
  }

  std::optional<scene::Capture> capture_of(std::string &reason) {
    std::optional<scene::Capture> out;
    std::string text;
    fvv_scene scene = {};
    uint64_t seen = 0;
    for (const size_t group : used) {
      const uint64_t offset = fvv_stream_group(stream.get(), group)->configuration_offset;
      if (offset == seen) continue;
      seen = offset;
      const fvv_configuration *configuration;
      fvv_diagnostic diagnostic = {};
      fvv::check(fvv_stream_configuration(stream.get(), group, &configuration, &diagnostic), file.path(),
                 diagnostic);
      const scene::Capture described = describe_scene(*configuration, options);
      const std::string own = scene::format_capture(described);
      if (out && own != text) {
        reason = "cameras change within the stream";
        return {};
      }
      if (out) continue;
      out = described;
      text = own;
      scene = configuration->scene;
    }
    if (!plan.uncertain.empty()) {
      reason = plan.uncertain;
      return {};
    }
    if (!out) { // films come from groups without a whole frame, too
      reason = "no frame is whole";
      return {};
    }
    const bool meshes_alone = out->meshes && !out->atlas &&
                              std::none_of(out->cameras.begin(), out->cameras.end(),
                                           [](const auto &camera) { return camera.pictures.has_value(); });
    const auto span = span_of(frames, numbers, scene, reason, meshes_alone);
    if (!span) return {};
    describe_moving(*out);
    if (out->atlas) describe_texture(*out);
    out->frames = span->frames;
    out->frame_duration = span->duration;
    if (out->meshes) out->empty = span->empty;
    return out;
  }

  // That of the first frames written: within a configuration there is one.
  std::optional<scene::EnvironmentSource> write_environment(cli::OutputFolder &folder) {
    const fvv_configuration *configuration;
    if (!options.environment || used.empty() ||
        fvv_stream_configuration(stream.get(), used[0], &configuration, nullptr) != FVV_OK)
      return {};
    std::vector<std::string> lost;
    const UnpackedEnvironment environment = unpack_environment(stream.get(), used[0], *configuration, lost);
    for (const std::string &why : lost)
      result.losses.push_back(file.path() + ": the environment is lost: " + why);
    if (environment.environment.parts.empty()) return {}; // lights alone are not a valid glTF file
    bool is_local = false;
    folder.write("environment.glb", scene::format_environment(environment.environment, *environment.lattice,
                                                              "environment.glb", &is_local));
    result.local_origin = result.local_origin || is_local;
    result.environment = true;
    return scene::EnvironmentSource{"environment.glb", {}, environment.lattice};
  }

  // Of the groups of the frames that were written; capture: takes their description, unless it is NULL.
  void write_sounds(cli::OutputFolder &folder, scene::Capture *capture) {
    const UnpackedSounds unpacked = unpack_sounds(file, used.front(), used.back());
    for (const std::string &why : unpacked.losses) result.losses.push_back(file.path() + ": " + why);
    std::map<uint16_t, int> parts; // of tracks with gaps
    for (const UnpackedSound &sound : unpacked.sounds) {
      const int part = ++parts[sound.track];
      const std::string name = "audio/" + std::to_string(sound.track) +
                               (part > 1 ? "_" + std::to_string(part) : "") + "." +
                               media::sound_extension(sound.packets.format.codec);
      folder.write(name, media::sound_file(sound.packets));
      result.sounds++;
      if (!capture) continue;
      if (auto source = describe_sound(sound, name, *capture))
        capture->sounds.push_back(std::move(*source));
      else
        result.warnings.push_back(name +
                                  " is not in capture.json: its offset is no fraction of 32-bit numbers");
    }
  }

  // Payloads as they were sent, by track: data/TRACK/NUMBER.
  void write_data(cli::OutputFolder &folder) {
    const auto write = [&](const UnpackedData &data) {
      folder.write("data/" + std::to_string(data.track) + "/" +
                       fvv::format("%06llu.", (unsigned long long)data.number) + data_extension(data.type),
                   {reinterpret_cast<const char *>(data.payload), data.size});
      result.data++;
    };
    for (const std::string &why : unpack_data(file, used.front(), used.back(), write))
      result.losses.push_back(file.path() + ": " + why);
  }

  // The file begins with the first packet; after the codec's delay it counts from 0.
  std::optional<scene::SoundSource> describe_sound(const UnpackedSound &sound, const std::string &name,
                                                   const scene::Capture &capture) {
    const fvv_configuration *configuration;
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_stream_configuration(stream.get(), used[0], &configuration, &diagnostic), file.path(),
               diagnostic);
    const fvv_rational &base = configuration->scene.time_base;
    const auto offset = sound_offset(frames.front().time, base, sound.packets);
    if (!offset) return {};
    scene::SoundSource out;
    out.file = name;
    out.offset = *offset;
    out.first = capture.frames.first;
    out.title = sound.title;
    out.language = scene::is_language(sound.language) ? sound.language : "";
    out.position = sound.position;
    if (sound.places.empty()) return out;
    const int64_t ticks = configuration->scene.frame_duration;
    for (int64_t i = 0; i < capture.frames.count; i++) {
      const int64_t tick = frames.size() == size_t(capture.frames.count)
                               ? frames[size_t(i)].time
                               : frames.front().time + ticks * capture.frames.place(i);
      out.per_frame[capture.frames.number(i)] = sound.position_at(tick);
    }
    return out;
  }

  void describe_moving(scene::Capture &capture) {
    const fvv_configuration *configuration;
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_stream_configuration(stream.get(), used[0], &configuration, &diagnostic), file.path(),
               diagnostic);
    describe_motion(*configuration, options, frames, numbers, capture);
  }

  // A capture's atlas is one for the texture coordinates of all its meshes.
  void describe_texture(scene::Capture &capture) const {
    uint8_t bits = 0;
    for (const WrittenFrame &frame : frames) bits = bits ? bits : frame.texture_bits;
    for (const WrittenFrame &frame : frames)
      if (frame.empty) {
        continue;
      } else if (!frame.texture_bits) {
        result.warnings.push_back("the atlas is not in capture.json: the mesh of frame " +
                                  std::to_string(frame.number) + " has no texture coordinates");
        return capture.atlas.reset();
      } else if (frame.texture_bits != bits) {
        return; // they change within the stream: packed again, the muxer chooses
      }
    capture.atlas->texture_bits = bits;
  }

  Result &result;
  const Options &options;
  const InputFile file;
  LazySurvey survey;
  Stream stream;
  Plan plan;
  FileNumbers numbers;
  uint32_t threads = 1;
  std::vector<WrittenFrame> frames;
  std::map<uint64_t, std::string> damage; // by offset
  std::vector<size_t> used;               // groups of written frames
};

} // namespace

void demux(const std::string &input, const std::string &folder_name, const Options &options, Result &result) {
  if (options.meshes == Meshes::none && options.pictures == Pictures::none && !options.mp4)
    throw Error("--meshes none and --pictures none leave nothing to write", Error::usage);
  const bool is_glb = options.meshes == Meshes::glb || options.meshes == Meshes::gltf;
  if (options.compression != scene::Compression::none && !is_glb)
    throw Error("--compress: expected --meshes glb or gltf: other files are not glTF", Error::usage);
  if (options.compression == scene::Compression::draco && options.meshes == Meshes::gltf)
    throw Error("--compress draco: Draco cannot compress the animation of --meshes gltf; pass --compress "
                "meshopt, or --meshes glb for a file of each frame",
                Error::usage);
  DemuxRun run(input, options, result);
  cli::OutputFolder folder(folder_name, options.force, cli::inputs({input}));
  run.unpack(folder);
  run.write_animations(folder);
  run.write_films(folder);
  run.tell();
  run.check_written();
  run.describe(folder);
  if (result.local_origin)
    result.warnings.push_back(
        "positions in glTF files are relative to an origin, in the translation of their node and its extras: "
        "they are too large for float32, in which most viewers compute; leave the translation out there");
  folder.commit();
}

} // namespace fvv::demux
