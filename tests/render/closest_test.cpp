// Nearest points against all triangles one by one, by another method.
#include "fvv_catch.h"

#include "fvv_render/triangle_tree.h"
#include "fvvsynth/random.h"

#include <algorithm>
#include <limits>
#include <utility>

using namespace fvv::render;
using fvv::synth::Random;

namespace {

using Triangle = TriangleTree::Triangle;

Vec3 anywhere(Random &random, double size) {
  const double x = random.between(-size, size), y = random.between(-size, size),
               z = random.between(-size, size);
  return {x, y, z};
}

// Of all sizes, some slender, some without area, that cut each other.
std::vector<Triangle> soup(uint64_t seed, size_t count, Vec3 shift = {}) {
  Random random(seed);
  std::vector<Triangle> out;
  for (size_t i = 0; i < count; i++) {
    const Vec3 centre = anywhere(random, 1) + shift;
    const double size = i % 10 ? 0.1 : 1;
    Triangle t{centre, centre + anywhere(random, size), centre + anywhere(random, size)};
    if (i % 7 == 3) t[2] = mix(t[0], t[1], 0.3) + anywhere(random, 1e-9);
    if (i % 11 == 5) t[2] = t[1];
    if (i % 13 == 6) t[1] = t[2] = t[0];
    out.push_back(t);
  }
  return out;
}

// The distance by the Voronoi regions of a triangle (Ericson, section 5.1.5) in long doubles, where the
// tested code goes by barycentric coordinates.
long double distance_to(Vec3 from, const Triangle &triangle) {
  using Long = std::array<long double, 3>;
  const auto relative = [&](Vec3 p) {
    return Long{(long double)p.x - from.x, (long double)p.y - from.y, (long double)p.z - from.z};
  };
  const auto inner = [](Long p, Long q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; };
  const auto plus = [](Long p, Long q, long double t) {
    return Long{p[0] + q[0] * t, p[1] + q[1] * t, p[2] + q[2] * t};
  };
  const Long a = relative(triangle[0]), b = relative(triangle[1]), c = relative(triangle[2]);
  const auto segment = [&](Long p, Long q) {
    const Long edge = plus(q, p, -1);
    const long double size = inner(edge, edge), t = size > 0 ? -inner(p, edge) / size : 0;
    const Long at = plus(p, edge, std::clamp(t, 0.0L, 1.0L));
    return std::sqrt(inner(at, at));
  };
  long double best = std::min({segment(a, b), segment(b, c), segment(c, a)});
  const Long ab = plus(b, a, -1), ac = plus(c, a, -1);
  const long double d1 = -inner(ab, a), d2 = -inner(ac, a), d3 = -inner(ab, b), d4 = -inner(ac, b),
                    d5 = -inner(ab, c), d6 = -inner(ac, c);
  const long double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (va > 0 && vb > 0 && vc > 0) {
    const long double sum = va + vb + vc;
    const Long at = plus(plus(a, ab, vb / sum), ac, vc / sum);
    best = std::min(best, std::sqrt(inner(at, at)));
  }
  return best;
}

} // namespace

TEST_CASE("the nearest point is the one that looking at every triangle finds, to the last bit") {
  for (const Vec3 shift : {Vec3{}, Vec3{1000, -2000, 500}}) {
    const std::vector<Triangle> triangles = soup(1, 700, shift);
    const ClosestFinder finder(triangles);
    Random random(2);
    for (int k = 0; k < 2000; k++) {
      Vec3 from = anywhere(random, k % 3 ? 1.2 : 20) + shift;
      if (k % 5 == 0) from = triangles[size_t(k) % triangles.size()][size_t(k) % 3]; // on a corner
      ClosestPoint best;
      for (uint32_t i = 0; i < triangles.size(); i++) {
        ClosestPoint one = closest_on_triangle(from, triangles[i]);
        one.face = i;
        if (one.squared < best.squared) best = one; // the first of equals stays
      }
      const ClosestPoint found = finder.nearest(from);
      REQUIRE(found.face == best.face);
      REQUIRE(found.squared == best.squared);
      REQUIRE(found.barycentric == best.barycentric);
    }
  }
}

TEST_CASE("a hierarchy of the same triangles at other places changes no result") {
  const std::vector<Triangle> before = soup(8, 700);
  std::vector<Triangle> after = before;
  Random random(9);
  for (Triangle &triangle : after) {
    const Vec3 shift = anywhere(random, 0.5);
    for (Vec3 &corner : triangle) corner += shift;
  }
  const ClosestFinder like(before), fresh(after), moved(after, &like);
  std::vector<Triangle> fewer(after.begin(), after.end() - 1), broken = after;
  broken[5][0].x = std::numeric_limits<double>::infinity();
  const ClosestFinder fresh_fewer(fewer), moved_fewer(fewer, &like), fresh_broken(broken),
      moved_broken(broken, &like);
  for (int k = 0; k < 2000; k++) {
    const Vec3 from = anywhere(random, k % 3 ? 1.2 : 20);
    for (const auto &[wanted, found] : {std::pair{fresh.nearest(from), moved.nearest(from)},
                                        {fresh_fewer.nearest(from), moved_fewer.nearest(from)},
                                        {fresh_broken.nearest(from), moved_broken.nearest(from)}}) {
      REQUIRE(found.face == wanted.face);
      REQUIRE(found.squared == wanted.squared);
      REQUIRE(found.barycentric == wanted.barycentric);
    }
  }
}

