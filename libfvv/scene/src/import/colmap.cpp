// COLMAP's model, binary or text (https://colmap.github.io/format.html, models as in its sensor/models.h).
// Its axes, its pixel centres (+0.5) and its order of coefficients are those of fvv.

#include "fvv_scene/file_io.h"
#include "scene/src/import/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>

namespace fvv::import {

namespace {

// The keypoints of every image are listed with it, and not used.
constexpr uint64_t max_images_size = uint64_t(1) << 30;

struct Model {
  const char *name;
  unsigned focal_lengths; // one for both axes, or two
  uint8_t lens;
  unsigned coefficients; // as many as the model has of fvv's, in fvv's order
  int32_t id;            // in binary files

  unsigned parameters() const { return focal_lengths + 2 + coefficients; }
};
constexpr Model models[] = {{"SIMPLE_PINHOLE", 1, FVV_LENS_NONE, 0, 0},
                            {"PINHOLE", 2, FVV_LENS_NONE, 0, 1},
                            {"SIMPLE_RADIAL", 1, FVV_LENS_RADTAN, 1, 2},
                            {"RADIAL", 1, FVV_LENS_RADTAN, 2, 3},
                            {"OPENCV", 2, FVV_LENS_RADTAN, 4, 4},
                            {"FULL_OPENCV", 2, FVV_LENS_RADTAN, 8, 6},
                            {"SIMPLE_RADIAL_FISHEYE", 1, FVV_LENS_FISHEYE, 1, 8},
                            {"RADIAL_FISHEYE", 1, FVV_LENS_FISHEYE, 2, 9},
                            {"OPENCV_FISHEYE", 2, FVV_LENS_FISHEYE, 4, 5},
                            {"SIMPLE_FISHEYE", 1, FVV_LENS_FISHEYE, 0, 14},
                            {"FISHEYE", 2, FVV_LENS_FISHEYE, 0, 15}};
// Those that fvv does not have, for messages.
constexpr struct {
  int32_t id;
  const char *name;
} refused_models[] = {{7, "FOV"},
                      {10, "THIN_PRISM_FISHEYE"},
                      {11, "RAD_TAN_THIN_PRISM_FISHEYE"},
                      {12, "SIMPLE_DIVISION"},
                      {13, "DIVISION"}};

[[noreturn]] void refuse_model(const std::string &where, const std::string &found) {
  std::string known;
  for (const Model &model : models) known += (known.empty() ? "" : ", ") + std::string(model.name);
  throw Error(where + ": expected one of the camera models " + known + ", found " + found);
}

const Model &model_named(const std::string &where, std::string_view name) {
  for (const Model &model : models)
    if (name == model.name) return model;
  refuse_model(where, scene::quote(name));
}

const Model &model_numbered(const std::string &where, int32_t id) {
  for (const Model &model : models)
    if (id == model.id) return model;
  for (const auto &refused : refused_models)
    if (id == refused.id) refuse_model(where, scene::quote(refused.name));
  refuse_model(where, "the number " + std::to_string(id));
}

// parameters: as many as the model has.
void set_intrinsics(fvv_camera &camera, const Model &model, const double *parameters) {
  const double *rest = parameters + model.focal_lengths;
  camera.fx = parameters[0];
  camera.fy = rest[-1];
  camera.cx = rest[0];
  camera.cy = rest[1];
  double coefficients[8] = {};
  std::copy(rest + 2, rest + 2 + model.coefficients, coefficients);
  if (model.lens == FVV_LENS_RADTAN) set_radtan(camera, coefficients);
  if (model.lens == FVV_LENS_FISHEYE) set_fisheye(camera, coefficients);
}

using CamerasById = std::map<int64_t, fvv_camera>;

void add_camera(CamerasById &cameras, const std::string &where, int64_t id, const fvv_camera &camera) {
  if (!cameras.emplace(id, camera).second)
    throw Error(where + ": expected every CAMERA_ID once, found " + std::to_string(id) + " again");
}

CamerasById read_cameras_text(const std::string &path) {
  const std::string bytes = scene::read_file(path, max_text_size);
  Lines lines(bytes, path);
  CamerasById cameras;
  for (std::string_view line; lines.next_content(line);) {
    const auto words = words_of(line);
    if (words.size() < 4)
      lines.fail("expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS[], found " + scene::quote(line));
    const int64_t id = lines.integer(words[0], "CAMERA_ID", 0, UINT32_MAX);
    const Model &model = model_named(lines.where(), words[1]);
    fvv_camera camera = {};
    camera.width = static_cast<uint32_t>(lines.integer(words[2], "WIDTH", 1, INT32_MAX));
    camera.height = static_cast<uint32_t>(lines.integer(words[3], "HEIGHT", 1, INT32_MAX));
    if (words.size() != 4 + model.parameters())
      lines.fail("expected " + std::to_string(model.parameters()) + " parameters for " + model.name +
                 ", found " + std::to_string(words.size() - 4));
    std::vector<double> parameters;
    for (size_t i = 4; i < words.size(); i++) parameters.push_back(lines.real(words[i], "PARAMS[]"));
    set_intrinsics(camera, model, parameters.data());
    add_camera(cameras, lines.where(), id, camera);
  }
  return cameras;
}

// Hamilton's convention, w first; of length 1.
void set_rotation(fvv_camera &camera, const double q[4]) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double r[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                       2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                       2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
  std::copy(r, r + 9, camera.rotation);
}

struct Image {
  fvv_camera camera;
  std::string picture, where;
};

// QW QX QY QZ TX TY TZ, from one frame of reference to another.
using Pose = std::array<double, 7>;

// First b, then a.
Pose operator*(const Pose &a, const Pose &b) {
  const double *p = a.data(), *q = b.data();
  Pose out = {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
              p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
              p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
              p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
              a[4],
              a[5],
              a[6]};
  fvv_camera turn = {};
  set_rotation(turn, p);
  for (size_t row = 0; row < 3; row++)
    for (size_t column = 0; column < 3; column++)
      out[4 + row] += turn.rotation[3 * row + column] * b[4 + column];
  return out;
}

// Of rigs and frames, which COLMAP has from 3.12 on: its own readers take poses from these, and what is in
// the list of images may be older.
struct Rigs {
  // Of each rig, by type and identifier of the sensor.
  using Sensor = std::pair<int64_t, int64_t>;
  std::map<int64_t, std::map<Sensor, std::optional<Pose>>> sensor_from_rig;
  std::map<int64_t, Pose> images; // by identifier: from the world to the camera

