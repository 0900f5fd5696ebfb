// A camera for the rasteriser: points to pixels, and pixels to rays, fast enough for every sample.
#pragma once

#include "fvv/calibration.h"
#include "fvv_render/vector.h"

#include <vector>

namespace fvv::render {

// Without a lens both ways are linear and exact. With one, pixels come from fvv_camera_project, and rays are
// interpolated, bilinearly between the corners of pixels and those from corners that lie further apart where
// that was found to suffice; they err by less than a thousandth of a pixel in pictures 500 wide or more.
class Projection {
public:
  // none: ray() must not be called. With a lens, tracing them takes longer than drawing a mesh.
  enum class Rays { traced, none };
  // Copies what it needs. For a valid camera (fvv_camera_validate).
  explicit Projection(const fvv_camera &camera, Rays rays = Rays::traced);
  uint32_t width() const { return intrinsics.width; }
  uint32_t height() const { return intrinsics.height; }
  // World -> camera frame, metres: x right, y down, z forward.
  Vec3 to_camera(Vec3 world) const { return rotation * world + translation; }
  Vec3 to_world_direction(Vec3 camera) const { return transposed(rotation) * camera; }
  Vec3 centre() const { return -(transposed(rotation) * translation); }
  // Homogeneous pixel: u = x / z, v = y / z, the centre of the top left pixel at (0.5, 0.5). NaN for points
  // that the lens does not show (behind it, beyond r_max).
  Vec3 to_pixel(Vec3 camera) const {
    if (intrinsics.lens != FVV_LENS_NONE) return through_lens(camera);
    const fvv_camera &c = intrinsics;
    return {c.fx * camera.x + c.skew * camera.y + c.cx * camera.z, c.fy * camera.y + c.cy * camera.z,
            camera.z};
  }
  // Ray through a pixel position in the camera frame, z = 1. With a lens: of the picture, not beyond; NaN
  // where the lens has no ray.
  Vec3 ray(double u, double v) const {
    if (!corner_rays.empty()) return interpolated_ray(u, v);
    const double y = (v - intrinsics.cy) / intrinsics.fy;
    return {(u - intrinsics.cx - intrinsics.skew * y) / intrinsics.fx, y, 1};
  }

private:
  Vec3 through_lens(Vec3 camera) const;
  Vec3 interpolated_ray(double u, double v) const;
  Vec3 exact_ray(uint32_t x, uint32_t y) const; // of the corner of a pixel; NaN when there is none
  void trace_corners();

  fvv_camera intrinsics; // at the origin, without a name
  Mat3 rotation;
  Vec3 translation;
  std::vector<Vec3> corner_rays; // (width + 1) x (height + 1) with a lens and rays, else none
};

// The unit vector of FVV_UP_...; +Y for other numbers.
Vec3 up_vector(uint8_t axis);

} // namespace fvv::render
