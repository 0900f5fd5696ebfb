// From the vertices of a source to those of the decoded mesh and back: what tracked sequences need.
#include "fvv_catch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "shapes.h"

namespace {

std::vector<uint32_t> mapped(const Shape &shape, Mesh &mesh, uint32_t least_faces = 0) {
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  options.min_component_faces = least_faces;
  const fvv_mesh_source source = shape.source();
  std::vector<uint32_t> vertices(source.vertex_count, 12345);
  REQUIRE(fvv_mesh_canonicalise_run(&source, nullptr, 0, &options, nullptr, &mesh, vertices.data(), nullptr,
                                    nullptr) == FVV_OK);
  return vertices;
}

// Every source vertex lies where its vertex lies, and every vertex represents at least one.
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
    for (size_t a = 0; a < 3; a++) CHECK(mesh.lattice[3 * size_t(vertices[v]) + a] == indices[3 * v + a]);
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
  // With the small piece its vertices are dropped, and later ones move up.
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

TEST_CASE("a run is welded and thinned by all its frames") {
  // Two vertices on one point that part later, one that never leaves its twin, a face that opens, one that
  // never has area.
  Shape shape = tetrahedron();
  const auto again = [&](size_t v) {
    shape.point(shape.positions[3 * v], shape.positions[3 * v + 1], shape.positions[3 * v + 2]);
  };
  again(0);            // 4: parts from 0
  again(1);            // 5: stays with 1
  shape.face(4, 1, 0); // opens
  shape.face(4, 5, 1); // 4 and the twins: never has area
  shape.face(0, 2, 3); // as the tetrahedron's own when 4 is not there
  const double origin[3] = {0, 0, 0};
  std::vector<int32_t> later(shape.positions.size());
  REQUIRE(fvv_lattice_from_metres(origin, 0.001, shape.positions.data(), 6, later.data(), nullptr) == FVV_OK);
  later[3 * 4] += 7;
  later[3 * 4 + 1] += 3;
  const int32_t *frames[] = {later.data()};
  const fvv_mesh_source source = shape.source();
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  fvv_mesh_report report = {};
  report.struct_size = sizeof report;
  Mesh alone, run;
  std::vector<uint32_t> vertices(6);
  REQUIRE(fvv_mesh_canonicalise(&source, &options, nullptr, &alone, &report, nullptr) == FVV_OK);
  CHECK((alone.vertex_count == 4 && report.welded_vertices == 2 && report.degenerate_faces == 2));
  REQUIRE(fvv_mesh_canonicalise_run(&source, frames, 1, &options, nullptr, &run, vertices.data(), &report,
                                    nullptr) == FVV_OK);
  CHECK((run.vertex_count == 5 && report.welded_vertices == 1 && report.degenerate_faces == 1));
  CHECK(vertices == std::vector<uint32_t>{0, 1, 2, 3, 4, 1});
  CHECK(run.face_count == alone.face_count + 1);
}

TEST_CASE("the order of decoded vertices is reported, also of those that lie on one point") {
  Shape folded = torus(20, 12); // all on a few points: as a key that opens later
  for (double &x : folded.positions) x = std::round(x * 10) / 10;
  std::vector<int32_t> apart(folded.positions.size());
  for (size_t i = 0; i < apart.size(); i++) apart[i] = int32_t(i * i % 1009);
  const int32_t *frames[] = {apart.data()};
  for (const Shape &shape : {torus(20, 12), charts(5), fin(), bow_tie(), sponge(6, 0.5, 1), folded}) {
    Mesh mesh;
    const fvv_mesh_source source = shape.source();
    fvv_mesh_options options;
    fvv_mesh_options_default(&options);
    const size_t later = shape.positions == folded.positions;
    REQUIRE(fvv_mesh_canonicalise_run(&source, frames, later, &options, nullptr, &mesh, nullptr, nullptr,
                                      nullptr) == FVV_OK);
    for (const auto &[profile, level] : {std::pair<uint8_t, int>{FVV_MESH_RAW, 0},
                                         {FVV_MESH_DRACO, 0},
                                         {FVV_MESH_DRACO, 7},
                                         {FVV_MESH_DRACO, 10},
                                         {FVV_MESH_FAST, 0}}) {
      Bytes payload;
      Mesh decoded;
      std::vector<uint32_t> vertices(3 * size_t(mesh.face_count));
      fvv_diagnostic diagnostic = {};
      const fvv_status status = fvv_mesh_encode_mapped(&mesh, profile, level, nullptr, &payload, &decoded,
                                                       vertices.data(), &diagnostic);
      INFO(shape.faces.size() << " corners, level " << level << ": " << diagnostic.message);
      REQUIRE(status == FVV_OK);
      REQUIRE(decoded.face_count == mesh.face_count);
      std::vector<bool> met(mesh.vertex_count);
      for (size_t v = 0; v < decoded.vertex_count; v++) {
        REQUIRE(vertices[v] < mesh.vertex_count);
        met[vertices[v]] = true;
        for (size_t a = 0; a < 3; a++)
          CHECK(decoded.lattice[3 * v + a] == mesh.lattice[3 * size_t(vertices[v]) + a]);
        for (size_t a = 0; mesh.texture && a < 2; a++)
          CHECK(decoded.texture[2 * v + a] == mesh.texture[2 * size_t(vertices[v]) + a]);
      }
      CHECK(std::find(met.begin(), met.end(), false) == met.end());
      // By numbers and not by places: the faces are those of the mesh.
      const auto faces = [](const fvv_mesh &m, const uint32_t *names) {
        std::vector<std::array<uint32_t, 3>> out;
        for (size_t f = 0; f < m.face_count; f++) {
          std::array<uint32_t, 3> face;
          for (size_t c = 0; c < 3; c++) face[c] = names ? names[m.faces[3 * f + c]] : m.faces[3 * f + c];
          std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
          out.push_back(face);
        }
        std::sort(out.begin(), out.end());
        return out;
      };
      CHECK(faces(decoded, vertices.data()) == faces(mesh, nullptr));
    }
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