  void add(const std::string &where, int64_t rig, const Sensor &sensor, std::optional<Pose> pose) {
    if (!sensor_from_rig[rig].emplace(sensor, pose).second)
      throw Error(where + ": expected every sensor of a rig once, found one again");
  }
  void add_frame(const std::string &where, int64_t rig, const Pose &rig_from_world, const Sensor &sensor,
                 int64_t image) {
    if (sensor.first != camera) return;
    const auto found = sensor_from_rig.find(rig);
    if (found == sensor_from_rig.end())
      throw Error(where + ": expected a RIG_ID of the rigs, found " + std::to_string(rig));
    const auto pose = found->second.find(sensor);
    if (pose == found->second.end() || !pose->second)
      throw Error(where + ": expected a camera whose place in its rig is known, found camera " +
                  std::to_string(sensor.second) + " of rig " + std::to_string(rig));
    if (!images.emplace(image, *pose->second * rig_from_world).second)
      throw Error(where + ": expected every image in one frame, found " + std::to_string(image) + " again");
  }

  static constexpr int64_t camera = 0; // a type of sensors
};

// What a list of images refers to.
struct Known {
  const CamerasById &cameras;
  const Rigs &rigs;
  const char *file; // with the cameras
};

// given: QW QX QY QZ TX TY TZ, finite.
Image make_image(const std::string &where, int64_t id, const double given[7], int64_t camera,
                 const std::string &picture, const Known &known) {
  const auto by_rig = known.rigs.images.find(id);
  if (by_rig == known.rigs.images.end() && !known.rigs.images.empty())
    throw Error(where + ": expected an image of one of the frames, found image " + std::to_string(id) +
                ", which is in none");
  const double *pose = by_rig == known.rigs.images.end() ? given : by_rig->second.data();
  const CamerasById &cameras = known.cameras;
  const auto found = cameras.find(camera);
  if (found == cameras.end())
    throw Error(where + ": expected a CAMERA_ID of " + known.file + ", found \"" + std::to_string(camera) +
                "\"");
  Image image = {found->second, picture, where};
  image.camera.id = static_cast<uint16_t>(id);
  double q[4], square = 0;
  for (int i = 0; i < 4; i++) {
    q[i] = pose[i];
    square += q[i] * q[i];
  }
  const double norm = std::sqrt(square);
  if (!(std::fabs(norm - 1) <= 1e-4)) {
    std::string text;
    scene::append_double(text, norm);
    throw Error(where + ": expected a quaternion QW QX QY QZ of length 1 within 1e-4, found length " + text);
  }
  for (double &part : q) part /= norm;
  set_rotation(image.camera, q);
  std::copy(pose + 4, pose + 7, image.camera.translation);
  return image;
}

Image read_image(const Lines &lines, std::string_view line, const Known &known) {
  std::string_view rest = line, words[9];
  for (std::string_view &word : words)
    if (!scene::next_word(rest, word))
      lines.fail("expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, found " + scene::quote(line));
  const size_t begin = rest.find_first_not_of(" \t"), end = rest.find_last_not_of(" \t");
  if (begin == rest.npos) lines.fail("expected NAME after CAMERA_ID, found the end of the line");
  const int64_t id = lines.integer(words[0], "IMAGE_ID", 0, UINT16_MAX - 1);
  const int64_t camera = lines.integer(words[8], "CAMERA_ID", 0, UINT32_MAX);
  double pose[7];
  for (int i = 0; i < 7; i++) pose[i] = lines.real(words[1 + i], i < 4 ? "QW QX QY QZ" : "TX TY TZ");
  return make_image(lines.where(), id, pose, camera, std::string(rest.substr(begin, end + 1 - begin)), known);
}

// May be as long as the file: no list of words is made of it.
void check_keypoints(const Lines &lines, std::string_view line) {
  std::string_view rest = line, word;
  size_t count = 0;
  while (scene::next_word(rest, word)) count++;
  if (count % 3)
    lines.fail("expected the line of keypoints (X Y POINT3D_ID ...; may be empty) after an image, found " +
               scene::quote(line));
  for (rest = line; scene::next_word(rest, word);) lines.real(word, "X Y POINT3D_ID");
}

std::vector<Image> read_images_text(const std::string &path, const Known &known) {
  const std::string bytes = scene::read_file(path, max_images_size);
  Lines lines(bytes, path);
  std::vector<Image> images;
  for (std::string_view line; lines.next_content(line);) {
    images.push_back(read_image(lines, line, known));
    // The keypoints follow on a line of their own, which may be empty. Without it every second image would be
    // lost.
    if (lines.next(line)) check_keypoints(lines, line);
  }
  return images;
}

// TYPE ID of a sensor, as words[at].
Rigs::Sensor sensor_of(const Lines &lines, const std::vector<std::string_view> &words, size_t at) {
  if (at + 1 >= words.size())
    lines.fail("expected a sensor's type and identifier, found the end of the line");
  const int64_t type = words[at] == "CAMERA" ? Rigs::camera : words[at] == "IMU" ? 1 : -1;
  return {type, lines.integer(words[at + 1], "SENSOR_ID", 0, UINT32_MAX)};
}

Pose pose_of(const Lines &lines, const std::vector<std::string_view> &words, size_t at) {
  if (at + 7 > words.size()) lines.fail("expected QW QX QY QZ TX TY TZ, found the end of the line");
  Pose pose;
  for (size_t i = 0; i < 7; i++) pose[i] = lines.real(words[at + i], i < 4 ? "QW QX QY QZ" : "TX TY TZ");
  return pose;
}

constexpr Pose unmoved = {1, 0, 0, 0, 0, 0, 0};

Rigs read_rigs_text(const std::string &rigs_path, const std::string &frames_path) {
  Rigs rigs;
  const std::string rig_bytes = scene::read_file(rigs_path, max_text_size);
  Lines lines(rig_bytes, rigs_path);
  for (std::string_view line; lines.next_content(line);) {
    const auto words = words_of(line);
    if (words.size() < 2) lines.fail("expected RIG_ID NUM_SENSORS ..., found " + scene::quote(line));
    const int64_t rig = lines.integer(words[0], "RIG_ID", 0, UINT32_MAX);
    const int64_t count = lines.integer(words[1], "NUM_SENSORS", 0, UINT32_MAX);
    if (!count) continue;
    rigs.add(lines.where(), rig, sensor_of(lines, words, 2), unmoved);
    size_t at = 4;
    for (int64_t i = 1; i < count; i++) {
      const Rigs::Sensor sensor = sensor_of(lines, words, at);
      if (at + 2 >= words.size()) lines.fail("expected HAS_POSE, found the end of the line");
      const bool has_pose = lines.integer(words[at + 2], "HAS_POSE", 0, 1) == 1;
      at += 3;
      rigs.add(lines.where(), rig, sensor,
               has_pose ? std::optional(pose_of(lines, words, at)) : std::nullopt);
      if (has_pose) at += 7;
    }
  }
  const std::string frame_bytes = scene::read_file(frames_path, max_images_size);
  Lines frames(frame_bytes, frames_path);
  for (std::string_view line; frames.next_content(line);) {
    const auto words = words_of(line);
    if (words.size() < 10)
      frames.fail("expected FRAME_ID RIG_ID RIG_FROM_WORLD[7] NUM_DATA_IDS ..., found " + scene::quote(line));
    const int64_t rig = frames.integer(words[1], "RIG_ID", 0, UINT32_MAX);
    const Pose pose = pose_of(frames, words, 2);
    const int64_t count = frames.integer(words[9], "NUM_DATA_IDS", 0, UINT32_MAX);
    for (int64_t i = 0; i < count; i++) {
      const size_t at = 10 + size_t(i) * 3;
      const Rigs::Sensor sensor = sensor_of(frames, words, at);
      if (at + 2 >= words.size()) frames.fail("expected DATA_ID, found the end of the line");
      rigs.add_frame(frames.where(), rig, pose, sensor,
                     frames.integer(words[at + 2], "DATA_ID", 0, INT64_MAX));
    }
  }
  return rigs;
}

// Little-endian numbers of a binary file. Borrows bytes and path.
class Numbers {
public:
  Numbers(std::string_view bytes, const std::string &path) : rest(bytes), name(path), size(bytes.size()) {}

