// Computed normals: against analytic ones, against sums in other arithmetic, across seams, and where there
// are none.
#include "fvv_catch.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <string>

#include "memory.h"
#include "shapes.h"

namespace {

using Vector = std::array<double, 3>;

std::vector<float> normals_of(const fvv_mesh &mesh) {
  std::vector<float> normals(3 * size_t(mesh.vertex_count));
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_mesh_normals(&mesh, nullptr, normals.data(), &diagnostic);
  INFO(diagnostic.message);
  REQUIRE(status == FVV_OK);
  return normals;
}

Vector point_of(const fvv_mesh &mesh, size_t v) {
  return {double(mesh.positions[3 * v]), double(mesh.positions[3 * v + 1]),
          double(mesh.positions[3 * v + 2])};
}

double degrees_between(const float *n, const Vector &other) {
  double dot = 0, length = 0;
  for (size_t k = 0; k < 3; k++) {
    dot += double(n[k]) * other[k];
    length += other[k] * other[k];
  }
  return std::acos(std::clamp(dot / std::sqrt(length), -1.0, 1.0)) * 57.29577951308232;
}

// For each point the sum of area vectors, by Newell's formula in long double: sums of y z and so on over the
// edges, no differences from a corner.
std::map<Vector, std::array<long double, 3>> newell(const fvv_mesh &mesh) {
  std::map<Vector, std::array<long double, 3>> sums;
  for (size_t f = 0; f < mesh.face_count; f++) {
    std::array<long double, 3> area = {};
    const uint32_t *face = mesh.faces + 3 * f;
    for (size_t c = 0; c < 3; c++) {
      const int32_t *p = mesh.positions + 3 * size_t(face[c]),
                    *q = mesh.positions + 3 * size_t(face[(c + 1) % 3]);
      for (size_t k = 0; k < 3; k++)
        area[k] += (static_cast<long double>(p[(k + 1) % 3]) - q[(k + 1) % 3]) *
                   (static_cast<long double>(p[(k + 2) % 3]) + q[(k + 2) % 3]);
    }
    for (size_t c = 0; c < 3; c++)
      for (size_t k = 0; k < 3; k++) sums[point_of(mesh, face[c])][k] += area[k];
  }
  return sums;
}

// A mesh as it is, past the canonicaliser. Borrows.
fvv_mesh bare(std::vector<int32_t> &positions, std::vector<uint32_t> &faces) {
  fvv_mesh mesh = {};
  mesh.positions = positions.data();
  mesh.faces = faces.data();
  mesh.vertex_count = uint32_t(positions.size() / 3);
  mesh.face_count = uint32_t(faces.size() / 3);
  return mesh;
}

} // namespace

