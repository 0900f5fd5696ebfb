// The facing test against doubles and at the ends of the lattice, and what players interpolate.
#include "fvv/visibility.h"
#include "fvv_catch.h"
#include "mesh_of.h"
#include "visibility/scenes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace {

// The cosine between the normal of a face and the way from its centroid, in long doubles.
long double cosine(const fvv_mesh &mesh, size_t face, const Centre &centre) {
  const int32_t *p[3];
  for (size_t c = 0; c < 3; c++) p[c] = mesh.lattice + 3 * size_t(mesh.faces[3 * face + c]);
  std::array<long double, 3> u, v, way;
  for (size_t a = 0; a < 3; a++) {
    u[a] = (long double)p[1][a] - p[0][a];
    v[a] = (long double)p[2][a] - p[0][a];
    way[a] = centre[a] - ((long double)p[0][a] + p[1][a] + p[2][a]) / 3;
  }
  const std::array<long double, 3> n = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                        u[0] * v[1] - u[1] * v[0]};
  const auto dot = [](const auto &a, const auto &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  const long double lengths = std::sqrt(dot(n, n)) * std::sqrt(dot(way, way));
  return lengths > 0 ? dot(n, way) / lengths : 0;
}

} // namespace

TEST_CASE("a vertex faces when one of its faces does, which agrees with cosines in floating point") {
  const auto mesh = canonical(torus(60, 30, 0.3));
  for (const Centre &centre : centres)
    for (const uint8_t threshold : {0, 20, 64, 200, 255}) {
      const States got = facing(*mesh, centre, threshold);
      std::vector<long double> largest(got.size(), -2);
      for (size_t i = 0; i < 3 * size_t(mesh->face_count); i++)
        largest[mesh->faces[i]] = std::max(largest[mesh->faces[i]], cosine(*mesh, i / 3, centre));
      size_t near = 0, passed = 0;
      for (size_t v = 0; v < got.size(); v++) {
        const long double above = largest[v] - threshold / 256.0L;
        passed += got[v];
        // Vectors of 11 bits: directions are off by a thousandth.
        if (std::fabs(above) < 0.002L)
          near++;
        else
          CHECK((above > 0) == (got[v] == 1));
      }
      CHECK(near < got.size() / 30);
      CHECK((threshold > 200 || passed > got.size() / 20));
    }
}

namespace {

// Whether the one face of a mesh faces, by its corners.
bool faces(std::vector<int32_t> positions, const Centre &centre, uint8_t threshold, bool turned = false) {
  std::vector<uint32_t> corners = {0, 1, 2};
  if (turned) corners = {0, 2, 1};
  const States got = facing(mesh_of(positions, corners), centre, threshold);
  CHECK((got == States(3, got[0])));
  return got[0] == 1;
}

} // namespace

TEST_CASE("facing holds from end to end of the lattice") {
  const int32_t m = FVV_LATTICE_MAX;
  const std::vector<int32_t> positions = {-m, -m, -m, m, -m, -m, -m, m, -m};
  for (const bool turned : {false, true}) {
    CHECK(faces(positions, {-m / 3, -m / 3, m}, 255, turned) == !turned);
    CHECK(faces(positions, {m, m, m}, 64, turned) == !turned);
    CHECK(!faces(positions, {m, m, -m}, 0, turned));
  }
}

TEST_CASE("a cosine that equals the threshold does not pass") {
  // The centroid is (1, 1, 0), the normal (0, 0, 9).
  const std::vector<int32_t> flat = {0, 0, 0, 3, 0, 0, 0, 3, 0};
  CHECK(faces(flat, {1, 1, 7}, 255));
  CHECK(!faces(flat, {40, 1, 0}, 0));
  CHECK(faces(flat, {40, 1, 1}, 0));
  CHECK(!faces(flat, {40, 1, -1}, 0));
  // A normal of (9, 0, 9) and ways of (0, 1, 1) and (0, 20, 21): cosines of 1 / 2 and a little more.
  const std::vector<int32_t> tilted = {0, 0, 0, 0, 3, 0, -3, 0, 3};
  CHECK(!faces(tilted, {-1, 101, 101}, 128));
  CHECK(faces(tilted, {-1, 101, 101}, 127));
  CHECK(faces(tilted, {-1, 101, 106}, 128));
}

TEST_CASE("a face without area faces no camera") {
  for (const Centre &centre : centres) CHECK(!faces({0, 0, 0, 1, 1, 1, 2, 2, 2}, centre, 0));
}

TEST_CASE("6003: a camera lies within the lattice, at its nearest point") {
  fvv_camera camera = {};
  camera.id = 4;
  for (const int i : {0, 4, 8}) camera.rotation[i] = 1;
  const double t[3] = {-1.0125, 2.0375, -0.0005};
  for (int a = 0; a < 3; a++) camera.translation[a] = t[a];
  fvv_scene scene = {{1, 25}, 1, {0, 0, 1}, 0.025, FVV_UP_Y, 0};
  Centre centre = {};
  fvv_diagnostic d = {};
  REQUIRE(fvv_visibility_centre(&camera, &scene, centre.data(), &d) == FVV_OK);
  CHECK(std::abs(centre[0] * 0.025 - 1.0125) <= 0.0126);
  CHECK(std::abs(centre[1] * 0.025 + 2.0375) <= 0.0126);
  CHECK(centre[2] == -40);
  scene.lattice_step = 1e-12;
  CHECK(fvv_visibility_centre(&camera, &scene, centre.data(), &d) == FVV_ERROR_INPUT);
  CHECK(d.issue == FVV_ISSUE_VISIBILITY_CAMERA);
  CHECK(std::string(d.message).find("camera 4") != std::string::npos);
}

TEST_CASE("weights by states, and a vertex without one is a little less than half") {
  const States states = {FVV_VERTEX_BACKFACING,  FVV_VERTEX_HIDDEN,    FVV_VERTEX_SEEN,
                         FVV_VERTEX_HIDDEN_NEAR, FVV_VERTEX_SEEN_NEAR, FVV_VERTEX_HIDDEN_NEARER,
                         FVV_VERTEX_SEEN_NEARER};
  States weights(states.size(), 99);
  fvv_visibility_weights(states.data(), states.size(), weights.data());
  CHECK(weights == States{127, 0, 255, 85, 170, 113, 142});
  for (size_t i = 0; i < states.size(); i++) CHECK(FVV_VERTEX_IS_SEEN(states[i]) == (weights[i] > 127));
}
