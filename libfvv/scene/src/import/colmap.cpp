// COLMAP's text model (https://colmap.github.io/format.html, models as in its sensor/models.h). Its axes, its
// pixel centres (+0.5) and its order of coefficients are those of fvv.

#include "fvv_scene/text.h"
#include "scene/src/import/camera.h"

#include <cmath>
#include <filesystem>
#include <map>

namespace fvv::import {

namespace {

// images.txt lists the keypoints of every image, which are not used.
constexpr uint64_t max_images_size = uint64_t(1) << 30;

struct Model {
  const char *name;
  unsigned focal_lengths; // one for both axes, or two
  uint8_t lens;
  unsigned coefficients; // as many as the model has of fvv's, in fvv's order
};
constexpr Model models[] = {{"SIMPLE_PINHOLE", 1, FVV_LENS_NONE, 0},
                            {"PINHOLE", 2, FVV_LENS_NONE, 0},
                            {"SIMPLE_RADIAL", 1, FVV_LENS_RADTAN, 1},
                            {"RADIAL", 1, FVV_LENS_RADTAN, 2},
                            {"OPENCV", 2, FVV_LENS_RADTAN, 4},
                            {"FULL_OPENCV", 2, FVV_LENS_RADTAN, 8},
                            {"SIMPLE_RADIAL_FISHEYE", 1, FVV_LENS_FISHEYE, 1},
                            {"RADIAL_FISHEYE", 1, FVV_LENS_FISHEYE, 2},
                            {"OPENCV_FISHEYE", 2, FVV_LENS_FISHEYE, 4}};

const Model &model_named(const Lines &lines, std::string_view name) {
  std::string known;
  for (const Model &model : models) {
    if (name == model.name) return model;
    known += (known.empty() ? "" : ", ") + std::string(model.name);
  }
  lines.fail("expected one of the camera models " + known + ", found " + scene::quote(name));
}

std::map<int64_t, fvv_camera> read_cameras(const std::string &path) {
  const std::string bytes = scene::read_file(path, max_text_size);
  Lines lines(bytes, path);
  std::map<int64_t, fvv_camera> cameras;
  for (std::string_view line; lines.next_content(line);) {
    const auto words = words_of(line);
    if (words.size() < 4)
      lines.fail("expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS[], found " + scene::quote(line));
    const int64_t id = lines.integer(words[0], "CAMERA_ID", 0, UINT32_MAX);
    const Model &model = model_named(lines, words[1]);
    fvv_camera camera = {};
    camera.width = static_cast<uint32_t>(lines.integer(words[2], "WIDTH", 1, INT32_MAX));
    camera.height = static_cast<uint32_t>(lines.integer(words[3], "HEIGHT", 1, INT32_MAX));
    const unsigned count = model.focal_lengths + 2 + model.coefficients;
    if (words.size() != 4 + count)
      lines.fail("expected " + std::to_string(count) + " parameters for " + model.name + ", found " +
                 std::to_string(words.size() - 4));
    std::vector<double> parameters;
    for (size_t i = 4; i < words.size(); i++) parameters.push_back(lines.real(words[i], "PARAMS[]"));
    const double *rest = parameters.data() + model.focal_lengths;
    camera.fx = parameters[0];
    camera.fy = rest[-1];
    camera.cx = rest[0];
    camera.cy = rest[1];
    double coefficients[8] = {};
    std::copy(rest + 2, rest + 2 + model.coefficients, coefficients);
    if (model.lens == FVV_LENS_RADTAN) set_radtan(camera, coefficients);
    if (model.lens == FVV_LENS_FISHEYE) set_fisheye(camera, coefficients);
    if (!cameras.emplace(id, camera).second)
      lines.fail("expected every CAMERA_ID once, found " + std::to_string(id) + " again");
  }
  return cameras;
}

// Hamilton's convention, w first.
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

Image read_image(const Lines &lines, std::string_view line, const std::map<int64_t, fvv_camera> &cameras) {
  std::string_view rest = line, words[9];
  for (std::string_view &word : words)
    if (!scene::next_word(rest, word))
      lines.fail("expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, found " + scene::quote(line));
  const size_t begin = rest.find_first_not_of(" \t"), end = rest.find_last_not_of(" \t");
  if (begin == rest.npos) lines.fail("expected NAME after CAMERA_ID, found the end of the line");
  const int64_t id = lines.integer(words[0], "IMAGE_ID", 0, UINT16_MAX - 1);
  const auto found = cameras.find(lines.integer(words[8], "CAMERA_ID", 0, UINT32_MAX));
  if (found == cameras.end())
    lines.fail("expected a CAMERA_ID of cameras.txt, found " + scene::quote(words[8]));
  Image image = {found->second, std::string(rest.substr(begin, end + 1 - begin)), lines.where()};
  image.camera.id = static_cast<uint16_t>(id);
  double q[4], square = 0;
  for (int i = 0; i < 4; i++) {
    q[i] = lines.real(words[1 + i], "QW QX QY QZ");
    square += q[i] * q[i];
  }
  const double norm = std::sqrt(square);
  if (!(std::fabs(norm - 1) <= 1e-4)) {
    std::string text;
    scene::append_double(text, norm);
    lines.fail("expected a quaternion QW QX QY QZ of length 1 within 1e-4, found length " + text);
  }
  for (double &part : q) part /= norm;
  set_rotation(image.camera, q);
  for (int i = 0; i < 3; i++) image.camera.translation[i] = lines.real(words[5 + i], "TX TY TZ");
  return image;
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

} // namespace

Calibration read_colmap(const std::string &folder) {
  const auto file = [&](const char *name) { return (std::filesystem::path(folder) / name).string(); };
  const auto cameras = read_cameras(file("cameras.txt"));
  const std::string path = file("images.txt"), bytes = scene::read_file(path, max_images_size);
  Lines lines(bytes, path);
  std::vector<Image> images;
  std::vector<std::string> pictures;
  for (std::string_view line; lines.next_content(line);) {
    images.push_back(read_image(lines, line, cameras));
    pictures.push_back(images.back().picture);
    // The keypoints follow on a line of their own, which may be empty. Without it every second image would be
    // lost.
    if (lines.next(line)) check_keypoints(lines, line);
  }
  const std::vector<std::string> names = names_of_pictures(pictures);
  Calibration calibration;
  for (size_t i = 0; i < images.size(); i++) {
    scene::Camera camera;
    camera.calibration = images[i].camera;
    camera.set_name(names[i]);
    append(calibration, std::move(camera), images[i].where);
  }
  require_cameras(calibration, path);
  return calibration;
}

} // namespace fvv::import
