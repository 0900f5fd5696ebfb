#include "decimate/footprint.h"

#include "fvv_render/vector.h"

namespace fvv::decimate {

namespace {

using render::Vec3;

// Large against the rounding of doubles, small against what bends a projection.
constexpr double difference = 1e-5; // of the distance

// Singular values of (a b; c d), the larger one; Golub and Van Loan, "Matrix Computations", section 8.6.
double largest_singular_value(double a, double b, double c, double d) {
  return (std::hypot(a + d, b - c) + std::hypot(a - d, b + c)) / 2;
}

} // namespace

void Footprint::add(const fvv_camera &camera, double scale_x, double scale_y) {
  View view = {camera, {}, scale_x, scale_y};
  view.camera.name = {};
  fvv_camera_centre(&camera, view.centre);
  views.push_back(view);
}

Sight Footprint::look(const double point[3]) const {
  Sight inside, outside;
  const Vec3 at = {point[0], point[1], point[2]};
  for (const View &view : views) {
    double pixel[2], right[2], down[2];
    if (!fvv_camera_project(&view.camera, point, pixel, nullptr)) continue;
    const Vec3 ray = at - Vec3{view.centre[0], view.centre[1], view.centre[2]};
    const double distance = length(ray), h = difference * distance;
    // Two directions across the ray; the axis that is furthest from it gives the first.
    const double x = std::abs(ray.x), y = std::abs(ray.y), z = std::abs(ray.z);
    const Vec3 axis = x <= y && x <= z ? Vec3{1, 0, 0} : y <= z ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    const Vec3 a = normalised(cross(ray, axis)), b = normalised(cross(ray, a));
    const Vec3 aside = at + a * h, below = at + b * h;
    const double first[3] = {aside.x, aside.y, aside.z}, second[3] = {below.x, below.y, below.z};
    if (!fvv_camera_project(&view.camera, first, right, nullptr) ||
        !fvv_camera_project(&view.camera, second, down, nullptr))
      continue;
    const double pixels_per_metre =
        largest_singular_value((right[0] - pixel[0]) * view.scale_x, (down[0] - pixel[0]) * view.scale_x,
                               (right[1] - pixel[1]) * view.scale_y, (down[1] - pixel[1]) * view.scale_y) /
        h;
    const Sight sight = {1 / pixels_per_metre, distance, view.camera.id};
    if (!std::isfinite(sight.metres_per_pixel) || !(sight.metres_per_pixel > 0)) continue;
    const bool in_picture =
        pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] <= view.camera.width && pixel[1] <= view.camera.height;
    if (sight.metres_per_pixel < outside.metres_per_pixel) outside = sight;
    if (in_picture && sight.metres_per_pixel < inside.metres_per_pixel) inside = sight;
  }
  return std::isfinite(inside.metres_per_pixel) ? inside : outside;
}

} // namespace fvv::decimate
