// Reads capture.json.
#include "fvv_scene/capture_keywords.h"
#include "fvv_scene/environment.h"
#include "fvv_scene/file_io.h"
#include "scene/src/capture_fields.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

namespace fvv::scene {

double finite(const JsonValue &value) {
  const double number = value.number();
  if (!std::isfinite(number)) value.fail("expected a finite number, found " + value.found());
  return number;
}

double positive(const JsonValue &value) {
  const double number = finite(value);
  if (!(number > 0)) value.fail("expected a number > 0, found " + value.found());
  return number;
}

fvv_rational read_rational(const JsonValue &value, int64_t least, const char *what) {
  if (value.is_integer()) return {static_cast<uint32_t>(value.integer(least, UINT32_MAX)), 1};
  const std::optional<fvv_rational> rational =
      value.is_text() ? parse_rational(value.text()) : std::optional<fvv_rational>();
  if (!rational || rational->numerator < least)
    value.fail(std::string("expected ") + what + ", found " + value.found());
  return *rational;
}

Pattern read_pattern(const JsonValue &value) {
  std::string what;
  const std::optional<Pattern> pattern = Pattern::parse(value.text(), &what);
  if (!pattern) value.fail(what);
  return *pattern;
}

Pattern read_pattern(const JsonValue &value, const Frames &frames) {
  const Pattern pattern = read_pattern(value);
  if (!pattern.is_numbered() && frames.count > 1)
    value.fail("expected %d or %0Nd for the frame number, because there are " + std::to_string(frames.count) +
               " frames, found " + value.found());
  return pattern;
}

Lattice read_lattice(const JsonValue &value) {
  value.allow_keys({"origin", "step"});
  Lattice lattice;
  lattice.step = positive(value.at("step"));
  const JsonValue origin = value.at("origin");
  for (size_t k = 0; k < 3; k++) {
    lattice.origin[k] = finite(origin.items(3, k));
    if (!std::isfinite(std::fabs(lattice.origin[k]) + lattice.step * FVV_LATTICE_MAX))
      value.fail("expected |origin| + step * 2^28 to be finite");
  }
  return lattice;
}

EnvironmentSource read_environment(const JsonValue &value) {
  value.allow_keys({"file", "transform", "lattice"});
  EnvironmentSource out;
  const JsonValue file = value.at("file");
  out.file = file.text();
  if (!is_gltf(out.file)) file.fail("expected a .glb or .gltf file, found " + file.found());
  if (const auto lattice = value.find("lattice")) out.lattice = read_lattice(*lattice);
  if (const auto transform = value.find("transform")) {
    for (size_t row = 0; row < 3; row++)
      for (size_t column = 0; column < 4; column++)
        out.transform.m[4 * row + column] = finite(transform->items(3, row).items(4, column));
    if (!(std::fabs(out.transform.determinant()) > 0))
      transform->fail("expected a transform that keeps volume, found one with the determinant 0");
  }
  return out;
}

Environment load_environment(const Capture &capture, const fvv_limits *limits) {
  const EnvironmentSource &source = capture.environment.value();
  const std::string path = capture.resolve(source.file);
  check_mesh_memory(path, capture.memory_limit);
  Environment environment = parse_environment(read_file(path, max_mesh_file), path, limits);
  gltf::Transform by = source.transform;
  for (double &element : by.m) element *= capture.metres_per_unit;
  environment.transform(by);
  return environment;
}

namespace {

// The meaning of radius depends on the lens: fvv_camera_validate checks it.
void read_lens(const JsonValue &value, fvv_camera &camera, bool &r_max_given) {
  value.allow_keys({"model", "coefficients", "r_max"});
  const JsonValue model = value.at("model");
  const std::string text = model.text();
  bool known = false;
  for (const NamedLens &lens : named_lenses)
    if (text == lens.name) {
      camera.lens = lens.lens;
      known = true;
    }
  if (!known) model.fail("expected none, radtan or fisheye, found " + model.found());
  const auto coefficients =
      camera.lens == FVV_LENS_NONE ? value.find("coefficients") : std::optional(value.at("coefficients"));
  if (coefficients) {
    const size_t count = coefficients->size();
    const bool fits = camera.lens == FVV_LENS_RADTAN    ? count == 4 || count == 5 || count == 8
                      : camera.lens == FVV_LENS_FISHEYE ? count == 4
                                                        : count == 0;
    if (!fits)
      coefficients->fail(std::string("expected ") +
                         (camera.lens == FVV_LENS_RADTAN    ? "4, 5 or 8 (k1 k2 p1 p2 k3 k4 k5 k6)"
                          : camera.lens == FVV_LENS_FISHEYE ? "4 (k1 k2 k3 k4)"
                                                            : "no") +
                         " coefficients for " + text + ", found " + std::to_string(count));
    for (size_t i = 0; i < count; i++) camera.distortion[i] = finite(coefficients->item(i));
  }
  if (const auto r_max = value.find("r_max")) {
    r_max_given = true;
    camera.r_max = r_max->is_text() && r_max->text() == unbounded ? INFINITY : positive(*r_max);
  }
}

// How a capture.json counts, where a calibration is read.
struct Convention {
  double metres_per_unit, pixel_centre;
};

void read_intrinsics(const JsonValue &value, const Convention &convention, fvv_camera &model) {
  value.allow_keys({"fx", "fy", "cx", "cy", "skew"});
  model.fx = positive(value.at("fx"));
  model.fy = positive(value.at("fy"));
  model.cx = finite(value.at("cx")) + (0.5 - convention.pixel_centre);
  model.cy = finite(value.at("cy")) + (0.5 - convention.pixel_centre);
  const auto skew = value.find("skew");
  model.skew = skew ? finite(*skew) : 0;
}

void read_rotation(const JsonValue &value, fvv_camera &model) {
  for (size_t row = 0; row < 3; row++)
    for (size_t column = 0; column < 3; column++)
      model.rotation[row * 3 + column] = finite(value.items(3, row).items(3, column));
}

void read_translation(const JsonValue &value, const Convention &convention, fvv_camera &model) {
  for (size_t row = 0; row < 3; row++)
    model.translation[row] = finite(value.items(3, row)) * convention.metres_per_unit;
}

// value: of the camera, for the message.
void validate(const JsonValue &value, const fvv_camera &model) {
  fvv_diagnostic diagnostic = {};
  if (fvv_camera_validate(&model, &diagnostic) != FVV_OK) value.fail(diagnostic.message);
}

[[noreturn]] void refuse_second(const JsonValue &number) {
  number.fail("expected one entry for each frame, found a second one for " + number.found());
}

void add_lost(const JsonValue &number, Camera &camera) {
  const int64_t frame = number.integer(0, INT32_MAX);
  if (camera.per_frame.count(frame) || !camera.lost.insert(frame).second) refuse_second(number);
}

// The entries of a camera that moves; missing values are those of the camera itself.
void read_per_frame(const JsonValue &value, const Frames &frames, const Convention &convention,
                    bool r_max_given, Camera &camera) {
  for (size_t i = 0, count = value.size(); i < count; i++) {
    const JsonValue entry = value.item(i);
    if (const auto calibrated = entry.find("calibrated")) {
      entry.allow_keys({"frame", "calibrated"});
      if (calibrated->boolean()) calibrated->fail("expected false, or no such key, found true");
      add_lost(entry.at("frame"), camera);
      continue;
    }
    entry.allow_keys({"frame", "intrinsics", "lens", "rotation", "translation"});
    fvv_camera model = camera.calibration;
    model.name = nullptr;
    model.name_size = 0;
    if (const auto intrinsics = entry.find("intrinsics")) read_intrinsics(*intrinsics, convention, model);
    if (const auto rotation = entry.find("rotation")) read_rotation(*rotation, model);
    if (const auto translation = entry.find("translation")) read_translation(*translation, convention, model);
    bool given = r_max_given;
    if (const auto lens = entry.find("lens")) {
      std::fill(std::begin(model.distortion), std::end(model.distortion), 0.0);
      given = false;
      read_lens(*lens, model, given);
    }
    if (!given) model.r_max = fvv_camera_r_max(&model);
    validate(entry, model);
    const JsonValue number = entry.at("frame");
    const int64_t frame = number.integer(0, INT32_MAX);
    if (camera.lost.count(frame) || !camera.per_frame.emplace(frame, model).second) refuse_second(number);
  }
  for (int64_t i = 0; i < frames.count; i++)
    if (!camera.per_frame.count(frames.number(i)) && !camera.lost.count(frames.number(i)))
      value.fail("expected an entry for each of the capture's " + std::to_string(frames.count) +
                 " frames, found none for frame " + std::to_string(frames.number(i)));
}

Camera read_camera(const JsonValue &value, const Capture &capture, const Convention &convention) {
  value.allow_keys({"id", "name", "width", "height", "intrinsics", "lens", "rotation", "translation",
                    "per_frame", "texture", "pictures", "masks"});
  Camera camera;
  fvv_camera &model = camera.calibration;
  model.id = static_cast<uint16_t>(value.at("id").integer(0, UINT16_MAX - 1));
  const auto name = value.find("name");
  camera.set_name(name ? name->text() : "");
  model.width = static_cast<uint32_t>(value.at("width").integer(1, UINT32_MAX));
  model.height = static_cast<uint32_t>(value.at("height").integer(1, UINT32_MAX));
  read_intrinsics(value.at("intrinsics"), convention, model);
  read_rotation(value.at("rotation"), model);
  read_translation(value.at("translation"), convention, model);
  bool r_max_given = false;
  if (const auto lens = value.find("lens")) read_lens(*lens, model, r_max_given);
  if (!r_max_given) model.r_max = fvv_camera_r_max(&model);
  validate(value, model);
  if (const auto entries = value.find("per_frame"))
    read_per_frame(*entries, capture.frames, convention, r_max_given, camera);
  if (const auto texture = value.find("texture")) camera.texture = texture->boolean();
  if (const auto pictures = value.find("pictures"))
    camera.pictures = read_picture_source(*pictures, capture.frames);
  if (const auto masks = value.find("masks")) {
    if (!camera.pictures) masks->fail("expected pictures wherever there are masks");
    camera.masks = read_picture_source(*masks, capture.frames);
  }
  for (auto *source : {&camera.pictures, &camera.masks})
    if (*source && (*source)->place) {
      (*source)->place->width = camera.calibration.width;
      (*source)->place->height = camera.calibration.height;
    }
  return camera;
}

} // namespace

void read_cameras(const JsonValue &value, Capture &capture, double pixel_centre) {
  fvv_limits limits;
  fvv_limits_default(&limits);
  const size_t count = value.size();
  if (count > limits.max_cameras)
    value.fail("expected at most " + std::to_string(limits.max_cameras) + " cameras, found " +
               std::to_string(count));
  for (size_t i = 0; i < count; i++) {
    Camera camera = read_camera(value.item(i), capture, {capture.metres_per_unit, pixel_centre});
    for (size_t j = 0; j < i; j++)
      if (capture.cameras[j].calibration.id == camera.calibration.id)
        value.item(i).at("id").fail("expected an id of its own, found " +
                                    std::to_string(camera.calibration.id) + " as in /cameras/" +
                                    std::to_string(j));
    capture.cameras.push_back(std::move(camera));
  }
}

namespace {

// Far more than a capture.json with fvv_limits.max_cameras cameras.
constexpr uint64_t max_file_size = uint64_t(16) << 20;
constexpr int64_t max_frames = 10'000'000; // 4.6 days at 25 Hz; a file for each is checked before work starts

// As seconds per frame.
fvv_rational read_frame_rate(const JsonValue &value) {
  const fvv_rational rate =
      read_rational(value, 1, "frames per second as an integer > 0 or as text such as \"30000/1001\"");
  return {rate.denominator, rate.numerator};
}

// An array of frame numbers, and of pairs of the first and the last of a range.
std::set<int64_t> read_frame_numbers(const JsonValue &value, const Frames &frames) {
  std::set<int64_t> out;
  const int64_t last = frames.number_at(frames.places() - 1);
  const auto number = [&](const JsonValue &one) {
    const int64_t found = one.integer(0, INT32_MAX);
    if (found < frames.first || found > last || (found - frames.first) % frames.step)
      one.fail("expected the number of a frame, from " + std::to_string(frames.first) + " to " +
               std::to_string(last) + " in steps of " + std::to_string(frames.step) + ", found " +
               one.found());
    return found;
  };
  std::vector<std::pair<int64_t, int64_t>> ranges;
  for (size_t i = 0; i < value.size(); i++) {
    const JsonValue item = value.item(i);
    const bool is_range = !item.is_integer();
    const int64_t from = number(is_range ? item.items(2, 0) : item),
                  to = is_range ? number(item.items(2, 1)) : from;
    if (from > to) item.fail("expected the first and the last frame of a range, found the last one first");
    ranges.emplace_back(from, to);
  }
  // Each frame once: the ranges of a small file may cover all frames a million times.
  std::sort(ranges.begin(), ranges.end());
  int64_t next = frames.first;
  for (const auto &[from, to] : ranges)
    for (next = std::max(next, from); next <= to; next += frames.step) out.insert(out.end(), next);
  return out;
}

Frames read_frames(const JsonValue &value) {
  value.allow_keys({"first", "count", "step", "left_out"});
  Frames frames;
  frames.first = value.at("first").integer(0, INT32_MAX);
  frames.count = value.at("count").integer(1, max_frames);
  if (const auto step = value.find("step")) frames.step = step->integer(1, INT32_MAX);
  if (frames.number(frames.count - 1) > INT32_MAX)
    value.fail("expected the last frame number to be at most 2147483647, found " +
               std::to_string(frames.number(frames.count - 1)));
  if (const auto left_out = value.find("left_out")) {
    frames.leave_out(read_frame_numbers(*left_out, frames));
    if (!frames.count) left_out->fail("expected at least one frame that is not left out, found none");
  }
  return frames;
}

void read_units(const JsonValue &value, Capture &capture) {
  if (!value.is_text()) {
    if (!value.is_number())
      value.fail("expected the name of a unit or metres per unit > 0, found " + value.found());
    capture.metres_per_unit = positive(value);
    return;
  }
  const std::string text = value.text();
  if (text == unknown_units) {
    capture.scale_unknown = true;
    return;
  }
  for (const NamedUnit &unit : named_units)
    if (text == unit.name) {
      capture.metres_per_unit = unit.metres;
      return;
    }
  value.fail("expected metres, centimetres, millimetres, inches, feet, unknown or a number, found " +
             value.found());
}

uint8_t read_up(const JsonValue &value) {
  const std::string text = value.text();
  for (const NamedAxis &axis : named_axes)
    if (text == axis.name) return axis.up;
  value.fail("expected +x, -x, +y, -y, +z, -z or unknown, found " + value.found());
}

// One file for all frames. Its pattern has no number, even if the file's name has one.
void read_animated_file(const JsonValue &value, Capture &capture) {
  value.allow_keys({"file", "animation", "start", "empty"});
  const JsonValue file = value.at("file");
  std::string text;
  for (const char c : file.text()) text.append(c == '%' ? 2 : 1, c);
  std::string what;
  capture.meshes = Pattern::parse(text, &what);
  if (!capture.meshes) file.fail(what);
  std::optional<MeshAnimation::Name> name;
  if (const auto animation = value.find("animation")) {
    if (animation->is_integer())
      name = animation->integer(0, INT32_MAX);
    else
      name = animation->text();
  }
  fvv_rational start = {0, 1};
  if (const auto key = value.find("start"))
    start = read_rational(*key, 0, "seconds as an integer or as text such as \"3/2\"");
  capture.animation = std::make_shared<const MeshAnimation>(std::move(name), start, capture.frames.first);
}

void read_meshes(const JsonValue &value, Capture &capture) {
  if (const auto empty = value.find("empty")) capture.empty = read_frame_numbers(*empty, capture.frames);
  if (value.find("file")) {
    read_animated_file(value, capture);
    return;
  }
  value.allow_keys({"pattern", "file", "empty"});
  capture.meshes = read_pattern(value.at("pattern"));
}

// After the meshes, whose texture coordinates it is for.
Atlas read_atlas(const JsonValue &value, const Capture &capture) {
  value.allow_keys({"pictures", "embedded", "texture_bits", "bake_repeats"});
  if (!capture.meshes) value.fail("expected meshes wherever there is an atlas");
  Atlas atlas;
  const auto pictures = value.find("pictures"), embedded = value.find("embedded");
  if (!pictures == !embedded)
    value.fail(std::string("expected pictures or embedded, found ") + (pictures ? "both" : "neither"));
  if (pictures) {
    atlas.pictures = read_picture_source(*pictures, capture.frames, true);
    if (atlas.pictures->place)
      pictures->at("place").fail("expected no place, because an atlas has no calibration");
  } else {
    if (!embedded->boolean()) embedded->fail("expected true, or pictures in its place");
    if (!may_bring_picture(capture.meshes->text()))
      embedded->fail("expected meshes in .glb, .gltf, .obj or .ply files, found \"" + capture.meshes->text() +
                     "\"");
  }
  if (const auto bits = value.find("texture_bits"))
    atlas.texture_bits = static_cast<uint32_t>(bits->integer(1, FVV_TEXTURE_BITS_MAX));
  if (const auto bake = value.find("bake_repeats")) atlas.bake_repeats = bake->boolean();
  return atlas;
}

} // namespace

Capture parse_capture(std::string_view bytes, const std::string &path) {
  const nlohmann::json document = parse_strict_json(bytes, path);
  const JsonValue root(document, path);
  // The version first: a later version may have unknown keys.
  const JsonValue version = root.at("fvv_capture");
  if (version.integer(1, INT32_MAX) != 1)
    version.fail("expected version 1 of the capture description, found " + version.found());
  root.allow_keys({"fvv_capture", "name", "frame_rate", "frames", "units", "up", "lattice", "conventions",
                   "meshes", "atlas", "cameras", "environment", "background", "audio"});
  Capture capture;
  capture.path = path;
  if (const auto name = root.find("name")) capture.name = name->text();
  capture.frame_duration = read_frame_rate(root.at("frame_rate"));
  capture.frames = read_frames(root.at("frames"));
  read_units(root.at("units"), capture);
  if (const auto up = root.find("up")) capture.up = read_up(*up);
  if (const auto lattice = root.find("lattice")) capture.lattice = read_lattice(*lattice);
  double pixel_centre = 0.5;
  if (const auto conventions = root.find("conventions")) {
    conventions->allow_keys({"pixel_centre"});
    if (const auto centre = conventions->find("pixel_centre")) {
      pixel_centre = centre->number();
      if (pixel_centre != 0 && pixel_centre != 0.5)
        centre->fail("expected 0 or 0.5, found " + centre->found());
    }
  }
  if (const auto meshes = root.find("meshes")) read_meshes(*meshes, capture);
  if (const auto atlas = root.find("atlas")) capture.atlas = read_atlas(*atlas, capture);
  if (const auto environment = root.find("environment")) {
    if (root.find("background"))
      root.fail("expected \"environment\" alone, found also \"background\", its former name");
    capture.environment = read_environment(*environment);
  } else if (const auto former = root.find("background")) {
    capture.environment = read_environment(*former);
    capture.notes.push_back("\"background\" is now \"environment\"; this version reads both");
  }
  if (const auto cameras = root.find("cameras")) read_cameras(*cameras, capture, pixel_centre);
  if (const auto audio = root.find("audio"))
    capture.sounds = read_sounds(*audio, capture.frames, capture.metres_per_unit);
  bool content = capture.meshes.has_value();
  for (const Camera &camera : capture.cameras) content = content || camera.pictures;
  if (!content) root.fail("expected meshes, or pictures of at least one camera, found neither");
  return capture;
}

Capture load_capture(const std::string &path) {
  return parse_capture(read_file(path, max_file_size), path);
}

} // namespace fvv::scene
