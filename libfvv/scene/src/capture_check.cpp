// Every file that a capture names: which they are, and what is wrong with them before any work starts.
#include "fvv_cxx/input_file.h"
#include "fvv_scene/capture.h"
#include "fvv_scene/picture_source.h"
#include "scene/src/atlas/atlas.h"
#include "scene/src/gltf/container.h"
#include "scene/src/gltf/scene.h"
#include "scene/src/video/video_match.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <set>
#include <utility>

namespace fvv::scene {

namespace {

std::string milliseconds(double seconds) {
  char text[40];
  std::snprintf(text, sizeof text, "%.2f ms", seconds * 1000);
  return text;
}

std::string fraction(const Seconds &seconds) {
  return std::to_string(seconds.numerator) +
         (seconds.denominator == 1 ? "" : "/" + std::to_string(seconds.denominator));
}

void report_times(const std::string &subject, const VideoReport &report, Findings &findings) {
  const int64_t unmet = report.frames - report.met;
  if (unmet)
    findings.warnings.push_back(
        subject + std::to_string(unmet) + " of " + std::to_string(report.frames) +
        " frames have no picture within half a frame and take the nearest: " + report.unmet_text);
  if (report.better_start)
    findings.warnings.push_back(subject + "the pictures are all about " + milliseconds(report.mean_offset) +
                                " off their frames: \"start\": \"" + fraction(*report.better_start) +
                                "\" would fit");
  if (report.before || report.behind)
    findings.unused.push_back(subject + std::to_string(report.before) +
                              " pictures before the first frame and " + std::to_string(report.behind) +
                              " after the last one are not used");
}

// What to do about a picture whose size is not the camera's, where that can be guessed.
// of_camera: the size is that of a calibration.
std::string size_advice(uint32_t width, uint32_t height, uint32_t expected_width, uint32_t expected_height,
                        bool of_camera = true) {
  constexpr uint32_t most = 64; // pixels that encoders add or cut, to a multiple of their blocks
  const auto near = [](uint32_t a, uint32_t b) { return (a > b ? a - b : b - a) < most; };
  const bool fits = width == expected_width && height == expected_height;
  const bool turns = width == expected_height && height == expected_width;
  const std::string place =
      "\"place\": [x, y] with the pixel of the calibrated picture at which it begins, [0, 0] if it "
      "was cut or padded at the right and at the bottom";
  if (turns && !fits) return " (turned? state \"rotate\": 90 or 270)";
  if (!of_camera) return "";
  const bool lies = width > height, expected_lies = expected_width > expected_height;
  if (lies != expected_lies && near(width, expected_height) && near(height, expected_width))
    return " (turned, and cut or padded? state \"rotate\": 90 or 270, and " + place + ")";
  if (near(width, expected_width) && near(height, expected_height))
    return " (cut or padded? state " + place + ")";
  return "";
}

// Why a turned picture cannot be placed; "": it can.
std::string misplaced(const Placement &place, uint32_t width, uint32_t height) {
  const bool shows = place.x < int64_t(place.width) && place.y < int64_t(place.height) &&
                     place.x + int64_t(width) > 0 && place.y + int64_t(height) > 0;
  return shows ? ""
               : " is " + std::to_string(width) + " x " + std::to_string(height) +
                     ", and all of it is beyond the camera's picture by \"place\"";
}

// camera: whose the source is; NULL: the atlas', whose size is that of its pictures. kind: "pictures" or
// "masks". Adds to findings.
void check_video(const Capture &capture, const Camera *camera, const std::string &kind,
                 const PictureSource &source, const VideoProbe &probe, Findings &findings) {
  const std::string id =
      camera ? "camera " + std::to_string(camera->calibration.id) + ": " : std::string("atlas: ");
  const std::string subject = id + kind + " " + source.video->file + ": ";
  const std::string path = capture.resolve(source.video->file);
  if (const std::string why = why_unreadable(path); !why.empty()) {
    findings.problems.push_back(subject + why);
    return;
  }
  if (!probe) return;
  VideoFacts facts;
  try {
    facts = probe(path, source.video->stream);
  } catch (const std::exception &reason) {
    findings.problems.push_back(id + kind + ": " + line_of(reason));
    return;
  }
  for (const std::string &warning : facts.warnings) findings.warnings.push_back(subject + warning);
  if (!source.rotate && !facts.rotation) {
    findings.problems.push_back(subject + "its display matrix is not a rotation by "
                                          "quarter turns: expected \"rotate\" to be stated");
    return;
  }
  const int rotate = source.rotate.value_or(facts.rotation.value_or(0));
  if (rotate % 180) std::swap(facts.width, facts.height);
  if (source.place) {
    if (const std::string why = misplaced(*source.place, facts.width, facts.height); !why.empty())
      findings.problems.push_back(subject.substr(0, subject.size() - 2) + why);
  } else if (camera &&
             (facts.width != camera->calibration.width || facts.height != camera->calibration.height))
    findings.problems.push_back(
        subject + "is " + std::to_string(facts.width) + " x " + std::to_string(facts.height) +
        (rotate ? ", turned by " + std::to_string(rotate) + " degrees" : "") + ", the camera is " +
        std::to_string(camera->calibration.width) + " x " + std::to_string(camera->calibration.height) +
        size_advice(facts.width, facts.height, camera->calibration.width, camera->calibration.height));
  VideoReport report = match_video(capture, *source.video, facts.times, camera);
  if (camera) report.camera = camera->calibration.id;
  report.masks = kind == "masks";
  report_times(subject, report, findings);
  findings.videos.push_back(std::move(report));
}

// On a grid from corner to corner.
double share_beyond(const fvv_camera &camera, int grid) {
  int beyond = 0;
  for (int i = 0; i < grid * grid; i++) {
    const double pixel[2] = {(i % grid) * double(camera.width) / (grid - 1),
                             (i / grid) * double(camera.height) / (grid - 1)};
    double ray[3];
    beyond += !fvv_camera_unproject(&camera, pixel, ray);
  }
  return double(beyond) / (grid * grid);
}

// The corners are farthest from the axis: if they have rays, so has every pixel.
double share_beyond(const fvv_camera &camera) {
  return share_beyond(camera, 2) > 0 ? share_beyond(camera, 64) : 0;
}

} // namespace

std::vector<LensGap> lens_gaps(const Capture &capture) {
  std::vector<LensGap> out;
  for (const Camera &camera : capture.cameras) {
    LensGap gap = {camera.calibration.id, camera.calibration.r_max, 0};
    const auto add = [&](const fvv_camera &one) {
      const double share = one.lens == FVV_LENS_NONE ? 0 : share_beyond(one);
      if (share > gap.share) gap = {gap.camera, one.r_max, share};
    };
    if (!camera.moves()) add(camera.calibration);
    for (const auto &[frame, calibration] : camera.per_frame) add(calibration);
    if (gap.share > 0) out.push_back(gap);
  }
  return out;
}

namespace {

namespace fs = std::filesystem;

// An error of some files of a sequence: their number, and the first of them.
struct Tally {
  int64_t count = 0;
  std::string first;