TEST_CASE("a guess changes no result, and a search that may end early finds whether anything is so near") {
  std::vector<Triangle> triangles = soup(6, 700);
  triangles[99][1].y = std::numeric_limits<double>::quiet_NaN();
  const ClosestFinder finder(triangles);
  Random random(7);
  size_t early = 0;
  for (int k = 0; k < 2000; k++) {
    const Vec3 from = anywhere(random, k % 3 ? 1.2 : 20);
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < triangles.size(); i++)
      if (i != 99) least = std::min(least, closest_on_triangle(from, triangles[i]).squared);
    const ClosestPoint plain = finder.nearest(from);
    for (const uint32_t guess : {uint32_t(k) % 700, plain.face, 99u, 700u, UINT32_MAX}) {
      const ClosestPoint guessed = finder.nearest(from, guess);
      REQUIRE(guessed.squared == least);
      REQUIRE(guessed.face == plain.face);
      REQUIRE(guessed.barycentric == plain.barycentric);
      for (const double enough : {0.0, least * 0.9, least, least * 2}) {
        const ClosestPoint found = finder.nearest(from, guess, enough);
        REQUIRE((found.squared <= enough) == (least <= enough));
        REQUIRE(found.squared == closest_on_triangle(from, triangles[found.face]).squared);
        if (least > enough) REQUIRE(found.face == plain.face);
        early += found.face != plain.face;
      }
    }
  }
  CHECK(early > 0); // or nothing was saved
  std::vector<uint32_t> order = finder.along_surface();
  std::sort(order.begin(), order.end());
  std::vector<uint32_t> all;
  for (uint32_t i = 0; i < triangles.size(); i++)
    if (i != 99) all.push_back(i);
  CHECK(order == all);
}

TEST_CASE("distances agree with the Voronoi regions of triangles in long doubles") {
  const std::vector<Triangle> triangles = soup(3, 200);
  Random random(4);
  double worst = 0;
  for (int k = 0; k < 500; k++) {
    const Vec3 from = anywhere(random, 1.2);
    for (const Triangle &t : triangles) {
      const ClosestPoint found = closest_on_triangle(from, t);
      const double truth = double(distance_to(from, t));
      worst = std::max(worst, std::abs(std::sqrt(found.squared) - truth));
      const auto &w = found.barycentric;
      REQUIRE(w[0] + w[1] + w[2] == Approx(1));
      REQUIRE(*std::min_element(w.begin(), w.end()) >= 0);
      REQUIRE(length(t[0] * w[0] + t[1] * w[1] + t[2] * w[2] - found.point) < 1e-14);
    }
  }
  // A triangle that is 1e-10 of its length high counts as its edges.
  CHECK(worst < 2e-10);
}

TEST_CASE("points of a triangle are at no distance of it") {
  const Triangle t{Vec3{1, 2, 3}, Vec3{4, -1, 2}, Vec3{-2, 0.5, 7}};
  const ClosestFinder finder({t});
  Random random(5);
  for (int k = 0; k < 1000; k++) {
    const double u = random.between(0, 1), v = random.between(0, 1 - u);
    const Vec3 on = t[0] * (1 - u - v) + t[1] * u + t[2] * v;
    CHECK(std::sqrt(finder.nearest(on).squared) < 3e-15);
  }
  for (const Vec3 &corner : t) CHECK(finder.nearest(corner).squared == 0);
}

TEST_CASE("of triangles at the same distance the one with the lowest index is nearest") {
  const Triangle t{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}};
  std::vector<Triangle> triangles(100, t);
  triangles[0] = {Vec3{0, 0, 5}, Vec3{1, 0, 5}, Vec3{0, 1, 5}};
  CHECK(ClosestFinder(triangles).nearest({0.2, 0.2, 1}).face == 1);
}

TEST_CASE("triangles and points that are not finite are left out") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const Triangle bad{Vec3{0, 0, nan}, Vec3{1, 0, 0}, Vec3{0, 1, 0}};
  const Triangle good{Vec3{0, 0, 9}, Vec3{1, 0, 9}, Vec3{0, 1, 9}};
  CHECK(ClosestFinder({bad, good}).nearest({0, 0, 0}).face == 1);
  CHECK(ClosestFinder({bad}).nearest({0, 0, 0}).face == UINT32_MAX);
  CHECK(ClosestFinder({}).nearest({0, 0, 0}).face == UINT32_MAX);
  CHECK(ClosestFinder({good}).nearest({0, nan, 0}).face == UINT32_MAX);
}
