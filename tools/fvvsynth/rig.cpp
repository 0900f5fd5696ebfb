#include "fvvsynth/rig.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fvv::synth {

namespace {

constexpr double turn = 6.283185307179586;

// Puts camera at centre, looking to target. above: what is up in the picture, not along the view.
void aim(fvv_camera &camera, Vec3 centre, Vec3 target, Vec3 above) {
  // Camera axes in the world: x right, y down, z forward.
  const Vec3 forward = normalised(target - centre), right = normalised(cross(forward, above));
  const Vec3 axes[3] = {right, cross(forward, right), forward};
  for (int row = 0; row < 3; row++) {
    camera.rotation[3 * row] = axes[row].x;
    camera.rotation[3 * row + 1] = axes[row].y;
    camera.rotation[3 * row + 2] = axes[row].z;
    camera.translation[row] = -dot(axes[row], centre);
  }
}

fvv_camera make_camera(size_t id, uint32_t width, uint32_t height) {
  fvv_camera camera = {};
  camera.id = uint16_t(id);
  camera.lens = FVV_LENS_NONE;
  camera.width = width;
  camera.height = height;
  camera.r_max = std::numeric_limits<double>::infinity();
  return camera;
}

// Focal lengths about focal, principal point about the middle.
void vary(fvv_camera &camera, double focal, Random &random) {
  camera.fx = focal;
  camera.fy = focal * random.between(0.999, 1.001);
  camera.cx = camera.width * (0.5 + random.between(-0.01, 0.01));
  camera.cy = camera.height * (0.5 + random.between(-0.01, 0.01));
}

// The differences between the cameras of the studio.
struct Make {
  double zoom;     // focal length against that of the small rig
  uint32_t thirds; // size in thirds of the given one
  double k1, k2;   // both 0: no distortion
};
constexpr Make oval[] = {{1.00, 3, 0, 0},       {0.80, 3, -0.20, 0.045}, {0.95, 3, -0.12, 0.020},
                         {0.90, 2, 0, 0},       {1.20, 3, 0.08, -0.02},  {0.95, 3, -0.16, 0.03},
                         {1.05, 4, 0, 0},       {1.25, 3, 0.10, -0.03},  {0.85, 3, 0, 0},
                         {1.00, 2, -0.06, 0.01}};
constexpr size_t moving = 2; // sees the passes from the side
constexpr Make head[] = {{0.80, 3, -0.18, 0.04}, {0.90, 4, 0, 0}};
constexpr Make above = {0.95, 2, 0, 0};

fvv_camera make_studio_camera(const Make &make, size_t id, uint32_t width, uint32_t height, Vec3 centre,
                              Framing framing, Random &random) {
  const auto side = [&](uint32_t n) { return std::max(16u, n * make.thirds / 3 / 2 * 2); };
  fvv_camera camera = make_camera(id, side(width), side(height));
  const Vec3 target{random.between(-0.1, 0.1), random.between(0.90, 1.00) + framing.above,
                    random.between(-0.1, 0.1)};
  vary(camera, camera.width * 0.79 * make.zoom * random.between(0.98, 1.02) * framing.zoom, random);
  const double p1 = random.between(-0.001, 0.001), p2 = random.between(-0.001, 0.001);
  if (make.k1 != 0) {
    const double distortion[4] = {make.k1, make.k2, p1, p2};
    camera.lens = FVV_LENS_RADTAN;
    std::copy_n(distortion, 4, camera.distortion);
    camera.r_max = fvv_camera_r_max(&camera);
  }
  // Straight from above y has no direction in the picture: far is up.
  aim(camera, centre, target, std::abs(centre.x) + std::abs(centre.z) < 1 ? Vec3{0, 0, -1} : Vec3{0, 1, 0});
  return camera;
}

} // namespace

fvv_camera turned(const fvv_camera &camera, Vec3 target, double zoom) {
  double centre[3];
  fvv_camera_centre(&camera, centre);
  fvv_camera result = camera;
  aim(result, {centre[0], centre[1], centre[2]}, target, {0, 1, 0});
  result.fx *= zoom;
  result.fy *= zoom;
  return result;
}

Rig make_small_rig(Random &random, uint32_t count, uint32_t width, uint32_t height) {
  constexpr double distance = 5.3, footprint = 0.014;
  Rig rig;
  for (uint32_t i = 0; i < count; i++) {
    const double angle = turn * (i + random.between(-0.12, 0.12) + 0.35) / count;
    const Vec3 centre{distance * 1.06 * std::cos(angle), random.between(1.5, 3.0),
                      distance * 0.94 * std::sin(angle)};
    const Vec3 target{random.between(-0.1, 0.1), random.between(0.90, 1.00), random.between(-0.1, 0.1)};
    fvv_camera camera = make_camera(i, width, height);
    vary(camera, distance / footprint * width / 480 * random.between(0.97, 1.03), random);
    aim(camera, centre, target, {0, 1, 0});
    rig.cameras.push_back(camera);
    rig.names.push_back("cam" + std::to_string(i));
  }
  return rig;
}

Rig make_arc_rig(uint32_t count, uint32_t width, uint32_t height) {
  constexpr double distance = 4.5, first = turn / 6;
  Rig rig;
  for (uint32_t i = 0; i < count; i++) {
    const double angle = first + turn * i / 360;
    fvv_camera camera = make_camera(i, width, height);
    camera.fx = camera.fy = width;
    camera.cx = width / 2.0;
    camera.cy = height / 2.0;
    aim(camera, {distance * std::cos(angle), 1.7, distance * std::sin(angle)}, {0, 0.95, 0}, {0, 1, 0});
    rig.cameras.push_back(camera);
    rig.names.push_back("view" + std::to_string(i));
  }
  return rig;
}

Rig make_studio_rig(Random &random, uint32_t width, uint32_t height, Framing framing) {
  Rig rig;
  const auto add = [&](const Make &make, Vec3 centre, const std::string &name, double higher = 0) {
    const Framing own{framing.above + higher, framing.zoom};
    rig.cameras.push_back(make_studio_camera(make, rig.cameras.size(), width, height, centre, own, random));
    rig.names.push_back(name);
  };
  const auto around = [&](double angle, double height_above) {
    const double far = random.between(0.97, 1.03);
    return Vec3{6.0 * far * std::cos(angle), height_above, 5.0 * far * std::sin(angle)};
  };
  for (size_t i = 0; i < std::size(oval); i++)
    add(oval[i], around(turn * (double(i) + random.between(-0.12, 0.12) + 0.35) / 10, 2.5),
        "oval" + std::to_string(i));
  for (size_t i = 0; i < std::size(head); i++)
    add(head[i], around(turn * (0.27 + 0.5 * double(i)), 1.7), "head" + std::to_string(i),
        framing.head_above);
  add(above, {0.1, framing.overhead_height, 0.05}, overhead);
  rig.moving = moving;
  return rig;
}

} // namespace fvv::synth
