// The facing test against doubles and at the ends of the lattice, and what players interpolate.
#include "fvv/visibility.h"
#include "fvv_catch.h"
#include "mesh_of.h"
#include "visibility/scenes.h"

#include <cmath>
#include <limits>

namespace {

// The cosine between the normal of a face and the way from its centroid, in long doubles.
long double cosine(const fvv_mesh &mesh, size_t face, const Centre &centre) {
  const int32_t *p[3];
  for (size_t c = 0; c < 3; c++) p[c] = mesh.positions + 3 * size_t(mesh.faces[3 * face + c]);
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

TEST_CASE("the facing test agrees with cosines in floating point") {
  const auto mesh = canonical(torus(60, 30, 0.3));
  for (const Centre &centre : centres)
    for (const uint8_t threshold : {0, 20, 64, 200, 255}) {
      const States got = facing(*mesh, FVV_VISIBILITY_FACES, centre, threshold);
      size_t near = 0, passed = 0;
      for (size_t f = 0; f < got.size(); f++) {
        const long double above = cosine(*mesh, f, centre) - threshold / 256.0L;
        passed += got[f];
        // Vectors of 11 bits: directions are off by a thousandth.
        if (std::fabs(above) < 0.002L)
          near++;
        else
          CHECK((above > 0) == (got[f] == 1));
      }
      CHECK(near < got.size() / 50);
      CHECK((threshold > 200 || passed > got.size() / 20));
    }
}

TEST_CASE("a vertex faces when one of its faces does") {
  const auto mesh = canonical(torus(20, 12));
  for (const Centre &centre : centres) {
    const States faces = facing(*mesh, FVV_VISIBILITY_FACES, centre);
    States wanted(mesh->vertex_count);
    for (size_t i = 0; i < 3 * faces.size(); i++) wanted[mesh->faces[i]] |= faces[i / 3];
    CHECK(facing(*mesh, FVV_VISIBILITY_VERTICES, centre) == wanted);
  }
}

TEST_CASE("facing holds from end to end of the lattice") {
  const int32_t m = FVV_LATTICE_MAX;
  std::vector<int32_t> positions = {-m, -m, -m, m, -m, -m, -m, m, -m};
  std::vector<uint32_t> faces = {0, 1, 2, 0, 2, 1};
  const fvv_mesh mesh = mesh_of(positions, faces);
  CHECK(facing(mesh, FVV_VISIBILITY_FACES, {-m / 3, -m / 3, m}, 255) == States{1, 0});
  CHECK(facing(mesh, FVV_VISIBILITY_FACES, {m, m, m}, 64) == States{1, 0});
  CHECK(facing(mesh, FVV_VISIBILITY_FACES, {m, m, -m}, 0) == States{0, 0});
}

TEST_CASE("a cosine that equals the threshold does not pass") {
  // The centroid is (1, 1, 0), the normal (0, 0, 9).
  std::vector<int32_t> positions = {0, 0, 0, 3, 0, 0, 0, 3, 0};
  std::vector<uint32_t> faces = {0, 1, 2};
  const fvv_mesh mesh = mesh_of(positions, faces);
  CHECK(facing(mesh, FVV_VISIBILITY_FACES, {1, 1, 7}, 255) == States{1});
  CHECK(facing(mesh, FVV_VISIBILITY_FACES, {40, 1, 0}, 0) == States{0});
  CHECK(facing(mesh, FVV_VISIBILITY_FACES, {40, 1, 1}, 0) == States{1});
  CHECK(facing(mesh, FVV_VISIBILITY_FACES, {40, 1, -1}, 0) == States{0});
  // A normal of (9, 0, 9) and ways of (0, 1, 1) and (0, 20, 21): cosines of 1 / 2 and a little more.
  std::vector<int32_t> tilted = {0, 0, 0, 0, 3, 0, -3, 0, 3};
  const fvv_mesh slope = mesh_of(tilted, faces);
  CHECK(facing(slope, FVV_VISIBILITY_FACES, {-1, 101, 101}, 128) == States{0});
  CHECK(facing(slope, FVV_VISIBILITY_FACES, {-1, 101, 101}, 127) == States{1});
  CHECK(facing(slope, FVV_VISIBILITY_FACES, {-1, 101, 106}, 128) == States{1});
}

TEST_CASE("a face without area faces no camera") {
  std::vector<int32_t> positions = {0, 0, 0, 1, 1, 1, 2, 2, 2, 5, 0, 0};
  std::vector<uint32_t> faces = {0, 1, 2, 0, 1, 3};
  const fvv_mesh mesh = mesh_of(positions, faces);
  for (const Centre &centre : centres) CHECK(facing(mesh, FVV_VISIBILITY_FACES, centre, 0)[0] == 0);
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

// ---- What players interpolate: weights of the faces around a vertex, worked out by hand.

namespace {

// A fan about vertex 0 of four faces, and vertex 6 that no face uses.
std::vector<int32_t> positions(21);
std::vector<uint32_t> faces = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5};

std::vector<uint8_t> weights(uint8_t domain, const std::vector<uint8_t> &states) {
  const fvv_mesh mesh = mesh_of(positions, faces);
  std::vector<uint32_t> counts(14, 77);
  std::vector<uint8_t> out(7, 99);
  fvv_visibility_weights(&mesh, domain, states.data(),
                         domain == FVV_VISIBILITY_FACES ? counts.data() : nullptr, out.data());
  return out;
}

constexpr uint8_t backfacing = FVV_ELEMENT_BACKFACING, hidden = FVV_ELEMENT_HIDDEN, seen = FVV_ELEMENT_SEEN;
using Weights = std::vector<uint8_t>;

} // namespace

TEST_CASE("the weight of a vertex is that of the faces around it that have a bit") {
  CHECK(weights(FVV_VISIBILITY_FACES, {seen, seen, hidden, hidden}) ==
        Weights{128, 255, 255, 128, 0, 0, 127});
  CHECK(weights(FVV_VISIBILITY_FACES, {seen, hidden, hidden, hidden}) == Weights{64, 255, 128, 0, 0, 0, 127});
  CHECK(weights(FVV_VISIBILITY_FACES, {seen, seen, seen, hidden}) ==
        Weights{191, 255, 255, 255, 128, 0, 127});
}

TEST_CASE(
    "faces without a bit take what is seen around them, and nothing around is a little less than half") {
  CHECK(weights(FVV_VISIBILITY_FACES, {seen, backfacing, backfacing, backfacing}) ==
        Weights{255, 255, 255, 127, 127, 127, 127});
  CHECK(weights(FVV_VISIBILITY_FACES, {backfacing, backfacing, backfacing, backfacing}) == Weights(7, 127));
  CHECK(weights(FVV_VISIBILITY_FACES, {hidden, backfacing, backfacing, seen}) ==
        Weights{128, 0, 0, 127, 255, 255, 127});
}

TEST_CASE("coded weights are what they say, and a vertex without one is a little less than half") {
  CHECK(weights(FVV_VISIBILITY_WEIGHTS,
                {backfacing, hidden, seen, FVV_ELEMENT_HIDDEN_NEAR, FVV_ELEMENT_SEEN_NEAR,
                 FVV_ELEMENT_HIDDEN_NEARER, FVV_ELEMENT_SEEN_NEARER}) ==
        Weights{127, 0, 255, 85, 170, 113, 142});
}

TEST_CASE("vertices that have bits are seen or not") {
  CHECK(weights(FVV_VISIBILITY_VERTICES, {seen, backfacing, hidden, seen, backfacing, seen, hidden}) ==
        Weights{255, 0, 0, 255, 0, 255, 0});
}
