// Distances, PSNR, normals and motion where the result is known.
#include "compare_fixture.h"

#include "compare/src/measure.h"

#include <algorithm>

using namespace fvv::compare;
using namespace shapes;

namespace {

constexpr size_t count = 20000;

Measure of(const Mesh &a, const Mesh &b, Points points = Points::vertices) {
  return measure(Surface(a), Surface(b), count, points);
}

// The nearest of all triangles, one by one.
double by_hand(Vec3 from, const Mesh &mesh) {
  const std::vector<Vec3> at = positions_of(mesh);
  double best = INFINITY;
  for (size_t f = 0; f < mesh.faces.size(); f += 3)
    best = std::min(best, fvv::render::closest_on_triangle(
                              from, {at[mesh.faces[f]], at[mesh.faces[f + 1]], at[mesh.faces[f + 2]]})
                              .squared);
  return std::sqrt(best);
}

} // namespace

TEST_CASE("a sphere in a sphere is as far away as their radii differ") {
  constexpr double e = 0.01;
  const Measure m = of(sphere(150, 1 + e), sphere(150, 1));
  for (const DirectedErrors *direction : {&m.a_to_b, &m.b_to_a}) {
    const Figures f = direction->distance.figures();
    CHECK(f.rms == Approx(e).epsilon(2e-3));
    CHECK(f.mean == Approx(e).epsilon(2e-3));
    CHECK(f.p99 == Approx(e).epsilon(2e-3));
    CHECK(direction->d1 == Approx(e * e).epsilon(1e-9));
    CHECK(direction->d2 == Approx(e * e).epsilon(1e-3));
    CHECK(direction->angle.figures().mean < 0.1);
    CHECK(direction->turned == 0);
  }
  // A corner of the outer one is nearest to its own corner of the inner one.
  CHECK(m.a_to_b.hausdorff == Approx(e).epsilon(1e-12));
}

TEST_CASE("a plane that is lifted is off by that everywhere") {
  const Measure m = of(plane(10, 0), plane(10, 0.25));
  for (const DirectedErrors *direction : {&m.a_to_b, &m.b_to_a}) {
    const Figures f = direction->distance.figures();
    CHECK(f.rms == Approx(0.25).epsilon(1e-12));
    CHECK(f.mean == Approx(0.25).epsilon(1e-12));
    CHECK(f.p99 == 0.25);
    CHECK(direction->hausdorff == Approx(0.25).epsilon(1e-12));
    CHECK(direction->d1 == 0.0625);
    CHECK(direction->d2 == 0.0625);
    CHECK(direction->angle.figures().max == 0);
  }
  CHECK(psnr(std::sqrt(2), 0.0625) == Approx(10 * std::log10(32)));
  CHECK(psnr(1, 0) == INFINITY);
}

TEST_CASE("a plane that is pushed along itself is off at its rim, and by points but not by planes") {
  constexpr double shift = 0.03; // less than half a cell
  const Measure m = of(plane(10, 0), plane(10, 0, shift));
  CHECK(m.a_to_b.hausdorff == Approx(shift));
  CHECK(m.b_to_a.hausdorff == Approx(shift));
  // Linear from 0 to shift within a strip of that width.
  CHECK(m.a_to_b.distance.figures().rms == Approx(std::sqrt(shift * shift * shift / 3)).epsilon(0.02));
  CHECK(m.a_to_b.distance.figures().mean == Approx(shift * shift / 2).epsilon(0.02));
  CHECK(m.a_to_b.d1 == Approx(shift * shift));
  CHECK(m.a_to_b.d2 == 0);
}

TEST_CASE("quantising spreads vertices evenly over a step") {
  constexpr double step = 0.002;
  // Rows of a sphere share their z: without noise their errors would not be independent.
  const Mesh source = noisy(sphere(160, 0.9371), step, 6);
  const Measure m = of(source, quantised(source, step));
  // Variance step^2 / 12 an axis; a point of a face averages its corners, which halves it (the mean of the
  // sum of squared barycentric coordinates is 1/2), and only what is across the surface counts.
  CHECK(m.a_to_b.d1 == Approx(3 * step * step / 12).epsilon(0.03));
  CHECK(m.a_to_b.d2 == Approx(step * step / 12).epsilon(0.04));
  CHECK(m.a_to_b.distance.figures().rms == Approx(step / std::sqrt(24)).epsilon(0.04));
  CHECK(m.a_to_b.hausdorff <= step / 2 * std::sqrt(3));
  CHECK(m.b_to_a.hausdorff <= step / 2 * std::sqrt(3));
}

