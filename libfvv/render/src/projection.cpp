#include "fvv_render/projection.h"

#include <algorithm>

namespace fvv::render {

Projection::Projection(const fvv_camera &camera)
    : intrinsics(camera), rotation{{camera.rotation[0], camera.rotation[3], camera.rotation[6]},
                                   {camera.rotation[1], camera.rotation[4], camera.rotation[7]},
                                   {camera.rotation[2], camera.rotation[5], camera.rotation[8]}},
      translation{camera.translation[0], camera.translation[1], camera.translation[2]} {
  intrinsics.name = nullptr;
  intrinsics.name_size = 0;
  for (int i = 0; i < 9; i++) intrinsics.rotation[i] = i % 4 == 0;
  for (double &t : intrinsics.translation) t = 0;
  if (camera.lens == FVV_LENS_NONE) return;
  corner_rays.reserve((size_t(width()) + 1) * (size_t(height()) + 1));
  for (uint32_t y = 0; y <= height(); y++)
    for (uint32_t x = 0; x <= width(); x++) {
      const double pixel[2] = {double(x), double(y)};
      double r[3];
      (void)fvv_camera_unproject(&intrinsics, pixel, r); // NaN when there is none
      corner_rays.push_back({r[0], r[1], r[2]});
    }
}

Vec3 Projection::through_lens(Vec3 camera) const {
  const double point[3] = {camera.x, camera.y, camera.z};
  double pixel[2];
  (void)fvv_camera_project(&intrinsics, point, pixel, nullptr); // NaN when it is not seen
  return {pixel[0] * camera.z, pixel[1] * camera.z, camera.z};
}

Vec3 Projection::interpolated_ray(double u, double v) const {
  const double x = std::clamp(std::floor(u), 0.0, width() - 1.0),
               y = std::clamp(std::floor(v), 0.0, height() - 1.0);
  const size_t stride = size_t(width()) + 1;
  const Vec3 *corner = &corner_rays[size_t(y) * stride + size_t(x)];
  return mix(mix(corner[0], corner[1], u - x), mix(corner[stride], corner[stride + 1], u - x), v - y);
}

} // namespace fvv::render
