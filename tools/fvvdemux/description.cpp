#include "fvvdemux/description.h"

#include "fvvdemux/decoded_mesh.h"
#include "fvvdemux/views.h"

#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

namespace fvv::demux {

namespace {

using Json = nlohmann::json;

// Metadata is text from outside: anything deeper than what is looked for is not even built.
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

capture::Pattern pattern(const std::string &text) {
  std::string what;
  return capture::Pattern::parse(text, &what).value();
}

// duration = ticks * time base, in lowest terms; nothing when it does not fit.
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

namespace {

std::string numbered(const View &view, const VideoViews &track, const Options &options) {
  return view.folder + "/%04d." + extension_of(files_of(options.pictures, track.video->config));
}

} // namespace

capture::Capture describe_scene(const fvv_configuration &configuration, const Options &options) {
  capture::Capture out;
  out.path = "capture.json";
  out.scale_unknown = (configuration.scene.flags & FVV_SCENE_SCALE_UNKNOWN) != 0;
  out.up = configuration.scene.up_axis;
  const fvv_scene &scene = configuration.scene;
  out.lattice = lattice_of(scene.lattice_origin, scene.lattice_step);
  if (options.meshes != Meshes::none && mesh_track_of(configuration, nullptr))
    out.meshes = pattern(options.meshes == Meshes::ply   ? "meshes/%04d.ply"
                         : options.meshes == Meshes::obj ? "meshes/%04d.obj"
                                                         : "meshes/%04d.drc");
  std::vector<VideoViews> tracks;
  if (options.pictures != Pictures::none) tracks = views_of(configuration, options.cameras, nullptr);
  for (const VideoViews &track : tracks)
    for (const View &view : track.views)
      if (view.tile.camera_id == no_camera && out.meshes)
        out.atlas = {pattern(numbered(view, track, options)), {}};
  for (size_t i = 0; i < configuration.camera_count; i++) {
    const fvv_camera &source = configuration.cameras[i];
    if (!options.cameras.has(source.id)) continue;
    capture::Camera camera;
    camera.calibration = source;
    for (const VideoViews &track : tracks)
      for (const View &view : track.views)
        if (view.tile.camera_id == source.id) {
          camera.calibration = camera_of_tile(source, view.whole);
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
                     capture::Capture &capture) {
  std::map<uint16_t, fvv_tile> tiles;
  if (options.pictures != Pictures::none)
    for (const VideoViews &track : views_of(configuration, options.cameras, nullptr))
      for (const View &view : track.views) tiles.emplace(view.tile.camera_id, view.whole);
  for (capture::Camera &camera : capture.cameras) {
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
      if (tile != tiles.end()) now = camera_of_tile(now, tile->second);
      camera.per_frame[number] = now;
    }
  }
}

std::optional<FrameSpan> span_of(const std::vector<WrittenFrame> &frames, const FileNumbers &numbers,
                                 const fvv_scene &scene, std::string &reason) {
  const int64_t count = int64_t(frames.size()), first = frames[0].number;
  const int64_t stride = count > 1 ? frames[1].number - first : 1;
  const uint64_t ticks =
      count > 1 ? uint64_t(frames[1].time) - uint64_t(frames[0].time) : uint64_t(scene.frame_duration);
  for (int64_t i = 0; i < count; i++) {
    const WrittenFrame &frame = frames[size_t(i)];
    if (!frame.complete)
      reason = "frame " + std::to_string(frame.number) + " has not all files that other frames have";
    else if (frame.number != first + i * stride)
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
  return FrameSpan{{numbers.of(first), count, numbers.step * stride}, *duration};
}

} // namespace fvv::demux
