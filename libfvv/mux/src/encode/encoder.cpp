#include "fvv_mux/encoder.h"
#include "fvv_media/video.h"
#include "fvv_scene/memory_frames.h"
#include "mux/src/encode/encode_job.h"
#include "mux/src/options/option_values.h"
#include "mux/src/sound/sound.h"

#include <algorithm>
#include <chrono>
#include <optional>

namespace fvv::mux {

namespace {

std::string words(size_t number, const char *noun) {
  return std::to_string(number) + " " + noun + (number == 1 ? "" : "s");
}

// Refuses tiles that do not fit their frame or their cameras.
void check_tiles(const Configuration &configuration, const EncodedTrack &track, const std::string &name) {
  if (!media::find_video_codec(track.config.codec)) throw Error(name + ": unknown codec", Error::usage);
  fvv_diagnostic diagnostic = {};
  check(fvv_tiles_validate(track.tiles.data(), track.tiles.size(), track.config.width, track.config.height,
                           &diagnostic),
        name, diagnostic);
  for (const fvv_tile &tile : track.tiles) {
    const auto camera =
        std::find_if(configuration.cameras.begin(), configuration.cameras.end(),
                     [&](const CameraInput &one) { return one.calibration.id == tile.camera_id; });
    const std::string which = name + ": camera " + std::to_string(tile.camera_id);
    if (camera == configuration.cameras.end()) throw Error(which + " is not configured", Error::usage);
    if (camera->pictures) throw Error(which + " has pictures besides", Error::usage);
    const fvv_rect &part = tile.source;
    if (uint32_t(part.x) + part.width > camera->calibration.width ||
        uint32_t(part.y) + part.height > camera->calibration.height)
      throw Error(which + ": the tile's source is not inside of its picture", Error::usage);
  }
}

// The configuration as a capture whose frames are in memory. Frames and calibrations that change are added to
// it.
scene::Capture describe(const Configuration &configuration,
                        const std::shared_ptr<scene::MemoryFrames> &memory) {
  scene::Capture capture;
  capture.path = "encoder";
  capture.name = configuration.name;
  capture.frame_duration = configuration.frame_duration;
  capture.frames = {0, 0, 1};
  capture.up = configuration.up;
  capture.scale_unknown = configuration.scale_unknown;
  capture.memory = memory;
  if (configuration.meshes) capture.meshes = scene::Pattern::parse("mesh %d", nullptr);
  if (!configuration.frame_duration.numerator || !configuration.frame_duration.denominator)
    throw Error("encoder: frame duration: expected a fraction above 0, found " +
                    std::to_string(configuration.frame_duration.numerator) + "/" +
                    std::to_string(configuration.frame_duration.denominator),
                Error::usage);
  for (size_t i = 0; i < configuration.cameras.size(); i++) {
    const CameraInput &input = configuration.cameras[i];
    scene::Camera camera;
    camera.calibration = input.calibration;
    camera.set_name(input.name);
    fvv_diagnostic diagnostic = {};
    check(fvv_camera_validate(&camera.calibration, &diagnostic), "encoder: camera " + std::to_string(i),
          diagnostic);
    for (const scene::Camera &other : capture.cameras)
      if (other.calibration.id == camera.calibration.id)
        throw Error("encoder: two cameras have the identifier " + std::to_string(camera.calibration.id),
                    Error::usage);
    const std::string id = std::to_string(camera.calibration.id);
    if (input.pictures) {
      camera.pictures =
          scene::PictureSource(*scene::Pattern::parse("picture of camera " + id + ", frame %d", nullptr));
      camera.pictures->memory_camera = i;
      if (input.masks) {
        camera.masks =
            scene::PictureSource(*scene::Pattern::parse("mask of camera " + id + ", frame %d", nullptr));
        camera.masks->memory_camera = i;
      }
    }
    if (input.visibility) {
      if (!configuration.meshes)
        throw Error("encoder: camera " + id + ": visibility needs meshes", Error::usage);
      camera.memory_visibility = i;
    }
    capture.cameras.push_back(std::move(camera));
  }
  capture.sounds = sounds_of(configuration.sounds);
  for (size_t i = 0; i < configuration.encoded.size(); i++)
    check_tiles(configuration, configuration.encoded[i], "encoder: encoded track " + std::to_string(i));
  return capture;
}

} // namespace

struct Encoder::State {
  Configuration configuration;
  Options options;
  Sink sink;
  Observer observer;
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  std::shared_ptr<scene::MemoryFrames> memory = std::make_shared<scene::MemoryFrames>();
  scene::Capture capture; // until the plan is made
  std::optional<Plan> plan;
  std::optional<EncodeJob> job; // of the plan
  size_t effort = 0;            // step
  size_t group_size = 1;
  bool shows_pictures = false;   // else nothing is left of a frame without a mesh
  size_t added = 0;              // frames
  size_t pending = 0;            // of these, in the stream and not in a group yet
  GroupSpan next = {0, 0, 0, 0}; // the group that they will be
  bool had_mesh = false;         // the frame before
  bool met_mesh = false;         // any frame
  size_t done = 0;               // groups that are written

