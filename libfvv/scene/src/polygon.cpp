// Convex polygons keep their fan. Others are cut by ears (Meisters, "Polygons have ears", American
// Mathematical Monthly 82, 1975) in their own plane, whose normal is Newell's.

#include "scene/src/polygon.h"
#include "fvv_cxx/error.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fvv::scene {

namespace {

// Comparisons of a point with an edge or a triangle. Ears of n corners may take n^3 of them.
constexpr uint64_t most_steps = uint64_t(4) << 30;
// Of the area: what rounding may turn the other way.
constexpr double rounding = 1e-9;

using Point = std::array<double, 2>;

double twice_area(const Point &a, const Point &b, const Point &c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// The corners in the plane of the polygon, seen from the side to which its normal points. Empty if it has
// none.
std::vector<Point> flattened(const Mesh &mesh, const std::vector<uint32_t> &corners) {
  const double *origin = &mesh.positions[size_t(3) * corners[0]];
  const auto at = [&](size_t i, size_t axis) {
    return mesh.positions[size_t(3) * corners[i % corners.size()] + axis] - origin[axis];
  };
  std::array<double, 3> n = {};
  for (size_t i = 0; i < corners.size(); i++)
    for (size_t axis = 0; axis < 3; axis++) {
      const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      n[axis] += (at(i, u) - at(i + 1, u)) * (at(i, v) + at(i + 1, v));
    }
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 0) || !std::isfinite(length)) return {};
  for (double &x : n) x /= length;
  // Two axes at right angles to the normal, from the coordinate axis that is farthest from it.
  const size_t least = size_t(
      std::min_element(n.begin(), n.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }) -
      n.begin());
  std::array<double, 3> right = {-n[0] * n[least], -n[1] * n[least], -n[2] * n[least]};
  right[least] += 1;
  const double scale = 1 / std::sqrt(right[0] * right[0] + right[1] * right[1] + right[2] * right[2]);
  for (double &x : right) x *= scale;
  const std::array<double, 3> up = {n[1] * right[2] - n[2] * right[1], n[2] * right[0] - n[0] * right[2],
                                    n[0] * right[1] - n[1] * right[0]};
  std::vector<Point> out(corners.size());
  for (size_t i = 0; i < corners.size(); i++)
    out[i] = {at(i, 0) * right[0] + at(i, 1) * right[1] + at(i, 2) * right[2],
              at(i, 0) * up[0] + at(i, 1) * up[1] + at(i, 2) * up[2]};
  return out;
}

bool fan_covers(const std::vector<Point> &points) {
  double sum = 0, least = 0;
  for (size_t i = 1; i + 1 < points.size(); i++) {
    const double area = twice_area(points[0], points[i], points[i + 1]);
    sum += area;
    least = std::min(least, area);
  }
  return least >= -rounding * sum;
}

class Cutter {
public:
  Cutter(const std::vector<Point> &corners, uint64_t &steps_so_far, const std::string &file)
      : points(corners), steps(steps_so_far), name(file) {}

  bool crosses_itself() {
    const size_t n = points.size();
    for (size_t i = 0; i < n; i++)
      for (size_t k = i + 2; k < n; k++) {
        count();
        if (i == 0 && k == n - 1) continue; // neighbours
        if (cross(points[i], points[i + 1], points[k], points[(k + 1) % n])) return true;
      }
    return false;
  }

  std::vector<uint32_t> triangles() {
    std::vector<uint32_t> left(points.size()), out;
    for (size_t i = 0; i < left.size(); i++) left[i] = uint32_t(i);
    size_t at = 0, failures = 0;
    while (left.size() > 3) {
      const size_t n = left.size();
      at %= n;
      const uint32_t before = left[(at + n - 1) % n], here = left[at], after = left[(at + 1) % n];
      // Where rounding leaves no ear, any corner goes on: the triangles that are left have hardly an area.
      if (failures < n && !is_ear(before, here, after, left)) {
        at++;
        failures++;
        continue;
      }
      out.insert(out.end(), {before, here, after});
      left.erase(left.begin() + std::ptrdiff_t(at));
      failures = 0;
    }
    out.insert(out.end(), left.begin(), left.end());
    return out;
  }

private:
  void count() {
    if (++steps > most_steps)
      throw Error(name + ": has too many polygons that are not convex; write triangles");
  }

  static bool cross(const Point &a, const Point &b, const Point &c, const Point &d) {
    const double ac = twice_area(a, b, c), ad = twice_area(a, b, d), ca = twice_area(c, d, a),
                 cb = twice_area(c, d, b);
    return ((ac > 0 && ad < 0) || (ac < 0 && ad > 0)) && ((ca > 0 && cb < 0) || (ca < 0 && cb > 0));
  }

  bool is_ear(uint32_t a, uint32_t b, uint32_t c, const std::vector<uint32_t> &left) {
    const Point &p = points[a], &q = points[b], &r = points[c];
    if (!(twice_area(p, q, r) > 0)) return false;
    for (const uint32_t other : left) {
      count();
      if (other == a || other == b || other == c) continue;
      const Point &x = points[other];
      if (x == p || x == q || x == r) continue; // a corner that is there twice
      if (twice_area(p, q, x) >= 0 && twice_area(q, r, x) >= 0 && twice_area(r, p, x) >= 0) return false;
    }
    return true;
  }

  const std::vector<Point> &points;
  uint64_t &steps;
  const std::string &name;
};

} // namespace

ConcavePolygons::ConcavePolygons(const Mesh &mesh, const std::vector<Polygon> &polygons, MeshReport &report,
                                 const std::string &name) {
  uint64_t steps = 0;
  std::vector<uint32_t> corners;
  for (const Polygon &polygon : polygons) {
    const uint32_t *fan = &mesh.faces[polygon.first_triangle * 3];
    corners.assign(fan, fan + 2);
    for (size_t t = 0; t + 2 < polygon.corners; t++) corners.push_back(fan[3 * t + 2]);
    const std::vector<Point> points = flattened(mesh, corners);
    if (!points.empty() && fan_covers(points)) continue;
    // Without a normal the parts of a polygon cancel, or it has no area at all.
    Cutter cutter(points, steps, name);
    if (points.empty() || cutter.crosses_itself()) {
      report.self_crossing += !points.empty();
      continue;
    }
    split.push_back({polygon, cutter.triangles()});
  }
}

} // namespace fvv::scene
