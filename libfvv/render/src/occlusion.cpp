#include "fvv_render/occlusion.h"

#include "fvv_render/scene_lengths.h"

#include <algorithm>
#include <limits>

namespace fvv::render {

namespace {

constexpr double widest = 4;             // x / z, y / z; an angle of 76 degrees
constexpr double most_samples = 1 << 28; // 2 GiB while the map is drawn
constexpr uint32_t border_steps = 64;
constexpr double infinity = std::numeric_limits<double>::infinity();

// The rectangle of x / z and y / z that the border of the picture encloses, as the lens shows it.
struct Field {
  double left = infinity, right = -infinity, top = infinity, bottom = -infinity;
  void add(double x, double y) {
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
  }
  // Beyond the radius of validity there is nothing to cover, so its circle counts where there is no ray.
  static Field of(const fvv_camera &camera) {
    Field field;
    const double rim = camera.lens == FVV_LENS_FISHEYE ? std::tan(std::min(camera.r_max, 1.5)) : camera.r_max;
    for (uint32_t i = 0; i <= border_steps; i++) {
      const double x = double(camera.width) * i / border_steps, y = double(camera.height) * i / border_steps;
      for (const auto &[u, v] :
           {std::pair{x, 0.0}, {x, double(camera.height)}, {0.0, y}, {double(camera.width), y}}) {
        const double pixel[2] = {u, v};
        double ray[3];
        if (fvv_camera_unproject(&camera, pixel, ray)) {
          field.add(ray[0], ray[1]);
        } else {
          field.add(-rim, -rim);
          field.add(rim, rim);
        }
      }
    }
    return field;
  }
};

} // namespace

DepthMap::DepthMap(const fvv_camera &camera, const Mesh &mesh, const DepthTest &chosen)
    : test(chosen), nearest(near_plane(mesh)), breadth_x(1 / camera.fx), breadth_y(1 / camera.fy) {
  // Pixels of one breadth, also beyond the border: a lens bends least in its centre.
  const Field field = Field::of(camera);
  const double widths[4] = {-field.left, field.right, -field.top, field.bottom};
  if (!(*std::max_element(widths, widths + 4) <= widest)) return;
  const double across = std::ceil((field.right - field.left) * camera.fx) + 2,
               down = std::ceil((field.bottom - field.top) * camera.fy) + 2;
  if (!(across <= 16384 && down <= 16384 && across * down * test.samples * test.samples <= most_samples))
    return;
  fvv_camera pinhole = camera;
  pinhole.lens = FVV_LENS_NONE;
  pinhole.r_max = infinity;
  pinhole.skew = 0;
  pinhole.width = uint32_t(across);
  pinhole.height = uint32_t(down);
  pinhole.cx = 1 - field.left * camera.fx;
  pinhole.cy = 1 - field.top * camera.fy;
  projection.emplace(pinhole);
  SampleBuffer buffer(pinhole.width, pinhole.height, test.samples);
  rasterise(*projection, mesh, buffer);
  columns = buffer.columns;
  rows = size_t(buffer.height) * buffer.samples;
  crop(buffer);
}

void DepthMap::crop(const SampleBuffer &buffer) {
  const SampleBuffer::Extent &drawn = buffer.drawn;
  if (drawn.left >= drawn.right || drawn.top >= drawn.bottom) return;
  left = drawn.left;
  top = drawn.top;
  width = drawn.right - drawn.left;
  depth.reserve(width * (drawn.bottom - drawn.top));
  for (size_t row = drawn.top; row < drawn.bottom; row++) {
    const auto first = buffer.depth.begin() + std::ptrdiff_t(row * buffer.columns + drawn.left);
    depth.insert(depth.end(), first, first + std::ptrdiff_t(width));
  }
}

bool DepthMap::hidden(Vec3 point, Vec3 face_normal) const {
  const Vec3 at = projection->to_camera(point);
  if (!(at.z >= nearest)) return true;
  const Vec3 pixel = projection->to_pixel(at);
  const double column = std::floor(pixel.x / pixel.z * test.samples),
               row = std::floor(pixel.y / pixel.z * test.samples);
  if (!(column >= 0 && row >= 0 && column < double(columns) && row < double(rows))) return true;
  if (size_t(column) < left || size_t(row) < top || size_t(column) - left >= width) return false;
  const size_t sample = (size_t(row) - top) * width + size_t(column) - left;
  if (sample >= depth.size()) return false;
  // On the plane through the point z = c / (n . r) for the ray r = (x, y, 1), so dz / dx = -z n_x / (n . r).
  const Vec3 normal = projection->to_camera(point + normalised(face_normal)) - at;
  const double facing = std::abs(dot(normal, at)) / at.z;
  const double recede =
      facing > 0 ? at.z * std::hypot(normal.x * breadth_x, normal.y * breadth_y) / facing : 0;
  const double allowed = test.bias * at.z * std::max(breadth_x, breadth_y) + test.slope * recede;
  return at.z > double(depth[sample]) + allowed;
}

bool hidden_by_rays(Vec3 centre, Vec3 point, uint32_t face, const RayCaster &rays) {
  return rays.blocked(centre, before(centre, point), face);
}

} // namespace fvv::render