  scene::Capture &description() { return plan ? plan->capture : capture; }

  // end: the first tick after it. Without a mesh there is nothing to plan by: groups wait for the first one.
  void end_group(size_t end) {
    next.count = pending;
    next.end = int64_t(end);
    if (plan) extend_plan(*plan, next);
    next = {next.first + pending, 0, next.end, next.end};
    pending = 0;
    if (configuration.meshes && !met_mesh) return;
    if (!job) {
      capture.frames.count = int64_t(next.first);
      plan = make_plan(std::move(capture), configuration.encoded, options, observer);
      job.emplace(*plan, sink);
    }
    plan->effort = effort;
    for (size_t group = done; group < plan->group_count(); group++) job->run_group(group);
    done = plan->group_count();
    memory->drop_before(int64_t(end));
  }

  [[noreturn]] void refuse(const std::string &what) const {
    throw Error("frame " + std::to_string(added) + ": " + what);
  }

  template <class Sample>
  void check_picture(size_t i, const media::BasicImage<Sample> &image, int channels, const char *kind) const {
    const fvv_camera &camera = configuration.cameras[i].calibration;
    const std::string which = "camera " + std::to_string(camera.id) + ": expected a " + kind;
    if (image.width != camera.width || image.height != camera.height)
      refuse(which + " of " + std::to_string(camera.width) + "x" + std::to_string(camera.height) +
             " pixels, found " + std::to_string(image.width) + "x" + std::to_string(image.height));
    const size_t samples = size_t(image.width) * image.height * size_t(channels);
    if (image.channels != channels || image.pixels.size() != samples)
      refuse(which + " of " + std::to_string(channels) + (channels == 1 ? " channel" : " channels") +
             " with " + std::to_string(samples) + " samples, found " + std::to_string(image.channels) +
             " with " + std::to_string(image.pixels.size()));
  }

  // The picture of a camera has the samples that the codec and its bit depth need.
  void check_picture(size_t i, const media::AnyImage &picture) const {
    std::visit([&](const auto &image) { check_picture(i, image, 3, "picture"); }, picture);
    static const char *const names[] = {"8 bits", "16 bits", "linear light"};
    const size_t wanted = media::with_sample_type(options.codec, options.bit_depth, [](auto sample) {
      return media::AnyImage(media::BasicImage<decltype(sample)>()).index();
    });
    if (picture.index() != wanted)
      refuse("camera " + std::to_string(configuration.cameras[i].calibration.id) +
             ": expected a picture with samples of " + names[wanted] +
             " for the codec and its bit depth, found " + names[picture.index()]);
  }

  // What the tracks have of a frame.
  std::vector<media::Sample> samples_of(Frame &frame) const {
    if (frame.samples.size() != configuration.encoded.size())
      refuse("expected " + words(configuration.encoded.size(), "encoded sample") + ", found " +
             std::to_string(frame.samples.size()));
    std::vector<media::Sample> out;
    for (size_t i = 0; i < frame.samples.size(); i++) {
      fvv_video_config config = configuration.encoded[i].config;
      config.record = configuration.encoded[i].record.data();
      config.record_size = configuration.encoded[i].record.size();
      const std::string name = "frame " + std::to_string(added) + ": encoded track " + std::to_string(i);
      fvv_diagnostic diagnostic = {};
      int key = 0;
      check(fvv_video_sample_inspect(&config, frame.samples[i].data(), frame.samples[i].size(), &key,
                                     &diagnostic),
            name, diagnostic);
      if (!key && !pending)
        throw Error(name + ": expected a key frame, because a group " +
                    (added % group_size ? "begins where the stage becomes empty"
                                        : "of " + std::to_string(group_size) + " frames begins"));
      out.push_back({std::move(frame.samples[i]), key != 0});
    }
    return out;
  }

  bool has_mesh(const Frame &frame) const {
    return configuration.meshes && !(frame.mesh.positions.empty() && frame.mesh.faces.empty());
  }

