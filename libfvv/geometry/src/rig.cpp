#include "fvv_geometry/rig.h"

#include <algorithm>

namespace fvv::geometry {

namespace {

using render::Vec3;

Vec3 centre_of(const fvv_camera &camera) {
  double c[3];
  fvv_camera_centre(&camera, c);
  return {c[0], c[1], c[2]};
}

} // namespace

RigSpace rig_space(const std::vector<fvv_camera> &cameras) {
  // Sum over the axes c + s d of (I - d d^T)(p - c) = 0, relative to the mean of the c.
  Vec3 mean;
  for (const fvv_camera &camera : cameras) mean += centre_of(camera) * (1.0 / double(cameras.size()));
  render::Mat3 m{{}, {}, {}};
  Vec3 right;
  for (const fvv_camera &camera : cameras) {
    const double *r = camera.rotation;
    const Vec3 d = normalised(Vec3{r[6], r[7], r[8]}), c = centre_of(camera) - mean;
    m.x += Vec3{1, 0, 0} - d * d.x;
    m.y += Vec3{0, 1, 0} - d * d.y;
    m.z += Vec3{0, 0, 1} - d * d.z;
    right += c - d * dot(d, c);
  }
  const double n = double(cameras.size()), determinant = dot(m.x, cross(m.y, m.z));
  RigSpace space{mean, 0};
  if (determinant > 1e-6 * n * n * n)
    space.centre +=
        Vec3{dot(right, cross(m.y, m.z)), dot(m.x, cross(right, m.z)), dot(m.x, cross(m.y, right))} *
        (1 / determinant);
  for (const fvv_camera &camera : cameras)
    space.radius = std::max(space.radius, length(centre_of(camera) - space.centre));
  if (!(space.radius > 0)) space.radius = 1;
  return space;
}

} // namespace fvv::geometry