  void add(const std::string &text) {
    if (!count++) first = text;
  }
};

// After this number of faults of a sequence its other files are not looked at: a wrong number of frames must
// not cost the time of as many files.
constexpr int64_t most_faults = 100;

class FileCheck {
public:
  FileCheck(const Capture &description, const PictureProbe &picture_probe, const VideoProbe &of_videos)
      : capture(description), probe(picture_probe), video_probe(of_videos) {}

  Findings run() {
    if (capture.meshes && capture.animation)
      animated_file();
    else if (capture.meshes)
      sequence("", "meshes", *capture.meshes, {nullptr, false}, {},
               [this](int64_t frame) { return capture.has_mesh(frame); });
    if (capture.atlas && capture.atlas->pictures) {
      const PictureSource &pictures = *capture.atlas->pictures;
      if (pictures.video) {
        check_video(capture, nullptr, "pictures", pictures, video_probe, findings);
      } else {
        // Texture coordinates are for the pixels as they are stored, with any Exif orientation. "rotate"
        // turns all stills alike, so their sizes can be compared as they are.
        constexpr int stored = 0;
        const std::optional<PictureSize> size = first_size(*pictures.pattern);
        sequence("atlas: ", "pictures", *pictures.pattern, {size ? &*size : nullptr, false}, stored);
      }
    }
    for (const Camera &camera : capture.cameras) {
      const std::string subject = "camera " + std::to_string(camera.calibration.id) + ": ";
      if (camera.pictures) source(subject, "pictures", *camera.pictures, camera);
      if (camera.masks) source(subject, "masks", *camera.masks, camera);
    }
    if (capture.environment) environment_file(capture.environment->file);
    check_sounds(capture, findings);
    shared_pictures();
    return std::move(findings);
  }

private:
  void source(const std::string &subject, const std::string &kind, const PictureSource &pictures,
              const Camera &camera) {
    if (pictures.video) return check_video(capture, &camera, kind, pictures, video_probe, findings);
    PictureSize size = {camera.calibration.width, camera.calibration.height};
    if (pictures.place) {
      // The pictures have a size of their own, all the same.
      const PictureSize first = first_size(*pictures.pattern).value_or(PictureSize{0, 0});
      size = pictures.rotate.value_or(0) % 180 ? PictureSize{first.height, first.width} : first;
      if (const std::string why = misplaced(*pictures.place, size.width, size.height);
          size.width && !why.empty())
        findings.problems.push_back(subject + kind + ": " + pictures.pattern->file(capture.frames.number(0)) +
                                    why);
    }
    sequence(subject, kind, *pictures.pattern, {&size, !pictures.place}, pictures.rotate);
  }

