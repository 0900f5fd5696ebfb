// Sending rays through the hierarchy.
#include "fvv_render/ray.h"

#include <limits>

namespace fvv::render {

namespace {

// 1 + 2 gamma(3) of Ize: what three roundings can take from the far end of an interval.
constexpr double margin = 1 + 8 * std::numeric_limits<double>::epsilon();

bool finite(Vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

std::vector<TriangleTree::Triangle> triangles_of(const Mesh &mesh) {
  std::vector<TriangleTree::Triangle> out(mesh.face_count);
  for (size_t i = 0; i < 3 * mesh.face_count; i++) {
    const float *p = mesh.positions + size_t(3) * mesh.faces[i];
    out[i / 3][i % 3] = {p[0], p[1], p[2]};
  }
  return out;
}

} // namespace

RayCaster::RayCaster(const Mesh &mesh) : tree(triangles_of(mesh)) {}

struct RayCaster::Ray {
  Vec3 origin, inverse;
  bool backwards[3];
  int x, y, z; // z: the axis along which the ray is longest
  double shear_x, shear_y, scale;

  Ray(Vec3 from, Vec3 direction) : origin(from) {
    inverse = {1 / direction.x, 1 / direction.y, 1 / direction.z};
    const double size[3] = {std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)};
    z = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
    x = (z + 1) % 3;
    y = (x + 1) % 3;
    for (int axis = 0; axis < 3; axis++) backwards[axis] = std::signbit(axis_of(direction, axis));
    scale = 1 / axis_of(direction, z);
    shear_x = axis_of(direction, x) * scale;
    shear_y = axis_of(direction, y) * scale;
  }

  bool meets(const TriangleTree::Box &box, double least, double most) const {
    for (int axis = 0; axis < 3; axis++) {
      const double from = axis_of(origin, axis), by = axis_of(inverse, axis);
      const double low = (axis_of(box.low, axis) - from) * by, high = (axis_of(box.high, axis) - from) * by;
      const double enter = backwards[axis] ? high : low, leave = (backwards[axis] ? low : high) * margin;
      // NaN (a ray within the plane of a side) keeps what there is.
      if (enter > least) least = enter;
      if (leave < most) most = leave;
    }
    return least <= most;
  }

  // Distance and weights, or false.
  bool meets(const TriangleTree::Triangle &triangle, RayHit &hit) const {
    double px[3], py[3], pz[3];
    for (size_t i = 0; i < 3; i++) {
      const Vec3 p = triangle[i] - origin;
      pz[i] = axis_of(p, z);
      px[i] = axis_of(p, x) - shear_x * pz[i];
      py[i] = axis_of(p, y) - shear_y * pz[i];
    }
    // The faces on both sides of an edge get the same products with opposite signs. 0 is inside.
    const double u = px[2] * py[1] - py[2] * px[1], v = px[0] * py[2] - py[0] * px[2],
                 w = px[1] * py[0] - py[1] * px[0];
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const double sum = u + v + w;
    if (!(sum != 0)) return false;
    hit.distance = (u * pz[0] + v * pz[1] + w * pz[2]) * scale / sum;
    hit.barycentric = {u / sum, v / sum, w / sum};
    return true;
  }
};

template <bool any> RayHit RayCaster::cast(const Ray &ray, double least, double most, uint32_t except) const {
  RayHit best;
  if (tree.nodes.empty() || !std::isfinite(ray.scale) || !finite(ray.origin)) return best;
  std::array<uint32_t, TriangleTree::stack_size> stack;
  size_t waiting = 0;
  stack[waiting++] = 0;
  while (waiting) {
    const uint32_t index = stack[--waiting];
    const TriangleTree::Node &node = tree.nodes[index];
    if (!ray.meets(node.box, least, most)) continue;
    if (!node.count) {
      stack[waiting++] = node.second;
      stack[waiting++] = index + 1;
      continue;
    }
    for (size_t i = node.first; i < size_t(node.first) + node.count; i++) {
      RayHit hit;
      if (tree.order[i] == except || !ray.meets(tree.triangles[i], hit)) continue;
      if (!(hit.distance > least && hit.distance <= most)) continue;
      // most is the caller's until a face is found, then that face's distance.
      if (best.face == no_face ? hit.distance == most : hit.distance == most && tree.order[i] > best.face)
        continue;
      hit.face = tree.order[i];
      best = hit;
      most = hit.distance;
      if (any) return best;
    }
  }
  return best;
}

RayHit RayCaster::nearest(Vec3 origin, Vec3 direction, double least, double most, uint32_t except) const {
  return cast<false>(Ray(origin, direction), least, most, except);
}

bool RayCaster::blocked(Vec3 from, Vec3 to, uint32_t except) const {
  return cast<true>(Ray(from, to - from), 0, 1, except).face != no_face;
}

} // namespace fvv::render