  std::string where() const { return name + ": byte " + std::to_string(size - rest.size()); }
  [[noreturn]] void fail(const std::string &what) const { throw Error(where() + ": " + what); }

  uint64_t integer(size_t width, const char *what) {
    need(width, what);
    uint64_t value = 0;
    for (size_t i = width; i--;) value = value << 8 | static_cast<unsigned char>(rest[i]);
    rest.remove_prefix(width);
    return value;
  }
  double real(const char *what) {
    const std::string place = where();
    const uint64_t bits = integer(8, what);
    double value;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) throw Error(place + ": expected a finite number for " + what + ", found none");
    return value;
  }
  // Ended by a zero byte.
  std::string text(const char *what) {
    const size_t end = rest.find('\0');
    if (end == rest.npos || !end || end > max_name)
      fail(std::string("expected ") + what + " of at most " + std::to_string(max_name) +
           " bytes and a zero byte, found " + (end ? "none" : "an empty name"));
    std::string out(rest.substr(0, end));
    rest.remove_prefix(end + 1);
    return out;
  }
  void skip(uint64_t count, uint64_t width, const char *what) {
    if (count > rest.size() / width)
      fail("expected " + std::to_string(count) + " " + what + ", found the end of the file");
    rest.remove_prefix(size_t(count * width));
  }
  void expect_end() const {
    if (!rest.empty()) fail("expected the end of the file, found " + std::to_string(rest.size()) + " bytes");
  }

private:
  static constexpr size_t max_name = 4096;