  // Of the first frame's picture. None without a probe; 0 x 0, which is not compared, where it cannot read
  // that picture.
  std::optional<PictureSize> first_size(const Pattern &pattern) const {
    if (!probe) return std::nullopt;
    try {
      return probe(capture.resolve(pattern.file(capture.frames.number(0))));
    } catch (const std::exception &) {
      return PictureSize{0, 0}; // sequence() reports its error
    }
  }

  // The size that pictures must have; NULL: they are no pictures. of_camera: it is that of a calibration.
  struct Expected {
    const PictureSize *size;
    bool of_camera;
  };

  // kind: a plural.
  void sequence(
      const std::string &subject, const std::string &kind, const Pattern &pattern, const Expected &expected,
      std::optional<int> rotate = {},
      const std::function<bool(int64_t frame)> &is_needed = [](int64_t) { return true; }) {
    Tally missing, empty, unreadable, unlike, turned;
    Gaps gaps(capture.frames.step);
    std::set<int64_t> unusable;
    const auto faults = [&] { return missing.count + empty.count + unreadable.count + unlike.count; };
    const int64_t all = files_of(pattern);
    int64_t seen = 0;
    for (; seen < all && faults() < most_faults; seen++) {
      const int64_t frame = capture.frames.number(seen);
      if (!is_needed(frame)) continue;
      const std::string file = pattern.file(frame), path = capture.resolve(file);
      const std::string why = why_unreadable(path);
      std::error_code error;
      const int64_t before = faults();
      if (why == missing_file) {
        missing.add(file);
        gaps.add(frame);
      } else if (!why.empty())
        unreadable.add(file + ": " + why);
      else if (fs::file_size(path, error) == 0)
        empty.add(file);
      if (faults() > before) unusable.insert(seen);
    }
    // Pictures are opened when it is known that they are there, which takes much longer.
    int64_t opened = 0;
    for (; expected.size && probe && opened < seen && faults() < most_faults; opened++)
      if (!unusable.count(opened)) {
        const std::string file = pattern.file(capture.frames.number(opened));
        check_size(file, capture.resolve(file), expected, rotate, unreadable, unlike, turned);
      }
    const Share count = {all,
                         seen < all || (faults() >= most_faults && expected.size && probe && opened < seen)};
    findings.missing_meshes = findings.missing_meshes || (missing.count && !expected.size);
    if (missing.count && pattern.is_numbered())
      findings.problems.push_back(counted(subject, kind, count, missing, "missing") + ": " + gaps.text() +
                                  " (first: " + missing.first + ")");
    else
      report(subject, kind, count, missing, "missing");
    findings.of_frames =
        findings.of_frames || (pattern.is_numbered() && capture.frames.count > 1 && faults());
    report(subject, kind, count, empty, "empty");
    report(subject, kind, count, unreadable, "unreadable");
    if (expected.size)
      report(subject, kind, count, unlike,
             "not " + std::to_string(expected.size->width) + " x " + std::to_string(expected.size->height));
    if (turned.count)
      findings.warnings.push_back(counted(subject, kind, count, turned, "turned by their Exif orientation") +
                                  ", which is ignored unless \"rotate\" is stated, first: " + turned.first);
    extra_frames(subject, kind, pattern);
  }

  void check_size(const std::string &file, const std::string &path, const Expected &expected,
                  std::optional<int> rotate, Tally &unreadable, Tally &unlike, Tally &turned) const {
    try {
      PictureSize size = probe(path);
      const uint32_t width = expected.size->width, height = expected.size->height;
      if (rotate && *rotate % 180) std::swap(size.width, size.height);
      if (width && (size.width != width || size.height != height))
        unlike.add(file + " is " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                   size_advice(size.width, size.height, width, height, expected.of_camera));
      if (size.orientation != 1 && !rotate)
        turned.add(file + " has orientation " + std::to_string(size.orientation));
    } catch (const std::exception &error) {
      unreadable.add(line_of(error));
    }
  }