  void check_frame(const Frame &frame) const {
    const std::vector<CameraInput> &cameras = configuration.cameras;
    // The planner sees meshes before the canonicaliser does.
    if (has_mesh(frame)) geometry::check(frame.mesh, "frame " + std::to_string(added));
    const auto check_count = [&](size_t found, const char *noun) {
      if (found && found != cameras.size())
        refuse("expected " + words(cameras.size(), noun) + ", one for each camera, found " +
               std::to_string(found));
    };
    check_count(frame.pictures.size(), "picture");
    check_count(frame.masks.size(), "mask");
    check_count(frame.calibrations.size(), "calibration");
    check_count(frame.visibility.size(), "visibility array");
    for (size_t i = 0; i < configuration.sounds.size(); i++) {
      const size_t places = configuration.sounds[i].per_frame.size();
      if (places && places <= added)
        refuse("sound " + std::to_string(i) + " moves, and has no position here");
    }
    for (size_t i = 0; i < cameras.size(); i++) {
      if (cameras[i].pictures) {
        if (frame.pictures.empty()) refuse("expected pictures");
        check_picture(i, frame.pictures[i]);
        if (cameras[i].masks) {
          if (frame.masks.empty()) refuse("expected masks");
          check_picture(i, frame.masks[i], 1, "mask");
        }
      }
      if (cameras[i].visibility && has_mesh(frame)) {
        const size_t vertices = frame.mesh.vertex_count();
        const size_t found = frame.visibility.empty() ? 0 : frame.visibility[i].size();
        if (found != vertices)
          refuse("camera " + std::to_string(cameras[i].calibration.id) + ": expected the visibility of " +
                 std::to_string(vertices) + " vertices, found " + std::to_string(found));
      }
      if (!cameras[i].moves) continue;
      if (frame.calibrations.empty()) refuse("expected calibrations, because cameras move");
      fvv_diagnostic diagnostic = {};
      check(fvv_camera_validate(&frame.calibrations[i], &diagnostic),
            "frame " + std::to_string(added) + ": camera " + std::to_string(cameras[i].calibration.id),
            diagnostic);
    }
  }
};

Encoder::Encoder(const Configuration &configuration, const Options &options, const Sink &sink,
                 const Observer &observer)
    : state(std::make_unique<State>()) {
  state->configuration = configuration;
  state->options = options;
  fill_in(state->options);
  state->options.frames.reset();
  state->options.cameras.clear();
  state->options.verify = false;
  state->sink = sink;
  state->observer = observer;
  state->capture = describe(configuration, state->memory);
  state->group_size = group_size_of(options, configuration.frame_duration);
  state->shows_pictures = !configuration.encoded.empty() ||
                          std::any_of(configuration.cameras.begin(), configuration.cameras.end(),
                                      [](const CameraInput &camera) { return camera.pictures; });
}

Encoder::~Encoder() = default;

void Encoder::check_next(const Frame &frame) const {
  try {
    state->check_frame(frame);
  } catch (const Error &error) {
    throw Error(error.line(), Error::usage);
  }
}

void Encoder::add(Frame frame) {
  State &s = *state;
  s.observer.check_cancelled();
  check_next(frame);
  const bool has_mesh = s.has_mesh(frame), is_empty = s.configuration.meshes && !has_mesh;
  if (is_empty && s.had_mesh && s.pending) s.end_group(s.added);
  std::vector<media::Sample> samples = s.samples_of(frame);
  const auto number = int64_t(s.added);
  for (scene::Camera &camera : s.description().cameras)
    for (size_t i = 0; i < s.configuration.cameras.size(); i++)
      if (s.configuration.cameras[i].moves &&
          s.configuration.cameras[i].calibration.id == camera.calibration.id) {
        fvv_camera calibration = frame.calibrations[i];
        calibration.name = nullptr;
        calibration.name_size = 0;
        camera.per_frame[number] = calibration;
      }
  if (is_empty) s.description().empty.insert(number);
  if (is_empty && !s.shows_pictures) {
    s.description().frames.left_out.push_back(number);
  } else {
    s.memory->put(number, {std::move(frame.mesh), std::move(frame.pictures), std::move(frame.masks),
                           std::move(samples), std::move(frame.visibility)});
    s.pending++;
  }
  s.had_mesh = has_mesh;
  s.met_mesh = s.met_mesh || has_mesh;
  s.added++;
  if (s.added % s.group_size == 0 && s.pending) s.end_group(s.added);
}

void Encoder::set_effort(size_t step) {
  state->effort = step;
}

void Encoder::skip() {
  State &s = *state;
  s.observer.check_cancelled();
  s.description().frames.left_out.push_back(int64_t(s.added));
  s.added++;
  // Nothing lasts from the group before: of the time until the next frame nothing is known.
  if (!s.pending && (s.had_mesh || !s.configuration.meshes)) s.next.start = int64_t(s.added);
  if (s.added % s.group_size == 0 && s.pending) s.end_group(s.added);
}

Report Encoder::finish() {
  State &s = *state;
  const bool has_frame = s.plan || s.pending;
  if (!s.added || (!s.configuration.meshes && !has_frame))
    throw Error("encoder: expected at least one frame before finish()", Error::usage);
  if (s.configuration.meshes && !s.met_mesh)
    throw Error("encoder: expected a frame with a mesh before finish(), found none", Error::usage);
  if (s.pending) s.end_group(s.added);
  const bool warned = warn_of_lost_sound(*s.plan);
  Report report = s.job->finish(s.start);
  report.warned = report.warned || warned;
  s.job.reset();
  return report;
}

} // namespace fvv::mux
