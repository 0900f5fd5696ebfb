// transforms.json of nerfstudio and instant-ngp. Poses go from the camera to the world in OpenGL's axes;
// intrinsics are at the top or in a frame, which then takes precedence.

#include "fvv_media/image.h"
#include "fvv_scene/strict_json.h"
#include "scene/src/import/camera.h"

#include <cmath>
#include <filesystem>
#include <map>

namespace fvv::import {

namespace {

constexpr uint64_t max_json_size = uint64_t(16)
                                   << 20; // as for a capture.json: values cost many times their text

using scene::JsonValue;

double finite(const JsonValue &value) {
  const double number = value.number();
  if (!std::isfinite(number)) value.fail("expected a finite number, found " + value.found());
  return number;
}

// A key of a frame, or else of the document.
class Scope {
public:
  Scope(const JsonValue &root_, const JsonValue &frame_) : root(root_), frame(frame_) {}

  std::optional<JsonValue> find(const char *key) const {
    const auto own = frame.find(key);
    return own ? own : root.find(key);
  }
  double number(const char *key, double otherwise) const {
    const auto value = find(key);
    return value ? finite(*value) : otherwise;
  }
  uint32_t pixels(const char *key) const {
    const auto value = find(key);
    if (!value) frame.fail(std::string("expected \"") + key + "\" here or at the top, found neither");
    // Some writers give 1080.0.
    const double size = finite(*value);
    if (!(size >= 1 && size <= INT32_MAX && size == std::floor(size)))
      value->fail("expected a whole number of pixels > 0, found " + value->found());
    return static_cast<uint32_t>(size);
  }
  // A focal length, or the whole angle of view across size pixels; none if both are missing.
  std::optional<double> focal(const char *length, const char *angle, double size) const {
    if (const auto value = find(length)) return finite(*value);
    const auto value = find(angle);
    if (!value) return std::nullopt;
    const double radians = finite(*value);
    if (!(radians > 0 && radians < M_PI))
      value->fail("expected an angle between 0 and pi, found " + value->found());
    return size / 2 / std::tan(radians / 2);
  }

private:
  const JsonValue &root, &frame;
};

enum class Model { pinhole, radtan, fisheye };

Model read_model(const Scope &scope) {
  if (const auto value = scope.find("camera_model")) {
    const std::string name = value->text();
    if (name == "PINHOLE" || name == "SIMPLE_PINHOLE") return Model::pinhole;
    if (name == "OPENCV" || name == "SIMPLE_RADIAL" || name == "RADIAL") return Model::radtan;
    if (name == "OPENCV_FISHEYE") return Model::fisheye;
    value->fail("expected one of the camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, "
                "OPENCV_FISHEYE, found " +
                value->found());
  }
  // instant-ngp's own mark.
  const auto fisheye = scope.find("is_fisheye");
  return fisheye && fisheye->boolean() ? Model::fisheye : Model::radtan;
}

void refuse(const Scope &scope, std::initializer_list<const char *> keys, const char *why) {
  for (const char *key : keys)
    if (scope.number(key, 0) != 0) {
      const JsonValue value = *scope.find(key);
      value.fail(why + value.found());
    }
}

void read_lens(const Scope &scope, fvv_camera &camera) {
  const double k1 = scope.number("k1", 0), k2 = scope.number("k2", 0), k3 = scope.number("k3", 0);
  switch (read_model(scope)) {
  case Model::pinhole:
    refuse(scope, {"k1", "k2", "k3", "k4", "p1", "p2"}, "expected 0 for the camera model PINHOLE, found ");
    break;
  case Model::radtan: {
    // nerfstudio's k4 belongs to r^8, OpenCV's to the denominator; fvv has no r^8.
    refuse(scope, {"k4"}, "expected 0 for the camera model OPENCV, where k4 has no agreed meaning, found ");
    const double coefficients[8] = {k1, k2, scope.number("p1", 0), scope.number("p2", 0), k3};
    set_radtan(camera, coefficients);
    break;
  }
  case Model::fisheye: {
    refuse(scope, {"p1", "p2"}, "expected 0 for the camera model OPENCV_FISHEYE, found ");
    const double coefficients[4] = {k1, k2, k3, scope.number("k4", 0)};
    set_fisheye(camera, coefficients);
    break;
  }
  }
}

void read_pose(const JsonValue &matrix, fvv_camera &camera) {
  double axes[9], centre[3];
  for (size_t row = 0; row < 4; row++)
    for (size_t column = 0; column < 4; column++) {
      const JsonValue item = matrix.items(4, row).items(4, column);
      const double value = finite(item);
      if (row == 3 && value != (column == 3))
        item.fail(std::string("expected ") + (column == 3 ? "1" : "0") + " in the last row, found " +
                  item.found());
      if (row < 3 && column < 3) axes[3 * column + row] = value; // the columns are the axes
      if (row < 3 && column == 3) centre[row] = value;
    }
  set_pose_opengl(camera, axes, centre);
}

// Blender sets have no "w" and "h".
void set_size(const Scope &scope, const std::string &picture, fvv_camera &model) {
  std::error_code ignored;
  if (!scope.find("w") && !scope.find("h") && std::filesystem::is_regular_file(picture, ignored)) {
    const media::ImageInfo info = media::probe_image(picture);
    model.width = info.width;
    model.height = info.height;
    return;
  }
  model.width = scope.pixels("w");
  model.height = scope.pixels("h");
}

} // namespace

std::string nerfstudio_picture(const std::string &folder, const std::string &file_path) {
  const std::string path = (std::filesystem::path(folder) / file_path).lexically_normal().string();
  std::error_code ignored;
  for (const char *extension : {"", ".png", ".jpg", ".jpeg", ".exr"})
    if (std::filesystem::is_regular_file(path + extension, ignored)) return path + extension;
  return path;
}

namespace {

// A camera that stays where it is: its entries, in the order of their times.
using Moments = std::vector<std::vector<size_t>>;

// Pose, and lens where the entry has its own.
std::string camera_key(const JsonValue &root, const JsonValue &frame) {
  std::string key = frame.at("transform_matrix").raw();
  for (const char *name : {"w", "h", "fl_x", "fl_y", "cx", "cy", "camera_angle_x", "k1", "k2", "p1", "p2"})
    if (const auto value = Scope(root, frame).find(name)) key += " " + value->raw();
  return key;
}

// The key of the times of the entries; NULL: they have none. Only "time" is always one: a still scene may
// have the others too, but not several pictures of one camera.
const char *key_of_times(const JsonValue &root, const JsonValue &frames) {
  std::map<std::string, std::string> pictures; // by camera
  bool has_time = false;
  std::optional<size_t> second;
  for (size_t i = 0; i < frames.size(); i++) {
    const JsonValue frame = frames.item(i);
    has_time = has_time || frame.find("time");
    const std::string picture = frame.at("file_path").text();
    const auto [other, is_new] = pictures.emplace(camera_key(root, frame), picture);
    if (!is_new && other->second != picture && !second) second = i;
  }
  if (has_time) return "time";
  if (!second) return nullptr;
  for (const char *name : {"time_id", "timestamp", "frame_id"})
    if (frames.item(*second).find(name)) return name;
  frames.item(*second).fail(
      "expected a camera with a pose of its own, found a second picture of one: pictures of "
      "several moments need a \"time\"");
}

// Entries of unlike times (D-NeRF, HyperNeRF and 4DGS write them) are moments of few cameras: pictures of
// several moments must never colour one mesh. Empty: there is one moment.
Moments moments_of(const JsonValue &root, const JsonValue &frames) {
  const char *const key = key_of_times(root, frames);
  if (!key) return {};
  std::map<double, size_t> moments; // by time, and how many entries each has
  for (size_t i = 0; i < frames.size(); i++)
    if (const auto time = frames.item(i).find(key)) moments[finite(*time)]++;
  if (moments.size() < 2) return {};
  Moments out;
  std::map<std::string, size_t> cameras;
  std::vector<std::map<double, size_t>> times; // of each camera, and its entries
  for (size_t i = 0; i < frames.size(); i++) {
    const JsonValue frame = frames.item(i);
    const auto time = frame.find(key);
    if (!time) frame.fail(std::string("expected a \"") + key + "\" as other entries have, found none");
    const auto [camera, is_new] = cameras.emplace(camera_key(root, frame), times.size());
    if (is_new) times.emplace_back();
    if (!times[camera->second].emplace(finite(*time), i).second)
      time->fail("expected one picture of a camera and a moment, found a second one");
  }
  for (const auto &of_camera : times) {
    if (of_camera.size() != moments.size())
      frames.fail("has " + std::to_string(moments.size()) + " moments (\"" + key +
                  "\"): expected cameras that stay "
                  "where they are, each with a picture of every moment, found one with " +
                  std::to_string(of_camera.size()) + "; write a capture.json with a calibration per frame");
    out.emplace_back();
    for (const auto &[time, entry] : of_camera) out.back().push_back(entry);
  }
  return out;
}

} // namespace

Calibration read_nerfstudio(const std::string &file) {
  const nlohmann::json document = scene::parse_strict_json(scene::read_file(file, max_json_size), file);
  const JsonValue root(document, file), frames = root.at("frames");
  Calibration calibration;
  std::vector<size_t> entries; // of each camera the first one
  for (const std::vector<size_t> &of_camera : moments_of(root, frames)) {
    entries.push_back(of_camera.front());
    calibration.moments.emplace_back();
    for (const size_t entry : of_camera)
      calibration.moments.back().push_back(frames.item(entry).at("file_path").text());
  }
  for (size_t i = 0; i < frames.size() && calibration.moments.empty(); i++) entries.push_back(i);
  for (const size_t entry : entries)
    calibration.pictures.push_back(frames.item(entry).at("file_path").text());
  for (size_t i = 0; i < frames.size() && calibration.notes.empty(); i++)
    if (frames.item(i).find("mask_path"))
      calibration.notes.push_back(
          "names masks (\"mask_path\"), which are not used, because some hide what moves and "
          "others show it: " +
          option_name("masks") + " gives them");
  const std::vector<std::string> names = names_of_pictures(calibration.pictures);
  const std::string folder = std::filesystem::path(file).parent_path().string();
  for (size_t i = 0; i < entries.size(); i++) {
    const JsonValue frame = frames.item(entries[i]);
    const Scope scope(root, frame);
    scene::Camera camera;
    camera.set_name(names[i]);
    fvv_camera &model = camera.calibration;
    model.id = static_cast<uint16_t>(i); // append() allows far fewer cameras than ids
    set_size(scope, nerfstudio_picture(folder, calibration.pictures[i]), model);
    const auto fx = scope.focal("fl_x", "camera_angle_x", model.width);
    if (!fx) frame.fail("expected \"fl_x\" or \"camera_angle_x\" here or at the top, found neither");
    model.fx = *fx;
    model.fy = scope.focal("fl_y", "camera_angle_y", model.height).value_or(*fx);
    model.cx = scope.number("cx", model.width / 2.0);
    model.cy = scope.number("cy", model.height / 2.0);
    read_lens(scope, model);
    read_pose(frame.at("transform_matrix"), model);
    append(calibration, std::move(camera), file + ": /frames/" + std::to_string(entries[i]));
  }
  require_cameras(calibration, file);
  return calibration;
}

} // namespace fvv::import