  void environment_file(const std::string &file) {
    if (const std::string why = why_unreadable(capture.resolve(file)); !why.empty())
      findings.problems.push_back("environment: " + file + ": " + why);
  }

  // One where all frames share a file, else one for each.
  int64_t files_of(const Pattern &pattern) const { return pattern.is_numbered() ? capture.frames.count : 1; }

  // Files of a sequence, and whether the check stopped before the last one.
  struct Share {
    int64_t count;
    bool stopped;
  };

  static std::string counted(const std::string &subject, const std::string &kind, Share all,
                             const Tally &tally, const std::string &state) {
    return subject + (all.stopped ? "at least " : "") + std::to_string(tally.count) + " of " +
           std::to_string(all.count) + " " + kind + (tally.count == 1 ? " is " : " are ") + state;
  }
  void report(const std::string &subject, const std::string &kind, Share count, const Tally &tally,
              const std::string &state) {
    if (tally.count)
      findings.problems.push_back(counted(subject, kind, count, tally, state) + ", first: " + tally.first);
  }

  // An error of the file concerns every frame: it is read here, and not again.
  void animated_file() {
    const Frames &frames = capture.frames;
    double end;
    try {
      end = capture.animation->end(capture.mesh_path(frames.first), capture.atlas.has_value());
    } catch (const Error &error) {
      findings.problems.push_back("meshes: " + error.line());
      return;
    }
    const auto behind = [&](int64_t i) {
      return float(capture.animation_time(frames.number(i))) > float(end);
    };
    if (!behind(frames.count - 1)) return;
    int64_t low = 0, high = frames.count - 1;
    while (low < high) {
      const int64_t middle = low + (high - low) / 2;
      if (behind(middle))
        high = middle;
      else
        low = middle + 1;
    }
    char seconds[32];
    snprintf(seconds, sizeof seconds, "%.3f", end);
    findings.warnings.push_back(std::string("meshes: the animation ends at ") + seconds + " s, the last " +
                                std::to_string(frames.count - low) + " of " + std::to_string(frames.count) +
                                " frames, from " + std::to_string(frames.number(low)) + ", repeat its end");
  }

  // Files that the pattern would name for frames before the first or after the last.
  void extra_frames(const std::string &subject, const std::string &kind, const Pattern &pattern) {
    if (!pattern.is_numbered()) return;
    const int64_t first = capture.frames.first, last = capture.frames.number_at(capture.frames.places() - 1);
    int64_t lowest = first, highest = last, extra = 0;
    // The number may be in the name of a folder ("%04d/cam0.png"): list the one around it.
    const std::string sample = pattern.file(0), other = pattern.file(1);
    const size_t differs = static_cast<size_t>(
        std::mismatch(sample.begin(), sample.end(), other.begin(), other.end()).first - sample.begin());
    const size_t start = sample.rfind('/', differs), end = sample.find('/', differs);
    const std::string parent = start == sample.npos ? "" : sample.substr(0, start + 1);
    const std::string rest = end == sample.npos ? "" : sample.substr(end);
    std::error_code error;
    fs::directory_iterator entry(capture.resolve(parent.empty() ? "." : parent), error), none;
    for (; !error && entry != none; entry.increment(error)) {
      const std::string file = parent + entry->path().filename().string() + rest;
      const std::optional<int64_t> frame = pattern.frame(file);
      std::error_code ignored;
      if (!frame || (*frame >= first && *frame <= last) ||
          !fs::is_regular_file(capture.resolve(file), ignored))
        continue;
      extra++;
      lowest = std::min(lowest, *frame);
      highest = std::max(highest, *frame);
    }
    if (extra)
      findings.unused.push_back(subject + kind + " reach from frame " + std::to_string(lowest) + " to " +
                                std::to_string(highest) + ", the capture takes " + std::to_string(first) +
                                " to " + std::to_string(last) + " (" + std::to_string(extra) + " not used)");
  }

  void shared_pictures() {
    for (size_t i = 0; i < capture.cameras.size(); i++)
      for (size_t j = 0; j < i; j++) {
        const Camera &a = capture.cameras[j], &b = capture.cameras[i];
        if (a.pictures && b.pictures && a.pictures->has_same_pictures(*b.pictures))
          findings.problems.push_back("camera " + std::to_string(b.calibration.id) +
                                      ": has the pictures of camera " + std::to_string(a.calibration.id) +
                                      ": " + b.pictures->text());
      }
  }

