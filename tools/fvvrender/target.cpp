#include "fvvrender/target.h"

#include "cli/cli.h"
#include "fvv_demux/views.h"

#include <cmath>
#include <limits>

namespace fvv::rendering {

namespace {

using render::Vec3;

[[noreturn]] void refuse(const std::string &line) {
  throw Error(line, Error::usage);
}

void take_size(const std::string &text, uint32_t &width, uint32_t &height) {
  if (text.empty()) return;
  cli::parse_size("--size", text, width, height);
  if (width < 1 || height < 1 || width > media::max_dimension || height > media::max_dimension)
    refuse("--size: expected sides of 1 to " + std::to_string(media::max_dimension) + ", found " + text);
}

fvv_camera of_stream(const Target &target, const Frame &frame) {
  const fvv_camera *camera = frame.camera(*target.camera);
  if (!camera)
    refuse("--camera: camera " + std::to_string(*target.camera) + " is not in the stream, which has " +
           frame.camera_ids());
  if (camera->width > media::max_dimension || camera->height > media::max_dimension)
    refuse("--camera: camera " + std::to_string(camera->id) + " has sides above " +
           std::to_string(media::max_dimension));
  uint32_t width = camera->width, height = camera->height;
  take_size(target.size, width, height);
  const fvv_rect whole = {0, 0, uint16_t(camera->width), uint16_t(camera->height)};
  return demux::camera_of_tile(*camera, {camera->id, whole, {0, 0, uint16_t(width), uint16_t(height)}});
}

Vec3 up_of(uint8_t axis) {
  switch (axis) {
  case FVV_UP_X:
    return {1, 0, 0};
  case FVV_UP_Z:
    return {0, 0, 1};
  case FVV_UP_MINUS_X:
    return {-1, 0, 0};
  case FVV_UP_MINUS_Y:
    return {0, -1, 0};
  case FVV_UP_MINUS_Z:
    return {0, 0, -1};
  default:
    return {0, 1, 0};
  }
}

fvv_camera of_pose(const Target &target, const Frame &frame) {
  const std::vector<double> &p = target.pose;
  if (p.size() != 6 && p.size() != 9)
    refuse("--pose: expected 6 numbers, eye and target, or 9 with up, found " + std::to_string(p.size()));
  for (const double value : p)
    if (!(std::abs(value) <= 1e9)) refuse("--pose: expected numbers within 1e9");
  const Vec3 eye = {p[0], p[1], p[2]}, at = {p[3], p[4], p[5]};
  const Vec3 up = p.size() == 9 ? Vec3{p[6], p[7], p[8]} : up_of(frame.up);
  const Vec3 z = render::normalised(at - eye), side = render::cross(z, render::normalised(up));
  if (!(render::length(z) > 0)) refuse("--pose: eye and target are the same point");
  if (!(render::length(side) > 1e-6)) refuse("--pose: up points along the line of sight");
  const Vec3 x = render::normalised(side), y = render::cross(z, x);
  fvv_camera camera = {};
  camera.lens = FVV_LENS_NONE;
  camera.r_max = std::numeric_limits<double>::infinity();
  camera.width = default_width;
  camera.height = default_height;
  take_size(target.size, camera.width, camera.height);
  camera.fx = camera.fy = target.focal.value_or(camera.width);
  camera.cx = camera.width / 2.0;
  camera.cy = camera.height / 2.0;
  const Vec3 rows[3] = {x, y, z};
  for (int i = 0; i < 3; i++) {
    camera.rotation[3 * i] = rows[i].x;
    camera.rotation[3 * i + 1] = rows[i].y;
    camera.rotation[3 * i + 2] = rows[i].z;
    camera.translation[i] = -render::dot(rows[i], eye);
  }
  return camera;
}

} // namespace

fvv_camera target_camera(const Target &target, const Frame &frame) {
  if (target.camera && target.focal) refuse("--focal: expected with --pose only");
  if (target.camera.has_value() == !target.pose.empty())
    refuse("expected one of --camera and --pose, found " + std::string(target.camera ? "both" : "neither"));
  return target.camera ? of_stream(target, frame) : of_pose(target, frame);
}

} // namespace fvv::rendering