TEST_CASE("faces that are turned over show") {
  const Mesh ball = sphere(40, 1);
  const Measure all = of(ball, turned_over(ball));
  CHECK(all.a_to_b.angle.figures().mean == Approx(180));
  CHECK(all.a_to_b.turned == 1);
  CHECK(all.a_to_b.distance.figures().max < 1e-15);
  Mesh one = plane(10, 0);
  std::swap(one.faces[0], one.faces[1]); // one of 200 faces
  const Measure m = of(plane(10, 0), one);
  CHECK(m.a_to_b.turned == Approx(1 / 200.).epsilon(0.02));
  CHECK(m.b_to_a.turned == Approx(1 / 200.).epsilon(0.02));
}

TEST_CASE("where several vertices lie in one place they count once, and normals do not break") {
  const Mesh whole = sphere(20, 1);
  Mesh apart; // every face with vertices of its own
  for (const uint32_t v : whole.faces) {
    apart.faces.push_back(uint32_t(apart.vertex_count()));
    apart.positions.insert(apart.positions.end(), &whole.positions[3 * size_t(v)],
                           &whole.positions[3 * size_t(v)] + 3);
  }
  const Surface one(whole), other(apart);
  CHECK(apart.vertex_count() == 3 * whole.face_count());
  CHECK(other.points().size() == one.points().size());
  const Measure m = measure(one, other, count, Points::vertices);
  CHECK(m.a_to_b.d1 == 0);
  CHECK(m.a_to_b.angle.figures().max < 1e-6);
  CHECK(m.b_to_a.angle.figures().max < 1e-6);
}

TEST_CASE("a tilted plane has that angle") {
  Mesh tilted = plane(4, 0);
  const double angle = 7 * M_PI / 180;
  for (size_t v = 0; v < tilted.vertex_count(); v++) {
    double *p = &tilted.positions[3 * v];
    p[2] = std::sin(angle) * p[0];
    p[0] *= std::cos(angle);
  }
  const Figures f = of(plane(4, 0), tilted).a_to_b.angle.figures();
  CHECK(f.mean == Approx(7).epsilon(1e-9));
  CHECK(f.max == Approx(7).epsilon(1e-9));
  CHECK(f.p99 == Approx(7).epsilon(1e-3));
}

TEST_CASE("figures are those of looking at every triangle and sorting all distances") {
  const Mesh a = noisy(sphere(9, 1), 0.05, 1), b = noisy(sphere(8, 1.02), 0.05, 2);
  const Surface of_a(a), of_b(b);
  constexpr size_t few = 3000;
  const DirectedErrors found = measure(of_a, of_b, few, Points::vertices).a_to_b;
  std::vector<double> distances;
  double sum = 0, squares = 0;
  for (const Sample &s : of_a.sample(few)) distances.push_back(by_hand(s.point, b));
  std::sort(distances.begin(), distances.end());
  for (const double d : distances) sum += d, squares += d * d;
  const Figures f = found.distance.figures();
  CHECK(f.rms == Approx(std::sqrt(squares / few)).epsilon(1e-12));
  CHECK(f.mean == Approx(sum / few).epsilon(1e-12));
  CHECK(f.max == distances.back());
  const double p99 = distances[few * 99 / 100 - 1];
  CHECK(f.p99 <= p99);
  CHECK(f.p99 >= p99 * (1 - 1. / 1024));
  double furthest = distances.back(), d1 = 0, d2 = 0;
  const std::vector<Vec3> points = of_b.points(), normals = of_b.normals();
  for (const Vec3 &p : of_a.points()) {
    furthest = std::max(furthest, by_hand(p, b));
    size_t best = 0;
    for (size_t q = 0; q < points.size(); q++)
      if (length(p - points[q]) < length(p - points[best])) best = q;
    d1 += std::pow(length(p - points[best]), 2);
    d2 += std::pow(dot(p - points[best], normals[best]), 2);
  }
  CHECK(found.hausdorff == furthest);
  CHECK(found.d1 == Approx(d1 / double(of_a.points().size())).epsilon(1e-12));
  CHECK(found.d2 == Approx(d2 / double(of_a.points().size())).epsilon(1e-12));
}

