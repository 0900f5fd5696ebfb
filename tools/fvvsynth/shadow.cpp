#include "fvvsynth/shadow.h"

#include "fvvsynth/rig.h"

#include <algorithm>
#include <limits>

namespace fvv::synth {

namespace {

using render::Vec3;

constexpr uint32_t map_side = 448;
constexpr double cell = 0.0125;  // metres of a pixel of the map
constexpr double distance = 100; // to the lamp, so far that its rays are nearly parallel

fvv_camera at_lamp(Vec3 towards) {
  fvv_camera camera = {};
  camera.lens = FVV_LENS_NONE;
  camera.width = camera.height = map_side;
  camera.fx = camera.fy = distance / cell;
  camera.cx = camera.cy = map_side / 2.0;
  camera.r_max = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 9; i += 4) camera.rotation[i] = 1;
  const Vec3 eye = towards * distance;
  camera.translation[0] = -eye.x;
  camera.translation[1] = -eye.y;
  camera.translation[2] = -eye.z;
  return turned(camera, {0, 0.8, 0}, 1);
}

// The mean of 2 n + 1 neighbours along rows (stride 1) or columns (stride map_side).
void blur(std::vector<float> &map, int n, size_t stride) {
  const size_t across = stride == 1 ? map_side : 1;
  std::vector<float> line(map_side);
  for (size_t k = 0; k < map_side; k++) {
    float *first = &map[k * across];
    for (size_t i = 0; i < map_side; i++) line[i] = first[i * stride];
    const int end = int(map_side);
    float sum = 0; // of values that are multiples of a power of two at first, and no more than a few ulp off
    for (int i = -n; i < end; i++) {
      if (i + n < end) sum += line[size_t(i + n)];
      if (i - n - 1 >= 0) sum -= line[size_t(i - n - 1)];
      if (i >= 0) first[size_t(i) * stride] = std::max(0.0f, sum) / float(2 * n + 1);
    }
  }
}

} // namespace

Shadow::Shadow(const render::Mesh &mesh, const Lamp &lamp) : light(lamp), view(at_lamp(lamp.towards)) {
  render::SampleBuffer buffer(map_side, map_side, 1);
  render::rasterise(view, mesh, buffer);
  blocked.reserve(buffer.face.size());
  for (const uint32_t face : buffer.face) blocked.push_back(face == render::no_face ? 0 : 1);
  // Two boxes make a tent, twice as wide.
  const int n = std::max(1, int(lamp.softness / cell / 2));
  for (int pass = 0; pass < 2; pass++) {
    blur(blocked, n, 1);
    blur(blocked, n, map_side);
  }
  const double rim = 2 * n + 1;
  left = double(buffer.drawn.left) - rim;
  top = double(buffer.drawn.top) - rim;
  right = double(buffer.drawn.right) + rim;
  bottom = double(buffer.drawn.bottom) + rim;
}

double Shadow::covered(Vec3 on_floor) const {
  const Vec3 pixel = view.to_pixel(view.to_camera(on_floor));
  const double u = pixel.x / pixel.z - 0.5, v = pixel.y / pixel.z - 0.5;
  if (!(u >= 0 && v >= 0 && u < map_side - 1 && v < map_side - 1)) return 0;
  const size_t x = size_t(u), y = size_t(v);
  const float *p = &blocked[y * map_side + x];
  const double fu = u - double(x), fv = v - double(y);
  const double upper = double(p[0]) + double(p[1] - p[0]) * fu;
  const double lower = double(p[map_side]) + double(p[map_side + 1] - p[map_side]) * fu;
  return upper + (lower - upper) * fv;
}

void Shadow::cast(const render::Projection &camera, render::LightField &picture) const {
  // The rectangle of the picture that shows the floor under the map's; if part of it is not seen, all.
  const Vec3 lamp = view.centre(), eye = camera.centre();
  double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
  bool seen = true;
  constexpr int parts = 8; // lenses bend its sides
  for (int j = 0; j <= parts; j++)
    for (int i = 0; i <= parts; i++) {
      const Vec3 ray = view.to_world_direction(
          view.ray(left + (right - left) * i / parts, top + (bottom - top) * j / parts));
      const Vec3 pixel = camera.to_pixel(camera.to_camera(lamp + ray * (-lamp.y / ray.y)));
      const double at[2] = {pixel.x / pixel.z, pixel.y / pixel.z};
      seen = seen && pixel.z > 0 && std::isfinite(at[0]) && std::isfinite(at[1]);
      for (int axis = 0; axis < 2 && seen; axis++) {
        low[axis] = std::min(low[axis], at[axis] - 4);
        high[axis] = std::max(high[axis], at[axis] + 4);
      }
    }
  const double width = camera.width(), height = camera.height();
  const auto bound = [&](double value, double side) { return uint32_t(std::clamp(value, 0.0, side)); };
  const uint32_t x0 = seen ? bound(low[0], width) : 0, x1 = seen ? bound(high[0], width) : camera.width();
  const uint32_t y0 = seen ? bound(low[1], height) : 0, y1 = seen ? bound(high[1], height) : camera.height();
  for (uint32_t y = y0; y < y1; y++)
    for (uint32_t x = x0; x < x1; x++) {
      const Vec3 way = camera.to_world_direction(camera.ray(x + 0.5, y + 0.5));
      if (!(way.y < 0)) continue;
      const float kept = float(1 - light.share * covered(eye + way * (-eye.y / way.y)));
      float *colour = &picture[3 * (size_t(y) * camera.width() + x)];
      for (int i = 0; i < 3; i++) colour[i] *= kept;
    }
}

} // namespace fvv::synth
