// The quick check of decimated surfaces against all faces, one by one.
#include "decimate_fixture.h"

#include "fvv_geometry/pieces.h"
#include "geometry/src/simplify.h"
#include "geometry/src/trial.h"

#include <algorithm>

using namespace shapes;
using decimate::Outliers;
using fvv::render::Vec3;

namespace {

constexpr double limit = 4; // millimetres, as pixels are here

Vec3 at(const Mesh &mesh, uint32_t v) {
  return {mesh.positions[3 * size_t(v)], mesh.positions[3 * size_t(v) + 1],
          mesh.positions[3 * size_t(v) + 2]};
}

double distance_to(const Mesh &mesh, Vec3 from) {
  double least = INFINITY;
  for (size_t f = 0; f < mesh.face_count(); f++) {
    const uint32_t *c = &mesh.faces[3 * f];
    const auto hit = fvv::render::closest_on_triangle(from, {at(mesh, c[0]), at(mesh, c[1]), at(mesh, c[2])});
    least = std::min(least, std::sqrt(hit.squared));
  }
  return least;
}

// A sheet with a ridge and a valley: the one is cut off, the other bridged.
Mesh source() {
  return sheet(24, false, [](double x, double y) {
    return 0.02 * std::exp(-200 * (x - 0.3) * (x - 0.3)) - 0.03 * std::exp(-300 * (y - 0.6) * (y - 0.6));
  });
}

// 40 faces of a row are locked, so that the result differs in places.
std::vector<uint32_t> thinned(const Mesh &mesh, size_t locked_row) {
  std::vector<bool> locked(mesh.face_count());
  for (size_t f = 0; f < 40; f++) locked[locked_row * 48 + f] = true;
  const decimate::Simplifier simplifier(mesh, decimate::first_alike(mesh, true));
  return simplifier.simplify({0.02, 0}, locked);
}

template <class T> std::vector<T> unique(std::vector<T> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

} // namespace

TEST_CASE("a trial finds vertices that were cut off and sides that bridge a hollow, and remembers right") {
  const Mesh mesh = source();
  const auto cameras = millimetre_pixels();
  const decimate::Reference reference(mesh, cameras);
  decimate::Trial trial(reference, limit);
  size_t shared = 0;
  std::vector<std::vector<uint32_t>> before;
  for (const size_t row : {size_t(2), size_t(2), size_t(14), size_t(20)}) {
    std::vector<uint32_t> vertices;
    const Mesh thin = decimate::compact(mesh, thinned(mesh, row), vertices);
    const Outliers found = trial.look(thin, vertices, fvv::compare::Faces(thin));
    std::vector<uint32_t> off, bridging;
    for (uint32_t v = 0; v < mesh.vertex_count(); v++)
      if (distance_to(thin, at(mesh, v)) * 1000 > limit) off.push_back(v);
    size_t below = 0;
    for (uint32_t f = 0; f < thin.face_count(); f++)
      for (size_t k = 0; k < 3; k++) {
        const uint32_t a = thin.faces[3 * size_t(f) + k], b = thin.faces[3 * size_t(f) + (k + 1) % 3];
        const Vec3 middle = (at(thin, a) + at(thin, b)) * 0.5;
        if (a < b && distance_to(mesh, middle) * 1000 > limit) bridging.push_back(f), below++;
      }
    CHECK(!off.empty());
    CHECK(!bridging.empty());
    // Vertices near to a bridging side count as well.
    const std::vector<uint32_t> vertices_found = unique(found.vertices);
    CHECK(std::includes(vertices_found.begin(), vertices_found.end(), off.begin(), off.end()));
    CHECK(vertices_found.size() <= off.size() + 3 * below);
    CHECK(unique(found.faces) == unique(bridging));
    double area = 0;
    for (const uint32_t v : off) area += reference.area(v);
    CHECK(found.area == Approx(area));
    std::vector<std::vector<uint32_t>> faces;
    for (size_t f = 0; f < thin.face_count(); f++)
      faces.push_back(
          {vertices[thin.faces[3 * f]], vertices[thin.faces[3 * f + 1]], vertices[thin.faces[3 * f + 2]]});
    for (const auto &face : faces) shared += std::count(before.begin(), before.end(), face) > 0;
    before.swap(faces);
  }
  CHECK(shared > 50); // or there was nothing to remember
}

TEST_CASE("the target error of several frames is the least, and one that has room needs no search") {
  const Mesh ball = sphere(0.5, 5), bumpy = sheet(40, false, [](double x, double y) {
                                      return 0.01 * std::sin(25 * x) * std::sin(25 * y);
                                    });
  const auto cameras = millimetre_pixels();
  const double of_ball = decimate::find_target_error(ball, cameras, budget(1)),
               of_bumpy = decimate::find_target_error(bumpy, cameras, budget(1));
  CHECK(of_ball > 0);
  CHECK(of_bumpy > 0);
  CHECK(decimate::find_target_error(ball, cameras, budget(1), of_ball / 2) == of_ball / 2);
  CHECK(decimate::find_target_error(ball, cameras, budget(1), of_ball * 3) <= of_ball * 1.2);
  const double least = std::min(of_ball, of_bumpy);
  CHECK(decimate::find_target_error(bumpy, cameras, budget(1), of_ball) == Approx(least).epsilon(0.15));
}
