#include "fvv_render/closest.h"

#include <algorithm>

namespace fvv::render {

namespace {

// Height over longest edge, squared twice over, below which a triangle's normal says nothing.
constexpr double flat = 1e-20;

double clamped(double value, double a, double b, double c) {
  return std::clamp(value, std::min({a, b, c}), std::max({a, b, c}));
}

// From a point to a box. No coordinate of closest_on_triangle()'s point comes nearer, because differences
// are rounded monotonically and it is clamped to the corners: no margin is needed.
double squared_distance(Vec3 from, const TriangleTree::Box &box) {
  const Vec3 below = box.low - from, above = from - box.high;
  const Vec3 d{std::max({below.x, above.x, 0.0}), std::max({below.y, above.y, 0.0}),
               std::max({below.z, above.z, 0.0})};
  return dot(d, d);
}

// A triangle as seen from the point.
struct Candidate {
  Vec3 a, b, c;
  double squared = std::numeric_limits<double>::infinity();
  Vec3 offset = {};
  std::array<double, 3> weights = {};

  void offer(std::array<double, 3> w) {
    Vec3 q = a * w[0] + b * w[1] + c * w[2];
    q = {clamped(q.x, a.x, b.x, c.x), clamped(q.y, a.y, b.y, c.y), clamped(q.z, a.z, b.z, c.z)};
    const double d = dot(q, q);
    if (!(d < squared)) return;
    squared = d;
    offset = q;
    weights = w;
  }

  // How far along an edge its nearest point lies, 0 to 1.
  static double along(Vec3 start, Vec3 end) {
    const Vec3 edge = end - start;
    const double size = dot(edge, edge), t = -dot(start, edge);
    return t <= 0 || !(size > 0) ? 0 : t >= size ? 1 : t / size;
  }

  void search() {
    const Vec3 ab = b - a, ac = c - a, bc = c - b, normal = cross(ab, ac);
    const double longest = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
    if (dot(normal, normal) > flat * longest * longest) {
      const double u = dot(normal, cross(b, c)), v = dot(normal, cross(c, a)), w = dot(normal, cross(a, b)),
                   sum = u + v + w;
      if (u > 0 && v > 0 && w > 0) return offer({u / sum, v / sum, w / sum});
    }
    const double on_ab = along(a, b), on_bc = along(b, c), on_ca = along(c, a);
    offer({1 - on_ab, on_ab, 0});
    offer({0, 1 - on_bc, on_bc});
    offer({on_ca, 0, 1 - on_ca});
  }
};

} // namespace

ClosestPoint closest_on_triangle(Vec3 from, const TriangleTree::Triangle &triangle) {
  Candidate candidate{triangle[0] - from, triangle[1] - from, triangle[2] - from};
  candidate.search();
  return {0, candidate.squared, from + candidate.offset, candidate.weights};
}

ClosestPoint ClosestFinder::nearest(Vec3 from) const {
  ClosestPoint best;
  if (tree.nodes.empty() || !std::isfinite(dot(from, from))) return best;
  struct Waiting {
    uint32_t node;
    double squared;
  };
  std::array<Waiting, TriangleTree::stack_size> stack;
  size_t waiting = 0;
  stack[waiting++] = {0, squared_distance(from, tree.nodes[0].box)};
  while (waiting) {
    const auto [index, squared] = stack[--waiting];
    if (squared > best.squared) continue;
    const TriangleTree::Node &node = tree.nodes[index];
    if (!node.count) {
      Waiting near{index + 1, squared_distance(from, tree.nodes[index + 1].box)};
      Waiting far{node.second, squared_distance(from, tree.nodes[node.second].box)};
      if (far.squared < near.squared) std::swap(near, far);
      stack[waiting++] = far;
      stack[waiting++] = near;
      continue;
    }
    for (size_t i = node.first; i < size_t(node.first) + node.count; i++) {
      ClosestPoint found = closest_on_triangle(from, tree.triangles[i]);
      found.face = tree.order[i];
      if (found.squared < best.squared || (found.squared == best.squared && found.face < best.face))
        best = found;
    }
  }
  return best;
}

} // namespace fvv::render
