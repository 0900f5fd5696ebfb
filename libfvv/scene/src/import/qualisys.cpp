// Calibrations of Qualisys Track Manager. Lengths in millimetres, pixels in units of 1/64, r11 ... r33 from
// the world to a camera with y up and z backwards, x y z its position.

#include "fvv_scene/file_io.h"
#include "scene/src/import/camera.h"
#include "scene/src/import/tree.h"

#include <cmath>

namespace fvv::import {

namespace {

constexpr double units_per_pixel = 64;

class Element {
public:
  Element(const std::string &path_, const Node &node_) : path(path_), node(node_) {}

  double number(const char *key) const { return number_at(path, node.line, node.attribute(path, key), key); }
  int64_t integer(const char *key, int64_t least, int64_t most) const {
    return integer_at(path, node.line, node.attribute(path, key), key, least, most);
  }
  Element child(const char *key) const { return {path, node.child(path, key)}; }
  [[noreturn]] void fail(const std::string &what) const { fail_at(path, node.line, what); }
  void expect_zero(const char *key, const char *why) const {
    if (number(key) != 0)
      fail(std::string("expected ") + key + " to be 0" + why + ", found " + node.attribute(path, key));
  }
  const std::string &text(const char *key) const { return node.attribute(path, key); }

private:
  const std::string &path;
  const Node &node;
};

struct Window {
  int64_t left, top, width, height;
};

Window read_window(const Element &element) {
  const int64_t left = element.integer("left", 0, UINT16_MAX), top = element.integer("top", 0, UINT16_MAX);
  return {left, top, element.integer("right", left, UINT16_MAX) - left + 1,
          element.integer("bottom", top, UINT16_MAX) - top + 1};
}

// A file in other units, or of a camera that bins its pixels, would be read with a wrong focal length.
void check_units(const Element &intrinsic, const char *least, const char *most, int64_t pixels) {
  const double found = intrinsic.number(most) - intrinsic.number(least);
  const double expected = units_per_pixel * static_cast<double>(pixels - 1);
  if (std::fabs(found - expected) > units_per_pixel) {
    std::string text = std::string("expected ") + most + " - " + least + " to be about ";
    scene::append_double(text, expected);
    text += ", 64 for each pixel of fov_video_max, found ";
    scene::append_double(text, found);
    intrinsic.fail(text);
  }
}

fvv_camera read_camera(const Element &element) {
  element.expect_zero("viewrotation", " (turned pictures are not supported)");
  const Window window = read_window(element.child("fov_video"));
  const Window whole = read_window(element.child("fov_video_max"));
  const Element intrinsic = element.child("intrinsic"), transform = element.child("transform");
  check_units(intrinsic, "sensorMinU", "sensorMaxU", whole.width);
  check_units(intrinsic, "sensorMinV", "sensorMaxV", whole.height);
  fvv_camera camera = {};
  camera.width = static_cast<uint32_t>(window.width);
  camera.height = static_cast<uint32_t>(window.height);
  camera.fx = intrinsic.number("focalLengthU") / units_per_pixel;
  camera.fy = intrinsic.number("focalLengthV") / units_per_pixel;
  camera.cx = intrinsic.number("centerPointU") / units_per_pixel - static_cast<double>(window.left) + 0.5;
  camera.cy = intrinsic.number("centerPointV") / units_per_pixel - static_cast<double>(window.top) + 0.5;
  intrinsic.expect_zero("skew", "");
  // The attributes really are spelt "tangental".
  const double coefficients[8] = {
      intrinsic.number("radialDistortion1"), intrinsic.number("radialDistortion2"),
      intrinsic.number("tangentalDistortion1"), intrinsic.number("tangentalDistortion2"),
      intrinsic.number("radialDistortion3")};
  set_radtan(camera, coefficients);
  const char *const names[9] = {"r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"};
  double axes[9];
  for (int i = 0; i < 9; i++) axes[i] = transform.number(names[i]);
  const double centre[3] = {transform.number("x"), transform.number("y"), transform.number("z")};
  set_pose_opengl(camera, axes, centre);
  return camera;
}

} // namespace

Calibration read_qualisys(const std::string &file) {
  const Node root = parse_xml(scene::read_file(file, max_xml_size), file);
  if (root.name != "calibration")
    fail_at(file, root.line, "expected <calibration>, found <" + root.name.substr(0, 40) + ">");
  Calibration calibration;
  calibration.metres_per_unit = 0.001;
  for (const Node &node : root.child(file, "cameras").children) {
    if (node.name != "camera")
      fail_at(file, node.line, "expected <camera>, found <" + node.name.substr(0, 40) + ">");
    const Element element(file, node);
    if (element.integer("active", 0, 1) == 0) continue;
    scene::Camera camera;
    camera.calibration = read_camera(element);
    camera.calibration.id = static_cast<uint16_t>(calibration.cameras.size()); // append() allows far fewer
    camera.set_name(element.text("serial"));
    append(calibration, std::move(camera), file + ":" + std::to_string(node.line));
  }
  require_cameras(calibration, file);
  return calibration;
}

} // namespace fvv::import
