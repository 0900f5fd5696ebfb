// The rasteriser: projection, clipping, integer coverage, depth from the unclipped triangle.
#include "fvv_render/rasteriser.h"

#include "fvv_render/scene_lengths.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>

namespace fvv::render {

namespace {

constexpr int subpixel_bits = 8;
constexpr int64_t subpixel = int64_t(1) << subpixel_bits;
// Triangles are clipped to this far beyond the origin of the picture, in pixels: with 7 samples and 8 bits
// coordinates stay below 2^28 and edge functions below 2^60.
constexpr double guard = 131072;

struct Point { // in 1/256 of a sample spacing
  int64_t x, y;
};

// A clip plane in homogeneous pixels: inside where the value is >= 0.
struct Plane {
  Vec3 normal;
  double offset;
  double value(Vec3 p) const { return dot(normal, p) + offset; }
};

// The nearest one, then those at the sides.
using Planes = std::array<Plane, 5>;
Planes planes_from(double nearest) {
  return {{{{0, 0, 1}, -nearest},
           {{1, 0, guard}, 0},
           {{-1, 0, guard}, 0},
           {{0, 1, guard}, 0},
           {{0, -1, guard}, 0}}};
}
constexpr size_t max_corners = 3 + std::tuple_size<Planes>::value;

struct Polygon {
  std::array<Vec3, max_corners> corner;
  size_t size = 0;
};

// Sutherland and Hodgman, 1974. The new corner is computed from the inner to the outer end, so that the two
// triangles at an edge, which run along it in opposite directions, get the same bits.
Polygon clipped(const Polygon &in, const Plane &plane) {
  Polygon out;
  for (size_t i = 0; i < in.size; i++) {
    const Vec3 a = in.corner[i], b = in.corner[(i + 1) % in.size];
    const double va = plane.value(a), vb = plane.value(b);
    if (va >= 0) out.corner[out.size++] = a;
    if ((va >= 0) != (vb >= 0))
      out.corner[out.size++] = va >= 0 ? mix(a, b, va / (va - vb)) : mix(b, a, vb / (vb - va));
  }
  return out;
}

// Clips one triangle of homogeneous pixels; an empty polygon when nothing is left.
Polygon clip(const std::array<Vec3, 3> &triangle, const Planes &planes) {
  Polygon polygon;
  polygon.size = 3;
  std::copy(triangle.begin(), triangle.end(), polygon.corner.begin());
  for (const Plane &plane : planes) {
    const auto inside = [&](const Vec3 &p) { return plane.value(p) >= 0; };
    if (std::all_of(triangle.begin(), triangle.end(), inside)) continue;
    polygon = clipped(polygon, plane);
    if (polygon.size < 3) return {};
  }
  return polygon;
}

bool finite(Vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

Vec3 position(const Mesh &mesh, uint32_t vertex) {
  const float *p = mesh.positions + size_t(3) * vertex;
  return {p[0], p[1], p[2]};
}

// Edge a -> b of a triangle with positive area (y down). E(p) > 0 inside; on the edge E(p) = 0 counts as
// inside for top edges and left edges alone, which the bias expresses.
struct Edge {
  int64_t dx, dy, bias;
  Point from;
  Edge(Point a, Point b)
      : dx(b.x - a.x), dy(b.y - a.y), bias(dy < 0 || (dy == 0 && dx > 0) ? 0 : -1), from(a) {}
  int64_t at(int64_t x, int64_t y) const { return dx * (y - from.y) - dy * (x - from.x) + bias; }
};

// First sample whose centre is at or beyond a coordinate.
int64_t first_sample(int64_t coordinate) {
  return (coordinate + subpixel / 2 - 1) >> subpixel_bits;
}
// Last sample whose centre is at or before it.
int64_t last_sample(int64_t coordinate) {
  return (coordinate - subpixel / 2) >> subpixel_bits;
}

// A vertex as a camera sees it.
struct Corner {
  Vec3 point; // in the camera frame
  Vec3 pixel; // homogeneous
  bool finite;
  bool inside;   // so far within all planes that a triangle of such vertices need not be clipped
  Point rounded; // of one that is inside
};

class Drawing {
public:
  Drawing(const Projection &projection, double nearest, SampleBuffer &target, bool has_depth)
      : camera(projection), buffer(target), unclipped(2 * nearest), planes(planes_from(nearest)),
        depth(has_depth) {}

  Corner corner(Vec3 world) const {
    Corner out = {};
    out.point = camera.to_camera(world);
    out.pixel = camera.to_pixel(out.point);
    out.finite = finite(out.pixel);
    const double most = guard / 2 * out.pixel.z;
    out.inside = out.pixel.z > unclipped && std::abs(out.pixel.x) < most && std::abs(out.pixel.y) < most;
    if (out.inside) out.rounded = rounded(out.pixel);
    return out;
  }

  void triangle(const Corner &a, const Corner &b, const Corner &c, uint32_t face) const {
    if (!a.finite || !b.finite || !c.finite) return;
    const std::array<Vec3, 3> points = {a.point, b.point, c.point};
    if (a.inside && b.inside && c.inside) return fill(a.rounded, b.rounded, c.rounded, points, face);
    const Polygon polygon = clip({a.pixel, b.pixel, c.pixel}, planes);
    if (polygon.size < 3) return;
    std::array<Point, max_corners> corner;
    for (size_t i = 0; i < polygon.size; i++) corner[i] = rounded(polygon.corner[i]);
    for (size_t i = 2; i < polygon.size; i++) fill(corner[0], corner[i - 1], corner[i], points, face);
  }

private:
  Point rounded(Vec3 pixel) const {
    const double scale = double(buffer.samples) * double(subpixel);
    return {int64_t(std::floor(pixel.x / pixel.z * scale + 0.5)),
            int64_t(std::floor(pixel.y / pixel.z * scale + 0.5))};
  }

  void fill(Point a, Point b, Point c, const std::array<Vec3, 3> &points, uint32_t face) const {
    const int64_t area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0) return;
    if (area < 0) std::swap(b, c);
    const int64_t left = std::max<int64_t>(0, first_sample(std::min({a.x, b.x, c.x})));
    const int64_t right = std::min(int64_t(buffer.columns) - 1, last_sample(std::max({a.x, b.x, c.x})));
    const int64_t top = std::max<int64_t>(0, first_sample(std::min({a.y, b.y, c.y})));
    const int64_t bottom =
        std::min(int64_t(buffer.height) * buffer.samples - 1, last_sample(std::max({a.y, b.y, c.y})));
    if (left > right || top > bottom) return;
    SampleBuffer::Extent &drawn = buffer.drawn;
    drawn.left = std::min(drawn.left, size_t(left));
    drawn.right = std::max(drawn.right, size_t(right) + 1);
    drawn.top = std::min(drawn.top, size_t(top));
    drawn.bottom = std::max(drawn.bottom, size_t(bottom) + 1);
    const Edge edges[3] = {{a, b}, {b, c}, {c, a}};
    const FaceInterpolator interpolator(points[0], points[1], points[2]);
    // No point of the triangle is nearer than its nearest corner, but for rounding.
    const float nearest = float(std::min({points[0].z, points[1].z, points[2].z})) * (1 - 1e-6f);
    for (int64_t row = top; row <= bottom; row++) {
      const int64_t y = row * subpixel + subpixel / 2, x = left * subpixel + subpixel / 2;
      int64_t e[3] = {edges[0].at(x, y), edges[1].at(x, y), edges[2].at(x, y)};
      const size_t start = size_t(row) * buffer.columns;
      for (int64_t column = left; column <= right; column++) {
        if ((e[0] | e[1] | e[2]) >= 0) {
          const size_t at = start + size_t(column);
          if (!depth)
            buffer.face[at] = face;
          else if (!(buffer.depth[at] < nearest))
            sample(at, column, row, interpolator, points, face);
        }
        for (int i = 0; i < 3; i++) e[i] -= edges[i].dy * subpixel;
      }
    }
  }

  void sample(size_t at, int64_t column, int64_t row, const FaceInterpolator &interpolator,
              const std::array<Vec3, 3> &points, uint32_t face) const {
    const double spacing = buffer.samples;
    const auto weight =
        interpolator.at(camera.ray((double(column) + 0.5) / spacing, (double(row) + 0.5) / spacing));
    const float z = float(weight[0] * points[0].z + weight[1] * points[1].z + weight[2] * points[2].z);
    if (!(z < buffer.depth[at])) return;
    buffer.depth[at] = z;
    buffer.face[at] = face;
  }

  const Projection &camera;
  SampleBuffer &buffer;
  const double unclipped; // z_c from which on nothing is nearer than the nearest plane
  const Planes planes;
  const bool depth;
};

bool odd_and_small(uint32_t samples) {
  return samples % 2 == 1 && samples <= 7;
}

} // namespace

SampleBuffer::SampleBuffer(uint32_t w, uint32_t h, uint32_t s) : width(0), height(0), samples(s), columns(0) {
  resize(w, h);
}

void SampleBuffer::resize(uint32_t w, uint32_t h) {
  if (w < 1 || h < 1 || w > 16384 || h > 16384 || !odd_and_small(samples))
    throw std::invalid_argument("a sample buffer has sides of 1 to 16384 and 1, 3, 5 or 7 samples, not " +
                                std::to_string(w) + "x" + std::to_string(h) + " and " +
                                std::to_string(samples));
  clear();
  width = w;
  height = h;
  columns = size_t(w) * samples;
  // Everything before the new end is clear already.
  face.resize(columns * h * samples, no_face);
  depth.resize(columns * h * samples, std::numeric_limits<float>::infinity());
}

void SampleBuffer::clear() {
  for (size_t row = drawn.top; row < drawn.bottom; row++) {
    const auto first = std::ptrdiff_t(row * columns + drawn.left),
               end = std::ptrdiff_t(row * columns + drawn.right);
    std::fill(face.begin() + first, face.begin() + end, no_face);
    std::fill(depth.begin() + first, depth.begin() + end, std::numeric_limits<float>::infinity());
  }
  drawn = {};
}

namespace {

void draw(const Projection &camera, const Mesh &mesh, SampleBuffer &buffer, bool depth) {
  if (camera.width() != buffer.width || camera.height() != buffer.height)
    throw std::invalid_argument("a camera of " + std::to_string(camera.width()) + "x" +
                                std::to_string(camera.height()) + " cannot draw into samples of " +
                                std::to_string(buffer.width) + "x" + std::to_string(buffer.height));
  const Drawing drawing(camera, near_plane(mesh), buffer, depth);
  std::vector<Corner> corners;
  corners.reserve(mesh.vertex_count);
  for (size_t i = 0; i < mesh.vertex_count; i++)
    corners.push_back(drawing.corner(position(mesh, uint32_t(i))));
  for (size_t i = 0; i < mesh.face_count; i++) {
    const uint32_t *face = mesh.faces + 3 * i;
    drawing.triangle(corners[face[0]], corners[face[1]], corners[face[2]], uint32_t(i));
  }
}

} // namespace

void rasterise(const Projection &camera, const Mesh &mesh, SampleBuffer &buffer) {
  draw(camera, mesh, buffer, true);
}

void rasterise_coverage(const Projection &camera, const Mesh &mesh, SampleBuffer &buffer) {
  draw(camera, mesh, buffer, false);
}

FaceInterpolator::FaceInterpolator(const Projection &camera, const Mesh &mesh, uint32_t face)
    : FaceInterpolator(camera.to_camera(position(mesh, mesh.faces[size_t(3) * face])),
                       camera.to_camera(position(mesh, mesh.faces[size_t(3) * face + 1])),
                       camera.to_camera(position(mesh, mesh.faces[size_t(3) * face + 2]))) {}

std::array<double, 3> barycentric(const Projection &camera, const Mesh &mesh, uint32_t face, double u,
                                  double v) {
  return FaceInterpolator(camera, mesh, face).at(camera.ray(u, v));
}

} // namespace fvv::render
