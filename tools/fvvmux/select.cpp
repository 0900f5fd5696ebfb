#include "fvvmux/select.h"

#include "capture/text_scan.h"
#include "cli/cli.h"

#include <algorithm>

namespace fvv::mux {

namespace {

// Which cameras one item of --cameras names: all of that name, else those of an identifier or a range.
std::vector<size_t> named_cameras(const capture::Capture &capture, const std::string &item) {
  std::vector<size_t> found;
  for (size_t i = 0; i < capture.cameras.size(); i++)
    if (*capture.cameras[i].name == item) found.push_back(i);
  if (!found.empty()) return found;
  if (const std::optional<cli::Range> range = cli::scan_range(item))
    for (size_t i = 0; i < capture.cameras.size(); i++) {
      const int64_t id = capture.cameras[i].calibration.id;
      if (id >= range->first && id <= range->last) found.push_back(i);
    }
  if (found.empty()) {
    std::string known;
    for (const capture::Camera &camera : capture.cameras) {
      const std::string id = std::to_string(camera.calibration.id);
      known += (known.empty() ? "" : ", ") + (camera.name->empty() ? id : id + " " + *camera.name);
    }
    throw cli::Failure("--cameras: expected identifiers, ranges or names of the capture's cameras (" + known +
                           "), found " + capture::quote(item),
                       cli::usage);
  }
  return found;
}

// A camera of a stream has one lens model (fvv.md clause 9.4).
bool changes_lens(const capture::Camera &camera) {
  return std::any_of(camera.per_frame.begin(), camera.per_frame.end(),
                     [&](const auto &entry) { return entry.second.lens != camera.calibration.lens; });
}

bool leave_out_changing(capture::Capture &capture) {
  std::string names;
  for (const capture::Camera &camera : capture.cameras)
    if (changes_lens(camera)) names += (names.empty() ? "" : ", ") + describe(camera);
  if (names.empty()) return false;
  cli::warn(capture.path + ": left out, because their lens models change from frame to frame: " + names);
  std::vector<capture::Camera> &cameras = capture.cameras;
  cameras.erase(std::remove_if(cameras.begin(), cameras.end(), changes_lens), cameras.end());
  return true;
}

} // namespace

void restrict_frames(capture::Capture &capture, const cli::Range &range) {
  capture::Frames &frames = capture.frames;
  const int64_t last = frames.number(frames.count - 1);
  for (const int64_t end : {range.first, range.last})
    if (end < frames.first || end > last || (end - frames.first) % frames.step)
      throw cli::Failure("--frames: expected frame numbers of the capture, " + std::to_string(frames.first) +
                             " to " + std::to_string(last) + " in steps of " + std::to_string(frames.step) +
                             ", found " + std::to_string(end),
                         cli::usage);
  frames.count = (range.last - range.first) / frames.step + 1;
  frames.first = range.first;
}

std::string describe(uint16_t id, const std::string &name) {
  return "camera " + std::to_string(id) + (name.empty() ? "" : " (" + name + ")");
}

std::string describe(const capture::Camera &camera) {
  return describe(camera.calibration.id, *camera.name);
}

void restrict_cameras(capture::Capture &capture, const std::vector<std::string> &items) {
  if (items.empty()) return;
  std::vector<bool> wanted(capture.cameras.size());
  for (const std::string &item : items)
    for (const size_t i : named_cameras(capture, item)) wanted[i] = true;
  std::vector<capture::Camera> kept;
  for (size_t i = 0; i < wanted.size(); i++)
    if (wanted[i]) kept.push_back(std::move(capture.cameras[i]));
  capture.cameras = std::move(kept);
}

bool select(capture::Capture &capture, const Options &options) {
  if (options.frames) restrict_frames(capture, *options.frames);
  restrict_cameras(capture, options.cameras);
  const bool left_out = leave_out_changing(capture);
  if (!options.meshes) capture.meshes.reset();
  if (!options.meshes || !options.pictures) capture.atlas.reset();
  if (!options.environment) capture.background.reset();
  bool pictures = false;
  for (capture::Camera &camera : capture.cameras) {
    if (!options.pictures || !camera.texture) {
      camera.pictures.reset();
      camera.masks.reset();
    }
    pictures = pictures || camera.pictures;
    const bool fills = options.background == Background::flat || options.background == Background::smooth;
    if (fills && camera.pictures && !camera.masks)
      throw cli::Failure(std::string("--background ") +
                             (options.background == Background::flat ? "flat: " : "smooth: ") +
                             describe(camera) + " has no masks",
                         cli::usage);
  }
  if (!pictures && !capture.meshes)
    throw cli::Failure(capture.path + ": nothing is left to write" +
                           (!options.meshes && !options.pictures ? " without meshes and pictures"
                            : !options.meshes                    ? " without meshes"
                            : !options.pictures                  ? " without pictures"
                                                                 : ""),
                       cli::usage);
  std::sort(capture.cameras.begin(), capture.cameras.end(),
            [](const auto &a, const auto &b) { return a.calibration.id < b.calibration.id; });
  return left_out;
}

} // namespace fvv::mux