TEST_CASE("a normal is the sum of the faces around by area, to the last bit") {
  const std::vector<std::pair<const char *, Shape>> shapes = {{"tetrahedron", tetrahedron()},
                                                              {"torus", torus(40, 20, 0.5)},
                                                              {"sphere", sphere(30, 20)},
                                                              {"bow-tie", bow_tie()},
                                                              {"fin", fin()},
                                                              {"handles", sponge(8, 0.4, 3)},
                                                              {"charts", charts(5)},
                                                              {"holes", ragged(60, 20, 3)}};
  for (const auto &[name, shape] : shapes) {
    INFO(name);
    const auto mesh = canonical(shape);
    const std::vector<float> normals = normals_of(*mesh);
    const auto sums = newell(*mesh);
    size_t wrong = 0;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
      const auto &sum = sums.at(point_of(*mesh, v));
      const double x = double(sum[0]), y = double(sum[1]), z = double(sum[2]);
      const double length = std::sqrt(x * x + y * y + z * z);
      for (size_t k = 0; k < 3; k++)
        wrong += normals[3 * v + k] != (length > 0 ? float(double(sum[k]) / length) : 0.0f);
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("computed normals of round shapes are near the analytic ones") {
  const auto ball = canonical(sphere(60, 40));
  const std::vector<float> normals = normals_of(*ball);
  const auto low = std::minmax_element(ball->positions, ball->positions + 3 * ball->vertex_count);
  const double centre = (double(*low.first) + *low.second) / 2;
  double worst = 0;
  for (size_t v = 0; v < ball->vertex_count; v++) {
    Vector out = point_of(*ball, v);
    for (double &x : out) x -= centre;
    worst = std::max(worst, degrees_between(&normals[3 * v], out));
  }
  CHECK(worst < 3);
  CHECK(worst > 0.01); // not handed through from somewhere
}

TEST_CASE("normals do not break at the seams of an atlas") {
  Shape shape = charts(6);
  const auto with = canonical(shape);
  shape.texture.clear();
  const auto without = canonical(shape);
  REQUIRE(with->vertex_count > without->vertex_count);
  std::map<Vector, std::array<float, 3>> expected;
  const std::vector<float> plain = normals_of(*without), seamed = normals_of(*with);
  for (size_t v = 0; v < without->vertex_count; v++)
    expected[point_of(*without, v)] = {plain[3 * v], plain[3 * v + 1], plain[3 * v + 2]};
  for (size_t v = 0; v < with->vertex_count; v++) {
    const std::array<float, 3> found = {seamed[3 * v], seamed[3 * v + 1], seamed[3 * v + 2]};
    CHECK(found == expected.at(point_of(*with, v)));
  }
}

TEST_CASE("the order of faces makes no difference to normals") {
  const auto mesh = canonical(torus(50, 30, 0.7));
  const std::vector<float> before = normals_of(*mesh);
  std::vector<std::array<uint32_t, 3>> faces(mesh->face_count);
  memcpy(faces.data(), mesh->faces, faces.size() * 12);
  std::reverse(faces.begin(), faces.end());
  for (auto &face : faces) std::rotate(face.begin(), face.begin() + 1, face.end());
  memcpy(mesh->faces, faces.data(), faces.size() * 12);
  const bool same = normals_of(*mesh) == before;
  CHECK(same);
}

TEST_CASE("where areas cancel or there are none the normal is zero") {
  // Two sides of one leaf, and a face without area next to it.
  std::vector<int32_t> positions = {0, 0, 0, 9, 0, 0, 0, 9, 0, 20, 0, 0, 30, 0, 0, 40, 0, 0};
  std::vector<uint32_t> faces = {0, 1, 2, 0, 2, 1, 3, 4, 5};
  const std::vector<float> normals = normals_of(bare(positions, faces));
  CHECK(normals == std::vector<float>(18, 0.0f));
}

TEST_CASE("normals at the lattice's bounds are finite and right") {
  const int32_t far = FVV_LATTICE_MAX;
  std::vector<int32_t> positions = {-far, -far, -far, far, -far, -far, -far, far, far};
  std::vector<uint32_t> faces = {0, 1, 2};
  const std::vector<float> normals = normals_of(bare(positions, faces));
  for (size_t v = 0; v < 3; v++) {
    CHECK(normals[3 * v] == 0);
    CHECK(normals[3 * v + 1] == Approx(-std::sqrt(0.5)));
    CHECK(normals[3 * v + 2] == Approx(std::sqrt(0.5)));
  }
}

TEST_CASE("normals of a mesh that breaks the rules are refused") {
  std::vector<int32_t> positions = {0, 0, 0, 9, 0, 0, 0, 9, 0};
  std::vector<uint32_t> faces = {0, 1, 3};
  float normals[9];
  fvv_diagnostic diagnostic = {};
  fvv_mesh mesh = bare(positions, faces);
  CHECK(fvv_mesh_normals(&mesh, nullptr, normals, &diagnostic) == FVV_ERROR_INPUT);
  CHECK(diagnostic.issue == FVV_ISSUE_MESH_INDEX);
  mesh.vertex_count = 0;
  CHECK(fvv_mesh_normals(&mesh, nullptr, normals, &diagnostic) == FVV_ERROR_INPUT);
}

TEST_CASE("normals need memory and say when there is none") {
  const auto mesh = canonical(torus(20, 10));
  std::vector<float> normals(3 * size_t(mesh->vertex_count));
  const fvv_allocator allocator = memory::allocator();
  fvv_diagnostic diagnostic = {};
  int64_t allowed = 0;
  for (;; allowed++) {
    memory::reset(allowed);
    const size_t live = memory::state.live;
    const fvv_status status = fvv_mesh_normals(mesh.get(), &allocator, normals.data(), &diagnostic);
    const size_t left = memory::state.live;
    memory::reset();
    CHECK(left == live);
    if (status == FVV_OK) break;
    CHECK(status == FVV_ERROR_MEMORY);
  }
  CHECK(allowed >= 4);
}