  const Capture &capture;
  const PictureProbe &probe;
  const VideoProbe &video_probe;
  Findings findings;
};

} // namespace

Findings check_files(const Capture &capture, const PictureProbe &probe, const VideoProbe &video_probe) {
  if (!capture.memory)
    for (const int64_t number : capture.mesh_frames())
      check_mesh_memory(capture.mesh_path(number), capture.memory_limit);
  Findings findings = FileCheck(capture, probe, video_probe).run();
  // All files of a sequence are of one program.
  const std::vector<int64_t> meshes = capture.memory ? std::vector<int64_t>() : capture.mesh_frames();
  if (!meshes.empty() && is_gltf(capture.mesh_path(meshes.front()))) {
    const std::string path = capture.mesh_path(meshes.front());
    try {
      const std::string bytes = read_file(path, max_mesh_file);
      for (const std::string &name : gltf::unknown_extensions(bytes, path))
        findings.warnings.push_back(path + ": uses " + quote(name) +
                                    ", which is not known here: what it changes is not shown");
      const std::vector<std::string> transparent = gltf::transparent_materials(bytes, path);
      if (!transparent.empty())
        findings.warnings.push_back(
            path + ": " + transparent.front() +
            (transparent.size() == 1 ? std::string()
                                     : " and " + std::to_string(transparent.size() - 1) + " more") +
            " may be transparent (alphaMode): its faces are shown whole; cut the mesh where nothing is to be "
            "seen");
      if (capture.atlas && !capture.atlas->pictures && gltf::has_unlike_colours(bytes, path))
        findings.warnings.push_back(
            path +
            ": unlike colours of vertices (COLOR_0), which its pictures are to be multiplied with, are "
            "not shown: bake them into the pictures");
    } catch (const Error &) {} // is among the problems
  }
  findings.warnings.insert(findings.warnings.begin(), capture.notes.begin(), capture.notes.end());
  return findings;
}

namespace {

using Visit = std::function<void(const std::string &)>;

// With the files that a glTF file refers to, and those of an OBJ file if its picture is used. A mesh that
// cannot be read is reported by those who need it.
void visit_mesh(const std::string &path, bool with_picture, const media::MemoryLimit &limit,
                const Visit &visit) {
  visit(path);
  std::vector<std::string> beside;
  try {
    check_mesh_memory(path, limit);
    if (is_gltf(path)) {
      beside = gltf::external_files(read_file(path, max_mesh_file), path);
    } else if (with_picture && lower(path.substr(path.size() - std::min<size_t>(4, path.size()))) == ".ply") {
      FacePictures faces;
      parse_ply_pictures(read_file(path, max_mesh_file), path, nullptr, nullptr, false, faces);
      for (const FacePicture &one : faces.pictures)
        if (!one.is_colour()) beside.push_back(one.name);
    } else if (with_picture) {
      const ObjMaterials materials = parse_obj_materials(read_file(path, max_mesh_file), path);
      beside = materials.libraries;
      FacePictures faces;
      if (materials.picture) beside.push_back(*materials.picture);
      parse_obj_pictures(read_file(path, max_mesh_file), path, nullptr, nullptr, false, faces);
      for (const FacePicture &one : faces.pictures)
        if (!one.is_colour() && one.name != materials.picture) beside.push_back(one.name);
    }
  } catch (const Error &) {}
  for (const std::string &file : beside) visit(file);
}

} // namespace

void visit_files(const Capture &capture, const Visit &visit) {
  const auto frames_of = [&](const Pattern &pattern) {
    return pattern.is_numbered() ? capture.frames.count : 1;
  };
  const auto pictures = [&](const PictureSource &source) {
    const int64_t count = source.pattern ? frames_of(*source.pattern) : 1;
    for (int64_t i = 0; i < count; i++) visit(capture.resolve(source.file(capture.frames.number(i))));
  };
  visit(capture.path);
  if (capture.meshes)
    for (int64_t i = 0; i < frames_of(*capture.meshes); i++)
      if (const int64_t frame = capture.frames.number(i); capture.animation || capture.has_mesh(frame))
        visit_mesh(capture.mesh_path(frame), capture.atlas && !capture.atlas->pictures, capture.memory_limit,
                   visit);
  if (capture.atlas && capture.atlas->pictures) pictures(*capture.atlas->pictures);
  for (const Camera &camera : capture.cameras) {
    if (camera.pictures) pictures(*camera.pictures);
    if (camera.masks) pictures(*camera.masks);
  }
  for (const SoundSource &sound : capture.sounds) visit(capture.resolve(sound.file));
  if (capture.environment)
    visit_mesh(capture.resolve(capture.environment->file), false, capture.memory_limit, visit);
}

} // namespace fvv::scene
