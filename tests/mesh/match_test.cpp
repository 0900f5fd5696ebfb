// From the vertices of a source to those of the decoded mesh and back: what tracked sequences need.
#include "fvv_catch.h"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "delta_shapes.h"

namespace {

std::vector<uint32_t> mapped(const Shape &shape, Mesh &mesh, uint32_t least_faces = 0) {
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  options.min_component_faces = least_faces;
  const fvv_mesh_source source = shape.source();
  std::vector<uint32_t> vertices(source.vertex_count, 12345);
  REQUIRE(fvv_mesh_canonicalise_mapped(&source, &options, nullptr, &mesh, vertices.data(), nullptr,
                                       nullptr) == FVV_OK);
  return vertices;
}

// Every source vertex lies where its vertex lies, and every vertex stands for one at least.
void check_map(const Shape &shape, const Mesh &mesh, const std::vector<uint32_t> &vertices) {
  std::vector<bool> stands(mesh.vertex_count);
  std::vector<int32_t> indices(shape.positions.size());
  const double origin[3] = {0, 0, 0};
  REQUIRE(fvv_lattice_from_metres(origin, 0.001, shape.positions.data(), shape.positions.size() / 3,
                                  indices.data(), nullptr) == FVV_OK);
  for (size_t v = 0; v < vertices.size(); v++) {
    if (vertices[v] == UINT32_MAX) continue;
    REQUIRE(vertices[v] < mesh.vertex_count);
    stands[vertices[v]] = true;
    for (size_t a = 0; a < 3; a++) CHECK(mesh.positions[3 * size_t(vertices[v]) + a] == indices[3 * v + a]);
  }
  CHECK(std::find(stands.begin(), stands.end(), false) == stands.end());
}

} // namespace

TEST_CASE("the map names the vertex of every source vertex") {
  for (const Shape &shape : {torus(20, 12), charts(5), sphere(12, 8)}) {
    Mesh mesh;
    const auto vertices = mapped(shape, mesh);
    check_map(shape, mesh, vertices);
    CHECK(std::count(vertices.begin(), vertices.end(), UINT32_MAX) == 0);
  }
}

TEST_CASE("welded vertices share one, dropped ones have none") {
  Shape shape = tetrahedron();
  shape.point(9, 9, 9);                                                           // 4: no face
  shape.point(shape.positions[0], shape.positions[1], shape.positions[2] + 1e-5); // 5: as 0
  shape.face(5, 1, 2);
  Mesh mesh;
  const auto vertices = mapped(shape, mesh);
  check_map(shape, mesh, vertices);
  CHECK(vertices == std::vector<uint32_t>{0, 1, 2, 3, UINT32_MAX, 0});
  // With the speck its vertices go, and those behind move up.
  Shape two = tetrahedron();
  for (size_t i = 0; i < 12; i++) two.positions[i] += 50;
  for (const double x : torus(20, 12).positions) two.positions.push_back(x);
  for (const uint32_t i : torus(20, 12).faces) two.faces.push_back(i + 4);
  Mesh left;
  const auto kept = mapped(two, left, 10);
  check_map(two, left, kept);
  CHECK(std::count(kept.begin(), kept.end(), UINT32_MAX) == 4);
  CHECK(kept[4] == 0);
}

TEST_CASE("decoded vertices are found in the mesh that was encoded") {
  for (const Shape &shape : {torus(20, 12), charts(5), fin(), bow_tie(), sponge(6, 0.5, 1)}) {
    const auto mesh = canonical(shape);
    Mesh decoded;
    REQUIRE(decode(encoded(*mesh, FVV_MESH_DRACO, 7), &decoded, nullptr) == FVV_OK);
    std::vector<uint32_t> vertices(decoded.vertex_count);
    REQUIRE(fvv_mesh_match(&decoded, mesh.get(), nullptr, vertices.data(), nullptr) == FVV_OK);
    for (size_t v = 0; v < vertices.size(); v++) {
      for (size_t a = 0; a < 3; a++)
        CHECK(decoded.positions[3 * v + a] == mesh->positions[3 * size_t(vertices[v]) + a]);
      for (size_t a = 0; mesh->texture && a < 2; a++)
        CHECK(decoded.texture[2 * v + a] == mesh->texture[2 * size_t(vertices[v]) + a]);
    }
    decoded.positions[1]++;
    fvv_diagnostic diagnostic = {};
    CHECK(fvv_mesh_match(&decoded, mesh.get(), nullptr, vertices.data(), &diagnostic) == FVV_ERROR_INPUT);
    CHECK(std::string(diagnostic.message) == "decoded vertex 0 is none of those that were encoded");
  }
}

TEST_CASE("metres go to the nearest lattice point or are refused") {
  const double origin[3] = {1, 2, 3};
  const double metres[6] = {1.0026, 2, 2.9974, 1, 2.0015, 3};
  int32_t indices[6];
  fvv_diagnostic diagnostic = {};
  REQUIRE(fvv_lattice_from_metres(origin, 0.001, metres, 2, indices, &diagnostic) == FVV_OK);
  CHECK((indices[0] == 3 && indices[1] == 0 && indices[2] == -3 && indices[3] == 0 && indices[5] == 0));
  const double far[3] = {1, 2, 1e9}, none[3] = {1, std::numeric_limits<double>::quiet_NaN(), 3};
  CHECK(fvv_lattice_from_metres(origin, 0.001, far, 1, indices, &diagnostic) == FVV_ERROR_INPUT);
  CHECK(diagnostic.issue == FVV_ISSUE_MESH_LATTICE);
  CHECK(fvv_lattice_from_metres(origin, 0.001, none, 1, indices, &diagnostic) == FVV_ERROR_INPUT);
}
