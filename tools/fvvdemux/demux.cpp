#include "fvvdemux/demux.h"

#include "cli/parallel.h"
#include "fvvdemux/background.h"
#include "fvvdemux/description.h"
#include "fvvdemux/views.h"

#include <algorithm>

namespace fvv::demux {

namespace {

// Streams that threads take and give back: opening one reads the index.
class Streams {
public:
  explicit Streams(const cli::InputFile &input) : file(input) {}
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

private:
  const cli::InputFile &file;
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
        throw cli::Failure("--cameras: camera " + std::to_string(id) + " is not in the stream, which has " +
                               ids_of(configuration),
                           cli::usage);
}

// The first configuration that can be read. File numbers come from it whatever frames are chosen.
const fvv_configuration *first_configuration(fvv_stream *stream) {
  const fvv_file *file = fvv_stream_file(stream);
  uint64_t tried = 0;
  for (size_t g = 0; g < fvv_file_group_count(file); g++) {
    const uint64_t offset = fvv_file_group(file, g)->configuration_offset;
    const fvv_configuration *configuration;
    if (offset == tried) continue;
    if (fvv_stream_configuration(stream, g, &configuration, nullptr) == FVV_OK) return configuration;
    tried = offset;
  }
  return nullptr;
}

class Run {
public:
  Run(const std::string &input, const Options &chosen, Result &out)
      : result(out), options(chosen), file(input), survey(file), stream(open_stream(file)),
        plan(make_plan(stream.get(), file, options.frames, survey)) {
    const int64_t last = options.frames.everything() ? -1 : options.frames.largest();
    if (last >= plan.count && !plan.rebuilt)
      throw cli::Failure("--frames: frame " + std::to_string(last) + " is not in the stream, which has " +
                             std::to_string(plan.count),
                         cli::usage);
    const fvv_configuration *configuration = first_configuration(stream.get());
    if (configuration) {
      check_cameras(*configuration, options.cameras);
      numbers = file_numbers(*configuration, std::max<int64_t>(plan.count, 1), result.warnings);
      if (options.meshes != Meshes::none) mesh_track_of(*configuration, &result.warnings);
      if (options.pictures != Pictures::none) views_of(*configuration, options.cameras, &result.warnings);
    }
    result.frames_in_stream = plan.count;
  }

  void unpack(const cli::OutputFolder &folder) {
    const FilePath path = [&](const std::string &sub, int64_t number, const char *extension) {
      std::string what;
      const std::string pattern = sub + "/%04d." + extension;
      return folder.file(capture::Pattern::parse(pattern, &what).value().file(numbers.of(number)));
    };
    Streams streams(file);
    std::vector<GroupResult> results(plan.groups.size());
    cli::Progress progress(file.path(), plan.groups.size());
    cli::parallel(
        options.threads, plan.groups.size(),
        [&](size_t i) {
          Stream own = streams.take();
          results[i] = unpack_group(own.get(), plan.groups[i], options, survey, path);
          streams.give(std::move(own));
        },
        [&] { progress.step(); });
    for (size_t i = 0; i < results.size(); i++) {
      if (!results[i].frames.empty()) used.push_back(plan.groups[i].group);
      frames.insert(frames.end(), results[i].frames.begin(), results[i].frames.end());
      plan.losses.insert(plan.losses.end(), results[i].losses.begin(), results[i].losses.end());
      for (const auto &[camera, count] : results[i].pictures)
        (camera == no_camera ? result.atlases : result.pictures[camera]) += count;
    }
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
  }

  void check_written() const {
    if (result.meshes || result.atlases || !result.pictures.empty()) return;
    throw cli::Failure(file.path() + ": " +
                       (frames.empty() && !result.losses.empty() ? "no frame is whole"
                        : frames.empty()                         ? "the stream has no frames"
                                         : "nothing of what was asked for is in the stream") +
                       ": nothing written");
  }

  void describe(const cli::OutputFolder &folder) {
    std::string reason;
    auto capture = capture_of(reason);
    if (const auto background = write_background(folder); background && capture)
      capture->background = background;
    result.capture = capture.has_value();
    if (capture)
      capture::write_capture(*capture, folder.file("capture.json"));
    else
      result.warnings.push_back("no capture.json: " + reason);
  }

private:
  std::optional<capture::Capture> capture_of(std::string &reason) {
    std::optional<capture::Capture> out;
    std::string text;
    fvv_scene scene = {};
    uint64_t seen = 0;
    for (const size_t group : used) {
      const uint64_t offset = fvv_file_group(fvv_stream_file(stream.get()), group)->configuration_offset;
      if (offset == seen) continue;
      seen = offset;
      const fvv_configuration *configuration;
      fvv_diagnostic diagnostic = {};
      cli::check(fvv_stream_configuration(stream.get(), group, &configuration, &diagnostic), file.path(),
                 diagnostic);
      const capture::Capture described = describe_scene(*configuration, options);
      const std::string own = capture::format_capture(described);
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
    const auto span = span_of(frames, numbers, scene, reason);
    if (!span) return {};
    describe_moving(*out);
    if (out->atlas) describe_texture(*out);
    out->frames = span->frames;
    out->frame_duration = span->duration;
    return out;
  }

  // That of the first frames written: within a configuration there is one.
  std::optional<capture::Background> write_background(const cli::OutputFolder &folder) {
    const fvv_configuration *configuration;
    if (!options.background || used.empty() ||
        fvv_stream_configuration(stream.get(), used[0], &configuration, nullptr) != FVV_OK)
      return {};
    std::vector<std::string> lost;
    const UnpackedBackground background = unpack_background(stream.get(), used[0], *configuration, lost);
    for (const std::string &why : lost)
      result.losses.push_back(file.path() + ": the background is lost: " + why);
    if (background.environment.parts.empty()) return {}; // lights alone are no glTF to read
    capture::write_file(
        folder.file("background.glb"),
        capture::format_environment(background.environment, *background.lattice, "background.glb"));
    result.background = true;
    return capture::Background{"background.glb", {}, background.lattice};
  }

  void describe_moving(capture::Capture &capture) {
    const fvv_configuration *configuration;
    fvv_diagnostic diagnostic = {};
    cli::check(fvv_stream_configuration(stream.get(), used[0], &configuration, &diagnostic), file.path(),
               diagnostic);
    describe_motion(*configuration, options, frames, numbers, capture);
  }

  // A capture's atlas is one for the texture coordinates of all its meshes.
  void describe_texture(capture::Capture &capture) const {
    const uint8_t bits = frames[0].texture_bits;
    for (const WrittenFrame &frame : frames)
      if (!frame.texture_bits) {
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
  const cli::InputFile file;
  LazySurvey survey;
  Stream stream;
  Plan plan;
  FileNumbers numbers;
  std::vector<WrittenFrame> frames;
  std::vector<size_t> used; // groups of written frames
};

} // namespace

void demux(const std::string &input, const std::string &folder_name, const Options &options, Result &result) {
  if (options.meshes == Meshes::none && options.pictures == Pictures::none)
    throw cli::Failure("--meshes none and --pictures none leave nothing to write", cli::usage);
  Run run(input, options, result);
  cli::OutputFolder folder(folder_name, options.force);
  run.unpack(folder);
  run.tell();
  run.check_written();
  run.describe(folder);
  folder.commit();
}

} // namespace fvv::demux
