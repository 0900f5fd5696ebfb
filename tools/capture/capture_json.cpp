// capture/capture_json.cpp: capture.json -> Capture.
#include "capture/capture_fields.h"
#include "capture/vocabulary.h"

namespace fvv::capture {

namespace {

// A capture.json with a camera for each of fvv_limits.max_cameras stays far below this.
constexpr uint64_t max_file_size = uint64_t(16) << 20;
constexpr int64_t max_frames = 10'000'000; // 4.6 days at 25 Hz; a file for each is checked before work starts

// As seconds per frame.
fvv_rational read_frame_rate(const JsonValue &value) {
  const fvv_rational rate =
      read_rational(value, 1, "frames per second as an integer > 0 or as text such as \"30000/1001\"");
  return {rate.denominator, rate.numerator};
}

Frames read_frames(const JsonValue &value) {
  value.allow_keys({"first", "count", "step"});
  Frames frames;
  frames.first = value.at("first").integer(0, INT32_MAX);
  frames.count = value.at("count").integer(1, max_frames);
  if (const auto step = value.find("step")) frames.step = step->integer(1, INT32_MAX);
  if (frames.number(frames.count - 1) > INT32_MAX)
    value.fail("expected the last frame number to be at most 2147483647, found " +
               std::to_string(frames.number(frames.count - 1)));
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

// One file for all frames. The pattern that names it has no number, whatever the file is called.
void read_animated_file(const JsonValue &value, Capture &capture) {
  value.allow_keys({"file", "animation", "start"});
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
  if (value.find("file")) {
    read_animated_file(value, capture);
    return;
  }
  value.allow_keys({"pattern", "file"});
  capture.meshes = read_pattern(value.at("pattern"), capture.frames);
}

// Behind the meshes, whose texture coordinates it is for.
Atlas read_atlas(const JsonValue &value, const Capture &capture) {
  value.allow_keys({"pictures", "embedded", "texture_bits"});
  if (!capture.meshes) value.fail("expected meshes wherever there is an atlas");
  Atlas atlas;
  const auto pictures = value.find("pictures"), embedded = value.find("embedded");
  if (!pictures == !embedded)
    value.fail(std::string("expected pictures or embedded, found ") + (pictures ? "both" : "neither"));
  if (pictures) {
    atlas.pictures = read_picture_source(*pictures, capture.frames, true);
  } else {
    if (!embedded->boolean()) embedded->fail("expected true, or pictures in its place");
    if (!is_gltf(capture.meshes->text()))
      embedded->fail("expected meshes in .glb or .gltf files, found \"" + capture.meshes->text() + "\"");
  }
  if (const auto bits = value.find("texture_bits"))
    atlas.texture_bits = static_cast<uint32_t>(bits->integer(1, FVV_TEXTURE_BITS_MAX));
  return atlas;
}

} // namespace

Capture parse_capture(std::string_view bytes, const std::string &path) {
  const nlohmann::json document = parse_strict_json(bytes, path);
  const JsonValue root(document, path);
  // The version first: a later one may have keys that this one does not know.
  const JsonValue version = root.at("fvv_capture");
  if (version.integer(1, INT32_MAX) != 1)
    version.fail("expected version 1 of the capture description, found " + version.found());
  root.allow_keys({"fvv_capture", "name", "frame_rate", "frames", "units", "up", "lattice", "conventions",
                   "meshes", "atlas", "cameras", "background"});
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
  if (const auto background = root.find("background")) capture.background = read_background(*background);
  if (const auto cameras = root.find("cameras")) read_cameras(*cameras, capture, pixel_centre);
  bool content = capture.meshes.has_value();
  for (const Camera &camera : capture.cameras) content = content || camera.pictures;
  if (!content) root.fail("expected meshes, or pictures of at least one camera, found neither");
  return capture;
}

Capture load_capture(const std::string &path) {
  return parse_capture(read_file(path, max_file_size), path);
}

} // namespace fvv::capture