  void need(size_t width, const char *what) const {
    if (rest.size() < width) fail(std::string("expected ") + what + ", found the end of the file");
  }

  std::string_view rest;
  const std::string &name;
  size_t size;
};

CamerasById read_cameras_binary(const std::string &path) {
  const std::string bytes = scene::read_file(path, max_text_size);
  Numbers numbers(bytes, path);
  CamerasById cameras;
  for (uint64_t left = numbers.integer(8, "the number of cameras"); left--;) {
    const std::string where = numbers.where();
    const auto id = int64_t(numbers.integer(4, "CAMERA_ID"));
    const Model &model =
        model_numbered(where, static_cast<int32_t>(static_cast<uint32_t>(numbers.integer(4, "MODEL_ID"))));
    fvv_camera camera = {};
    for (uint32_t *side : {&camera.width, &camera.height}) {
      const char *name = side == &camera.width ? "WIDTH" : "HEIGHT";
      const uint64_t pixels = numbers.integer(8, name);
      if (pixels < 1 || pixels > INT32_MAX)
        throw Error(where + ": expected an integer from 1 to 2147483647 for " + name + ", found " +
                    std::to_string(pixels));
      *side = uint32_t(pixels);
    }
    std::vector<double> parameters;
    for (unsigned i = 0; i < model.parameters(); i++) parameters.push_back(numbers.real("PARAMS[]"));
    set_intrinsics(camera, model, parameters.data());
    add_camera(cameras, where, id, camera);
  }
  numbers.expect_end();
  return cameras;
}

std::vector<Image> read_images_binary(const std::string &path, const Known &known) {
  const std::string bytes = scene::read_file(path, max_images_size);
  Numbers numbers(bytes, path);
  std::vector<Image> images;
  for (uint64_t left = numbers.integer(8, "the number of images"); left--;) {
    const std::string where = numbers.where();
    const uint64_t id = numbers.integer(4, "IMAGE_ID");
    if (id >= UINT16_MAX)
      throw Error(where + ": expected an integer from 0 to 65534 for IMAGE_ID, found " + std::to_string(id));
    double pose[7];
    for (int i = 0; i < 7; i++) pose[i] = numbers.real(i < 4 ? "QW QX QY QZ" : "TX TY TZ");
    const auto camera = int64_t(numbers.integer(4, "CAMERA_ID"));
    const std::string picture = numbers.text("NAME");
    images.push_back(make_image(where, int64_t(id), pose, camera, picture, known));
    const uint64_t keypoints = numbers.integer(8, "the number of keypoints");
    numbers.skip(keypoints, 24, "keypoints");
  }
  numbers.expect_end();
  return images;
}

Rigs read_rigs_binary(const std::string &rigs_path, const std::string &frames_path) {
  Rigs rigs;
  const std::string rig_bytes = scene::read_file(rigs_path, max_text_size);
  Numbers numbers(rig_bytes, rigs_path);
  const auto sensor = [](Numbers &from) {
    const auto type = int64_t(static_cast<int32_t>(static_cast<uint32_t>(from.integer(4, "SENSOR_TYPE"))));
    return Rigs::Sensor(type, int64_t(from.integer(4, "SENSOR_ID")));
  };
  const auto pose = [](Numbers &from) {
    Pose out;
    for (size_t i = 0; i < 7; i++) out[i] = from.real(i < 4 ? "QW QX QY QZ" : "TX TY TZ");
    return out;
  };
  for (uint64_t left = numbers.integer(8, "the number of rigs"); left--;) {
    const auto rig = int64_t(numbers.integer(4, "RIG_ID"));
    const uint64_t count = numbers.integer(4, "NUM_SENSORS");
    for (uint64_t i = 0; i < count; i++) {
      const std::string where = numbers.where();
      const Rigs::Sensor which = sensor(numbers);
      const bool has_pose = i == 0 || numbers.integer(1, "HAS_POSE") != 0;
      rigs.add(where, rig, which, !has_pose ? std::nullopt : std::optional(i == 0 ? unmoved : pose(numbers)));
    }
  }
  numbers.expect_end();
  const std::string frame_bytes = scene::read_file(frames_path, max_images_size);
  Numbers frames(frame_bytes, frames_path);
  for (uint64_t left = frames.integer(8, "the number of frames"); left--;) {
    const std::string where = frames.where();
    frames.integer(4, "FRAME_ID");
    const auto rig = int64_t(frames.integer(4, "RIG_ID"));
    const Pose rig_from_world = pose(frames);
    for (uint64_t count = frames.integer(4, "NUM_DATA_IDS"); count--;) {
      const Rigs::Sensor which = sensor(frames);
      rigs.add_frame(where, rig, rig_from_world, which, int64_t(frames.integer(8, "DATA_ID")));
    }
  }
  frames.expect_end();
  return rigs;
}

bool is_file(const std::filesystem::path &path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

bool has_model(const std::filesystem::path &folder, const char *extension) {
  return is_file(folder / (std::string("cameras") + extension)) &&
         is_file(folder / (std::string("images") + extension));
}

} // namespace

std::optional<std::string> find_colmap(const std::string &folder) {
  const std::filesystem::path root(folder), sparse = root / "sparse";
  const auto is_model = [](const std::filesystem::path &path) {
    return has_model(path, ".bin") || has_model(path, ".txt");
  };
  for (const std::filesystem::path &path : {root, sparse})
    if (is_model(path)) return path.string();
  // Of pictures that it cannot join, COLMAP makes several models.
  std::vector<std::string> found;
  std::error_code error;
  std::filesystem::directory_iterator entry(sparse, error), end;
  for (; !error && entry != end; entry.increment(error))
    if (is_model(entry->path())) found.push_back(entry->path().string());
  if (found.empty()) return std::nullopt;
  std::sort(found.begin(), found.end());
  if (found.size() > 1)
    throw Error(folder + ": expected one COLMAP model, found " + found[0] + " and " + found[1] +
                ": pass the folder of one of them");
  return found[0];
}

std::vector<std::string> colmap_files(const std::string &folder) {
  const std::filesystem::path model = find_colmap(folder).value_or(folder);
  const char *extension = has_model(model, ".bin") ? ".bin" : ".txt"; // as COLMAP chooses
  std::vector<std::string> out;
  for (const char *name : {"cameras", "images"})
    out.push_back((model / (name + std::string(extension))).string());
  const std::string rigs = (model / (std::string("rigs") + extension)).string(),
                    frames = (model / (std::string("frames") + extension)).string();
  if (is_file(rigs) != is_file(frames))
    throw Error(
        (is_file(rigs) ? rigs + ": expected " + frames : frames + ": expected " + rigs) +
        " too, as both hold the poses: copy it, or take this one away for those in the list of images");
  if (is_file(rigs)) out.insert(out.end(), {rigs, frames});
  return out;
}

Calibration read_colmap(const std::string &folder) {
  const std::vector<std::string> files = colmap_files(folder);
  const bool binary = std::filesystem::path(files[0]).extension() == ".bin";
  const CamerasById cameras = (binary ? read_cameras_binary : read_cameras_text)(files[0]);
  const Rigs rigs =
      files.size() > 2 ? (binary ? read_rigs_binary : read_rigs_text)(files[2], files[3]) : Rigs();
  const Known known = {cameras, rigs, binary ? "cameras.bin" : "cameras.txt"};
  const std::vector<Image> images = (binary ? read_images_binary : read_images_text)(files[1], known);
  Calibration calibration;
  for (const Image &image : images) calibration.pictures.push_back(image.picture);
  const std::vector<std::string> names = names_of_pictures(calibration.pictures);
  for (size_t i = 0; i < images.size(); i++) {
    scene::Camera camera;
    camera.calibration = images[i].camera;
    camera.set_name(names[i]);
    append(calibration, std::move(camera), images[i].where);
  }
  require_cameras(calibration, files[1]);
  return calibration;
}

} // namespace fvv::import
