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
// Of the square of the extent: areas of triangles that are none but for rounding.
constexpr double no_area = 1e-12;

using Point = std::array<double, 2>;

double twice_area(const Point &a, const Point &b, const Point &c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// The corners in the plane of the polygon, seen from the side to which its normal points. Empty if it has
// none: it has no area, or its parts cancel. fan_area: of all triangles of the fan, 0 if that is
// rounding alone.
std::vector<Point> flattened(const Mesh &mesh, const std::vector<uint32_t> &corners, double &fan_area) {
  const double *origin = &mesh.positions[size_t(3) * corners[0]];
  const auto at = [&](size_t i, size_t axis) {
    return mesh.positions[size_t(3) * corners[i % corners.size()] + axis] - origin[axis];
  };
  const auto length_of = [](const std::array<double, 3> &v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  };
  std::array<double, 3> n = {};
  double extent = 0;
  fan_area = 0;
  for (size_t i = 0; i < corners.size(); i++) {
    std::array<double, 3> of_triangle = {};
    for (size_t axis = 0; axis < 3; axis++) {
      const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      n[axis] += (at(i, u) - at(i + 1, u)) * (at(i, v) + at(i + 1, v));
      of_triangle[axis] = at(i, u) * at(i + 1, v) - at(i, v) * at(i + 1, u);
      extent = std::max(extent, std::abs(at(i, axis)));
    }
    fan_area += length_of(of_triangle);
  }
  if (fan_area <= no_area * extent * extent) fan_area = 0;
  const double length = length_of(n);
  if (!(length > rounding * fan_area) || !std::isfinite(length)) return {};
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
      : points(corners), steps(steps_so_far), name(file) {
    double extent = 0;
    for (const Point &point : points)
      extent = std::max({extent, std::abs(point[0] - points[0][0]), std::abs(point[1] - points[0][1])});
    least = no_area * extent * extent;
  }

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

  // Empty if there are none that cover the polygon once.
  std::vector<uint32_t> triangles() {
    left.resize(points.size());
    for (size_t i = 0; i < left.size(); i++) left[i] = uint32_t(i);
    for (size_t i = 0; i < left.size(); i++)
      if (left.size() > 2 && is_spike(i)) cut(i);
    size_t at = 0, failures = 0;
    while (left.size() > 2) {
      const size_t n = left.size();
      // Where there is no ear, a corner in a straight line goes.
      if (failures == 2 * n) return {};
      at %= n;
      if (failures < n ? is_ear(at) : is_flat(at)) {
        cut(at);
        failures = 0;
      } else {
        at++;
        failures++;
      }
    }
    return std::move(out);
  }

private:
  void count() {
    if (++steps > most_steps)
      throw Error(name + ": has too many polygons that are not convex; write triangles");
  }

  bool cross(const Point &a, const Point &b, const Point &c, const Point &d) const {
    const auto side = [&](const Point &p, const Point &q, const Point &r) {
      const double area = twice_area(p, q, r);
      return area > least ? 1 : area < -least ? -1 : 0;
    };
    return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
  }

  const Point &corner(size_t at) const { return points[left[at % left.size()]]; }

  bool is_flat(size_t at) const {
    return std::abs(twice_area(corner(at + left.size() - 1), corner(at), corner(at + 1))) <= least;
  }

  // Goes back where it came from. Such corners go first: the inside is on neither side of them.
  bool is_spike(size_t at) const {
    const Point &p = corner(at + left.size() - 1), &q = corner(at), &r = corner(at + 1);
    return is_flat(at) && (p[0] - q[0]) * (r[0] - q[0]) + (p[1] - q[1]) * (r[1] - q[1]) >= 0;
  }

  // Takes off a corner, and the spikes that this leaves.
  void cut(size_t at) {
    do {
      const size_t n = left.size();
      at %= n;
      out.insert(out.end(), {left[(at + n - 1) % n], left[at], left[(at + 1) % n]});
      left.erase(left.begin() + std::ptrdiff_t(at));
      if (left.size() > 2 && is_spike(at + left.size() - 1)) at += left.size() - 1;
    } while (left.size() > 2 && is_spike(at));
  }

  // Turns left, and no edge passes through the inside: corners and edges may touch.
  bool is_ear(size_t at) {
    const size_t n = left.size();
    const Point &p = corner(at + n - 1), &q = corner(at), &r = corner(at + 1);
    if (!(twice_area(p, q, r) > least)) return false;
    for (size_t i = 1; i < n - 1; i++) {
      count();
      if (passes_through(p, q, r, corner(at + i), corner(at + i + 1))) return false;
    }
    return true;
  }

  // Whether a part of the edge from a to b is within the triangle.
  bool passes_through(const Point &p, const Point &q, const Point &r, const Point &a, const Point &b) const {
    double from = 0, to = 1;
    const Point *sides[3][2] = {{&p, &q}, {&q, &r}, {&r, &p}};
    for (const auto &side : sides) {
      const double of_a = twice_area(*side[0], *side[1], a) - least,
                   of_b = twice_area(*side[0], *side[1], b) - least;
      if (of_a <= 0 && of_b <= 0) return false;
      if (of_a < 0) from = std::max(from, of_a / (of_a - of_b));
      if (of_b < 0) to = std::min(to, of_a / (of_a - of_b));
    }
    return from < to;
  }

  const std::vector<Point> &points;
  std::vector<uint32_t> left; // corners that are not cut off
  std::vector<uint32_t> out;  // triangles of those that are
  double least;               // area, twice
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
    double fan_area = 0;
    const std::vector<Point> points = flattened(mesh, corners, fan_area);
    if (points.empty()) {
      report.self_crossing += fan_area > 0; // its parts cancel
      continue;
    }
    if (fan_covers(points)) continue;
    Cutter cutter(points, steps, name);
    std::vector<uint32_t> triangles;
    if (!cutter.crosses_itself()) triangles = cutter.triangles();
    if (triangles.empty())
      report.self_crossing++;
    else
      split.push_back({polygon, std::move(triangles)});
  }
}

} // namespace fvv::scene
