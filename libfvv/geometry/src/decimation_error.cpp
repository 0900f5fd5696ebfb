// What a pixel covers, and how far a decimated surface is from its source.
#include "fvv_geometry/decimate.h"
#include "fvv_geometry/pieces.h"
#include "fvv_render/vector.h"

#include <algorithm>
#include <array>
#include <map>

namespace fvv::decimate {

namespace {

using render::Vec3;

// Large compared with the rounding of doubles, small compared with the curvature of a projection.
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

Footprint Footprint::uniform(double metres_per_pixel) {
  Footprint footprint;
  footprint.size = metres_per_pixel;
  return footprint;
}

Sight Footprint::look(const double point[3]) const {
  if (std::isfinite(size)) return {size, 0, 0};
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

namespace {

using render::Vec3;

constexpr size_t samples = 6000, many_samples = 20000; // of the decimated surface
constexpr double cells_across = 32;                    // of the diagonal

std::vector<render::TriangleTree::Triangle> triangles_of(const geometry::Mesh &mesh) {
  std::vector<render::TriangleTree::Triangle> out(mesh.face_count());
  for (size_t i = 0; i < mesh.faces.size(); i++) {
    const double *p = &mesh.positions[3 * size_t(mesh.faces[i])];
    out[i / 3][i % 3] = {p[0], p[1], p[2]};
  }
  return out;
}

double diagonal_of(const geometry::Mesh &mesh) {
  Vec3 low = {INFINITY, INFINITY, INFINITY}, high = -low;
  for (const Vec3 &p : compare::positions_of(mesh)) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return length(high - low);
}

// Mean squares of one direction.
struct Sum {
  double weight = 0, squares = 0, pixel_squares = 0, max = 0, max_pixels = 0;

  void scale(double by) {
    for (double *sum : {&weight, &squares, &pixel_squares}) *sum *= by;
  }

  // Returns the distance in pixels.
  double add(double squared, double weight_here, double pixel) {
    const double distance = std::sqrt(squared), in_pixels = distance / pixel;
    weight += weight_here;
    squares += weight_here * squared;
    pixel_squares += weight_here * in_pixels * in_pixels;
    max = std::max(max, distance);
    max_pixels = std::max(max_pixels, in_pixels);
    return in_pixels;
  }
};

} // namespace

Reference::Reference(const geometry::Mesh &mesh, const Footprint &footprint, const Reference *like)
    : source(mesh), areas(mesh.vertex_count()), pixels(mesh.vertex_count(), INFINITY),
      finder(triangles_of(mesh), like ? &like->finder : nullptr) {
  for (size_t f = 0; f < mesh.face_count(); f++)
    for (size_t k = 0; k < 3; k++) areas[mesh.faces[3 * f + k]] += face_area(mesh, f) / 3;
  std::vector<bool> known(mesh.vertex_count());
  for (const uint32_t f : finder.along_surface())
    for (size_t k = 0; k < 3; k++) {
      const uint32_t v = mesh.faces[3 * size_t(f) + k];
      if (!known[v] && areas[v] > 0) order.push_back(v);
      known[v] = true;
    }
  const double side = diagonal_of(mesh) / cells_across;
  std::map<std::array<int64_t, 3>, double> cells;
  for (size_t v = 0; v < mesh.vertex_count() && !footprint.empty(); v++) {
    const double *p = &mesh.positions[3 * v];
    std::array<int64_t, 3> cell;
    for (size_t k = 0; k < 3; k++) cell[k] = int64_t(std::floor((p[k] - mesh.positions[k]) / side));
    const auto [place, fresh] = cells.try_emplace(cell);
    if (fresh) place->second = footprint.look(p).metres_per_pixel;
    pixels[v] = place->second;
    smallest = std::min(smallest, pixels[v]);
  }
}

SurfaceError Reference::measure(const compare::Faces &decimated, double limit_pixels, Outliers &outliers,
                                Looks looks) const {
  Sum forth, back;
  render::ClosestPoint hit; // the search begins with that of the point before
  for (const uint32_t v : order) {
    const double *p = &source.positions[3 * size_t(v)];
    hit = decimated.nearest({p[0], p[1], p[2]}, hit.face);
    const double off = forth.add(hit.squared, areas[v], pixels[v]);
    if (!(off > limit_pixels)) continue;
    outliers.vertices.push_back(v);
    outliers.area += areas[v];
  }
  if (looks == Looks::within_faces && outliers.vertices.empty()) {
    // A quarter for the corners and three for the centre: exact where the square is a quadratic.
    forth.scale(1.0 / 4);
    hit = {};
    for (const uint32_t f : finder.along_surface()) {
      const uint32_t *corners = &source.faces[3 * size_t(f)];
      Vec3 centre;
      for (size_t k = 0; k < 3; k++) {
        const double *p = &source.positions[3 * size_t(corners[k])];
        centre += Vec3{p[0], p[1], p[2]} * (1.0 / 3);
      }
      hit = decimated.nearest(centre, hit.face);
      const double area = face_area(source, f);
      if (!(forth.add(hit.squared, 0.75 * area, pixels[corners[0]]) > limit_pixels)) continue;
      outliers.vertices.insert(outliers.vertices.end(), corners, corners + 3);
      outliers.area += area;
    }
  }
  hit = {};
  for (const compare::Sample &sample :
       decimated.sample(looks == Looks::within_faces ? many_samples : samples)) {
    hit = finder.nearest(sample.point, hit.face);
    const uint32_t *corners = &source.faces[3 * size_t(hit.face)];
    if (!(back.add(hit.squared, 1, pixels[corners[0]]) > limit_pixels)) continue;
    outliers.vertices.insert(outliers.vertices.end(), corners, corners + 3);
    outliers.faces.push_back(sample.face);
  }
  const auto worse = [&](double Sum::*squares) {
    return std::sqrt(std::max(forth.*squares / forth.weight, back.*squares / back.weight));
  };
  return {worse(&Sum::squares), std::max(forth.max, back.max), worse(&Sum::pixel_squares),
          std::max(forth.max_pixels, back.max_pixels)};
}

} // namespace fvv::decimate
