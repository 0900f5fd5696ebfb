// Planes and cameras whose pictures can be computed directly: shared by the tests of view-dependent texture.
#pragma once

#include "fvv_render/view.h"

#include <cmath>
#include <deque>
#include <limits>

namespace view_fixture {

using namespace fvv::render;

// A camera at eye that looks at point; down is the world's y axis unless that is the way it looks.
inline fvv_camera looking(Vec3 eye, Vec3 point, uint32_t width, uint32_t height, double f) {
  const Vec3 z = normalised(point - eye);
  const Vec3 x = normalised(cross(std::abs(z.y) > 0.99 ? Vec3{0, 0, -1} : Vec3{0, 1, 0}, z)), y = cross(z, x);
  const Vec3 t = {-dot(x, eye), -dot(y, eye), -dot(z, eye)};
  fvv_camera camera = {};
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = f;
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
  camera.r_max = std::numeric_limits<double>::infinity();
  const double values[9] = {x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z};
  for (int i = 0; i < 9; i++) camera.rotation[i] = values[i];
  camera.translation[0] = t.x;
  camera.translation[1] = t.y;
  camera.translation[2] = t.z;
  return camera;
}

inline fvv_camera with_lens(fvv_camera camera, double k1, double k2) {
  camera.lens = FVV_LENS_RADTAN;
  camera.distortion[0] = k1;
  camera.distortion[1] = k2;
  camera.r_max = fvv_camera_r_max(&camera);
  return camera;
}

struct Shape {
  std::vector<float> positions;
  std::vector<uint32_t> faces;
  // The square |x|, |y| <= half in the plane z, its front towards -z.
  void square(double half, double z, double shift_x = 0) {
    const auto first = uint32_t(positions.size() / 3);
    for (const auto &[x, y] : {std::pair{-half, -half}, {half, -half}, {half, half}, {-half, half}})
      for (const double value : {x + shift_x, y, z}) positions.push_back(float(value));
    for (const uint32_t i : {0u, 2u, 1u, 0u, 3u, 2u}) faces.push_back(first + i);
  }
  Mesh mesh() const { return {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3}; }
};

// Where the ray through a pixel meets the plane z, by the library's lens and nothing of the renderer; NaN:
// nowhere in front.
inline Vec3 on_plane(const fvv_camera &camera, double u, double v, double z) {
  const double pixel[2] = {u, v}, *r = camera.rotation;
  double ray[3], centre[3];
  (void)fvv_camera_unproject(&camera, pixel, ray);
  fvv_camera_centre(&camera, centre);
  const Vec3 direction = {r[0] * ray[0] + r[3] * ray[1] + r[6] * ray[2],
                          r[1] * ray[0] + r[4] * ray[1] + r[7] * ray[2],
                          r[2] * ray[0] + r[5] * ray[1] + r[8] * ray[2]};
  const double distance = (z - centre[2]) / direction.z;
  if (!(distance > 0)) return {NAN, NAN, NAN};
  return Vec3{centre[0], centre[1], centre[2]} + direction * distance;
}

// A colour that changes linearly over the plane, which bilinear filters do not blur.
inline Vec3 gradient(Vec3 at) {
  return {0.5 + 0.2 * at.x, 0.5 + 0.2 * at.y, 0.5 - 0.1 * at.x - 0.1 * at.y};
}

// Sources with pixels of their own.
class Sources {
public:
  // The plane z = 0 with a colour for each point, as the camera takes it: the light at the pixel's centre.
  template <class Colour> void film(const fvv_camera &camera, const Colour &colour) {
    std::vector<uint16_t> &out = pixels.emplace_back();
    for (uint32_t y = 0; y < camera.height; y++)
      for (uint32_t x = 0; x < camera.width; x++) {
        const Vec3 c = colour(on_plane(camera, x + 0.5, y + 0.5, 0));
        for (const double value : {c.x, c.y, c.z})
          out.push_back(uint16_t(std::lround(std::fmin(std::fmax(value, 0), 1) * 65535)));
      }
    views.push_back({camera, out.data(), nullptr});
    views.back().camera.id = uint16_t(views.size());
  }
  void plain(const fvv_camera &camera, Vec3 colour) {
    film(camera, [&](Vec3) { return colour; });
  }
  std::vector<SourceView> views;

private:
  std::deque<std::vector<uint16_t>> pixels;
};

inline ViewPicture render(const Shape &shape, const Sources &sources, const fvv_camera &target,
                          const ViewOptions &options = {}, uint32_t excluded = no_source) {
  return ViewRenderer(shape.mesh(), {}, sources.views, options).render(target, excluded);
}

inline Vec3 colour_of(const ViewPicture &picture, size_t pixel) {
  const float *p = &picture.rgb[3 * pixel];
  return {p[0], p[1], p[2]};
}
inline double farthest(Vec3 a, Vec3 b) {
  return std::fmax(std::fmax(std::abs(a.x - b.x), std::abs(a.y - b.y)), std::abs(a.z - b.z));
}

} // namespace view_fixture
