// fvv_scene: random polygons as triangles: their area, each triangle on the polygon's side, or a report.
#include "fvv_catch.h"

#include "scene/src/mesh_build.h"
#include "scene/src/polygon.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

using namespace fvv::scene;

namespace {

using Point = std::array<double, 2>;
using Points = std::vector<Point>;
using Random = std::mt19937;

double between(Random &random, double least, double most) {
  return least + (most - least) * double(random()) / 4294967296.0;
}

// The same on every machine, as std::shuffle is not.
void shuffle(Random &random, Points &points) {
  for (size_t i = points.size(); i > 1; i--) std::swap(points[i - 1], points[random() % i]);
}

// Around a middle that sees all of it, with bays and tips.
Points star(Random &random, size_t corners) {
  Points out;
  for (size_t i = 0; i < corners; i++) {
    const double angle = 2 * M_PI * (double(i) + between(random, 0, 0.9)) / double(corners),
                 radius = between(random, 0.1, 1);
    out.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return out;
}

// Teeth of unlike lengths, whose corners are in straight lines.
Points comb(Random &random, size_t teeth) {
  Points out = {{0, 0}, {double(2 * teeth + 1), 0}};
  for (size_t i = 2 * teeth + 1; i-- > 0;) {
    const double height = i % 2 ? 0.5 : between(random, 1, 3);
    out.push_back({double(i + 1), height});
    out.push_back({double(i), height});
  }
  return out;
}

// A band that winds inward.
Points spiral(Random &random, size_t corners) {
  Points outside, inside;
  const double width = between(random, 0.2, 0.8);
  for (size_t i = 0; i < corners; i++) {
    const double angle = 0.7 * double(i), radius = 1 + angle / (2 * M_PI);
    outside.push_back({(radius + width) * std::cos(angle), (radius + width) * std::sin(angle)});
    inside.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  outside.insert(outside.end(), inside.rbegin(), inside.rend());
  return outside;
}

// As programs write them: corners on edges, corners twice, spikes of no width.
void decorate(Random &random, Points &points) {
  for (size_t changes = random() % 4; changes; changes--) {
    const size_t at = random() % points.size();
    const Point a = points[at], b = points[(at + 1) % points.size()];
    const double t = 0.25 * double(random() % 4);
    const Point middle = {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])};
    const auto after = points.begin() + std::ptrdiff_t(at) + 1;
    if (random() % 3)
      points.insert(after, middle);
    else
      points.insert(after, {middle, b, middle}); // along the edge and back
  }
}

double twice_area(const Points &points) {
  double sum = 0;
  for (size_t i = 0; i < points.size(); i++) {
    const Point &a = points[i], &b = points[(i + 1) % points.size()];
    sum += a[0] * b[1] - a[1] * b[0];
  }
  return sum;
}

struct Triangles {
  double sum = 0, least = 0; // of twice their areas, seen from the side where the polygon's corners turn left
  bool is_reported = false;
  std::vector<uint32_t> corners;
};

// In a plane of its own, far from the origin.
Triangles triangles_of(const Points &points, double turn, double size) {
  const double c = std::cos(turn), s = std::sin(turn);
  const std::array<double, 3> right = {c, s * 0.6, s * 0.8}, up = {-s, c * 0.6, c * 0.8};
  Mesh mesh;
  for (const Point &p : points)
    for (size_t k = 0; k < 3; k++)
      mesh.positions.push_back(size * (right[k] * p[0] + up[k] * p[1] + double(k)));
  std::vector<uint32_t> corners(points.size());
  for (size_t i = 0; i < corners.size(); i++) corners[i] = uint32_t(i);
  MeshReport report;
  append_fan(mesh, corners, report);
  const ConcavePolygons polygons(mesh, {{0, uint32_t(points.size())}}, report, "a.obj");
  polygons.apply(mesh.faces, 1);
  Triangles out;
  out.is_reported = report.self_crossing != 0;
  out.corners = mesh.faces;
  for (size_t i = 0; i < mesh.faces.size(); i += 3) {
    const double area =
        twice_area({points[mesh.faces[i]], points[mesh.faces[i + 1]], points[mesh.faces[i + 2]]});
    out.sum += std::abs(area);
    out.least = std::min(out.least, area);
  }
  return out;
}

} // namespace

TEST_CASE("random polygons: their triangles cover them once, on their side") {
  Random random(5);
  for (int i = 0; i < 3000; i++) {
    const size_t count = 4 + random() % 20;
    Points points = i % 3 == 0   ? star(random, count)
                    : i % 3 == 1 ? comb(random, 1 + count / 4)
                                 : spiral(random, count);
    decorate(random, points);
    std::rotate(points.begin(), points.begin() + std::ptrdiff_t(random() % points.size()), points.end());
    const double area = twice_area(points), size = std::pow(10, int(random() % 7) - 3);
    CAPTURE(i, count, points.size(), size);
    const Triangles found = triangles_of(points, between(random, 0, 6), size);
    CHECK_FALSE(found.is_reported);
    CHECK(found.corners.size() == 3 * (points.size() - 2));
    CHECK(std::abs(found.sum - area) < 1e-6 * area);
    CHECK(found.least > -1e-6 * area);
    // From the other side.
    std::reverse(points.begin(), points.end());
    const Triangles back = triangles_of(points, between(random, 0, 6), size);
    CHECK_FALSE(back.is_reported);
    CHECK(std::abs(back.sum - area) < 1e-6 * area);
  }
}

TEST_CASE("random corners in any order: their triangles have the polygon's area, or it is reported") {
  Random random(6);
  size_t reported = 0;
  for (int i = 0; i < 3000; i++) {
    // On a grid, so that corners coincide, edges overlap and points are on edges.
    Points points;
    for (size_t k = 4 + random() % 6; k; k--) points.push_back({double(random() % 5), double(random() % 5)});
    if (i % 2) {
      points = star(random, points.size());
      shuffle(random, points);
    }
    CAPTURE(i);
    const Triangles found = triangles_of(points, between(random, 0, 6), 1);
    reported += found.is_reported;
    if (found.is_reported) continue;
    const double area = std::abs(twice_area(points));
    CHECK(std::abs(found.sum - area) < 1e-6 * std::max(area, 1.0));
  }
  CHECK(reported > 1000);
  CHECK(reported < 2900);
}