TEST_CASE("D1 at samples sees another tessellation of one surface as near") {
  const Mesh coarse = plane(2, 0), fine = plane(50, 0);
  CHECK(of(fine, coarse).a_to_b.d1 > 0.01); // vertices of the fine one lie between those of the coarse one
  CHECK(of(fine, coarse, Points::samples).a_to_b.d1 < 1e-4);
  CHECK(of(fine, coarse, Points::samples).a_to_b.d2 == 0);
}

TEST_CASE("samples cover a surface by area, and not what has none") {
  Mesh mesh;
  mesh.positions = {0, 0, 0, 1, 0, 0, 0, 2, 0, 5, 0, 0, 8, 0, 0, 5, 2, 0, 9, 9, 9};
  mesh.faces = {0, 0, 1, 0, 1, 2, 1, 1, 1, 3, 4, 5}; // areas 0, 1, 0, 3
  const Surface surface(mesh);
  CHECK(surface.area() == Approx(4));
  CHECK(surface.points().size() == 6); // no face uses the seventh
  const std::vector<Sample> samples = surface.sample(10000);
  std::array<size_t, 4> on = {};
  Vec3 sum;
  for (const Sample &s : samples) {
    on[s.face]++;
    if (s.face == 3) sum += s.point;
    REQUIRE(surface.nearest(s.point).squared < 1e-30);
  }
  CHECK(on[0] + on[2] == 0);
  CHECK(std::abs(double(on[1]) - 2500) <= 1);
  const Vec3 centroid = sum * (1 / double(on[3]));
  CHECK(centroid.x == Approx(6).epsilon(1e-3));
  CHECK(centroid.y == Approx(2 / 3.).epsilon(3e-3));
}

TEST_CASE("a still mesh that swims has the error of motion of its noise") {
  constexpr double deviation = 0.001;
  const Mesh still = sphere(60, 1);
  const Mesh first = noisy(still, deviation, 7), second = noisy(still, deviation, 8);
  const Correspondence same = correspondence(still, first);
  CHECK(same.by_order);
  const MotionError error = motion_error(still, still, first, second, same);
  // Two independent noises an axis, three axes.
  CHECK(error.rms == Approx(deviation * std::sqrt(6)).epsilon(0.02));
  CHECK(error.motion == 0);
  CHECK(motion_error(first, second, first, second, same).rms == 0);
  CHECK(motion_error(first, second, still, still, same).motion ==
        Approx(deviation * std::sqrt(6)).epsilon(0.02));

  // Its vertices in another order are found by their places, and nothing else changes. The seam and the poles
  // of the sphere have several vertices in one place, which their own noise separates.
  const Mesh apart = noisy(still, deviation, 9);
  const Correspondence nearest = correspondence(apart, reversed(apart));
  CHECK(!nearest.by_order);
  CHECK(nearest.furthest == 0);
  const MotionError again = motion_error(still, still, reversed(first), reversed(second), nearest);
  CHECK(again.rms == Approx(error.rms).epsilon(1e-12));
  CHECK(again.max == error.max);
  CHECK(motion_error(first, second, reversed(first), reversed(second), nearest).rms < 1e-15);
}

TEST_CASE("quantiles of added histograms are those of all values") {
  fvv::synth::Random random(3);
  Histogram one, other;
  std::vector<double> values;
  for (int i = 0; i < 5000; i++) {
    values.push_back(std::pow(10, random.between(-9, 3)));
    (i % 3 ? one : other).add(values.back());
  }
  one.add(other);
  std::sort(values.begin(), values.end());
  for (const double share : {0.01, 0.5, 0.99, 1.0}) {
    const double truth = values[size_t(share * 5000 + 0.5) - 1], found = one.quantile(share);
    CHECK(found <= truth);
    CHECK(found >= truth * (1 - 1. / 1024));
  }
  CHECK(Histogram().quantile(0.99) == 0);
  Histogram zeros;
  zeros.add(0.0);
  CHECK(zeros.quantile(0.99) == 0);
}
