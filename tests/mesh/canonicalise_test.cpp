// Metres to the lattice and back, and the canonicaliser: what it mends and reports, what it refuses.
#include "fvv/mesh.h"
#include "fvv_catch.h"
#include "memory.h"
#include "shapes.h"

#include <cfenv>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

extern "C" {
#include "mesh/mesh.h"
}

TEST_CASE("quantisation takes the nearest index, ties the even one, in every rounding mode") {
  const struct {
    double x;
    int32_t index;
  } cases[] = {{0, 0},
               {0.49, 0},
               {0.5, 0},
               {0.51, 1},
               {1.5, 2},
               {2.5, 2},
               {3.5, 4},
               {-0.49, 0},
               {-0.5, 0},
               {-0.51, -1},
               {-1.5, -2},
               {-2.5, -2},
               {-3.5, -4},
               {268435456, FVV_LATTICE_MAX},
               {268435456.5, FVV_LATTICE_MAX},
               {-268435456.5, -FVV_LATTICE_MAX},
               {268435455.5, FVV_LATTICE_MAX}};
  for (const int mode : {FE_TONEAREST, FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    fesetround(mode);
    for (const auto &c : cases) {
      int32_t index = 77;
      const int inside = fvv_lattice_quantise(c.x, 0, 1, &index);
      CHECK(inside == 1);
      CHECK(index == c.index);
    }
  }
  fesetround(FE_TONEAREST);
}

TEST_CASE("quantisation refuses what lies outside the lattice") {
  int32_t index = 77;
  for (const double x : {268435456.51, -268435456.51, 268435457.0, 1e300, -1e300}) {
    CHECK_FALSE(fvv_lattice_quantise(x, 0, 1, &index));
  }
  CHECK_FALSE(fvv_lattice_quantise(1.7e308, -1.7e308, 1e-300, &index));
  CHECK(index == 77);
}

TEST_CASE("indices go to metres and back without change, off by at most half a step") {
  const double origin[3] = {-1.25, 0.1, 1e4}, step = 0.0007;
  for (const int32_t i : {-FVV_LATTICE_MAX, -1000003, -1, 0, 1, 12345, FVV_LATTICE_MAX}) {
    const int32_t index[3] = {i, -i, i / 2};
    double metres[3];
    fvv_lattice_to_metres(origin, step, index, metres);
    for (int k = 0; k < 3; k++) {
      int32_t back = 0;
      REQUIRE(fvv_lattice_quantise(metres[k], origin[k], step, &back));
      CHECK(back == index[k]);
      REQUIRE(fvv_lattice_quantise(metres[k] + 0.49 * step, origin[k], step, &back));
      CHECK(back == index[k]);
    }
  }
}

TEST_CASE("dequantisation rounds the product before the sum") {
  // 0.1 * 3 rounds up to 0.30000000000000004; fused with -0.3 the unrounded product gives another difference.
  const double origin[3] = {-0.3, 0, 0}, step = 0.1;
  const int32_t index[3] = {3, 3, 0};
  double metres[3];
  fvv_lattice_to_metres(origin, step, index, metres);
  CHECK(metres[0] == 0.1 * 3 - 0.3);
  CHECK(metres[0] != std::fma(0.1, 3, -0.3));
  CHECK(metres[1] == 0.30000000000000004);
  float floats[3];
  fvv_lattice_to_floats(origin, step, index, 1, floats);
  for (int k = 0; k < 3; k++) CHECK(floats[k] == float(metres[k]));
}

// ---- The canonicaliser: what it mends and reports, what it refuses.

namespace {

fvv_mesh_report empty_report() {
  fvv_mesh_report report = {};
  report.struct_size = sizeof report;
  return report;
}

fvv_mesh_options options(double step = 0.001) {
  fvv_mesh_options o;
  fvv_mesh_options_default(&o);
  o.lattice_step = step;
  return o;
}

std::string refusal(const Shape &shape, const fvv_mesh_options &o, fvv_status expected = FVV_ERROR_INPUT) {
  const fvv_mesh_source source = shape.source();
  Mesh mesh;
  fvv_diagnostic diagnostic = {};
  CHECK(fvv_mesh_canonicalise(&source, &o, nullptr, &mesh, nullptr, &diagnostic) == expected);
  CHECK(diagnostic.status == expected);
  CHECK(mesh.lattice == nullptr);
  CHECK(mesh.faces == nullptr);
  CHECK(mesh.vertex_count == 0);
  return diagnostic.message;
}

std::vector<uint32_t> faces_of(const fvv_mesh &mesh) {
  return {mesh.faces, mesh.faces + 3 * mesh.face_count};
}

void check_report(const fvv_mesh_report &report, std::vector<uint32_t> expected) {
  const std::vector<uint32_t> found = {
      report.welded_vertices,       report.degenerate_faces,   report.duplicate_faces,
      report.unreferenced_vertices, report.flipped_faces,      report.nonmanifold_edges,
      report.boundary_edges,        report.dropped_components, report.dropped_component_faces};
  CHECK(found == expected);
}

} // namespace

TEST_CASE("a clean mesh goes through as it was") {
  fvv_mesh_report report = empty_report();
  const Shape shape = tetrahedron(0.1);
  const auto mesh = canonical(shape, 0.001, &report);
  check_report(report, {0, 0, 0, 0, 0, 0, 0, 0, 0});
  CHECK(report.max_error < 1e-16);
  CHECK(faces_of(*mesh) == shape.faces);
  CHECK(std::vector<int32_t>(mesh->lattice, mesh->lattice + 12) ==
        std::vector<int32_t>{0, 0, 0, 100, 0, 0, 0, 100, 0, 0, 0, 100});
}

TEST_CASE("vertices on the same lattice point are welded, the first one stays") {
  Shape shape = tetrahedron(0.1);
  shape.point(0.1004, 0.0004, -0.0004); // point 1
  shape.faces[9] = 4;                   // face 3: 4 2 3
  fvv_mesh_report report = empty_report();
  const auto mesh = canonical(shape, 0.001, &report);
  check_report(report, {1, 0, 0, 0, 0, 0, 0, 0, 0});
  CHECK(report.max_error == Approx(0.0004).epsilon(1e-9));
  CHECK(mesh->vertex_count == 4);
  CHECK(faces_of(*mesh) == tetrahedron().faces);
}

TEST_CASE("degenerate and duplicate faces and unused vertices are dropped") {
  Shape shape = tetrahedron(0.1);
  shape.point(0.05, 0.05, 0); // 4: between 1 and 2
  shape.point(7, 7, 7);       // 5: unused
  shape.face(1, 1, 2);        // two corners the same
  shape.face(1, 4, 2);        // zero area
  shape.face(2, 1, 0);        // face 0, another corner first
  shape.face(0, 1, 2);        // face 0, the other winding
  fvv_mesh_report report = empty_report();
  const auto mesh = canonical(shape, 0.001, &report);
  check_report(report, {0, 2, 2, 2, 0, 0, 0, 0, 0});
  CHECK(mesh->vertex_count == 4);
  CHECK(faces_of(*mesh) == tetrahedron().faces);
}

TEST_CASE("zero area is exact at the lattice's bounds") {
  Shape shape;
  const double m = FVV_LATTICE_MAX;
  shape.point(-m, -m, -m);
  shape.point(m, m, m);
  shape.point(0, 0, 0);
  shape.point(0, 0, 1);
  shape.face(0, 1, 2);
  shape.face(0, 1, 3);
  fvv_mesh_report report = empty_report();
  const auto mesh = canonical(shape, 1, &report);
  CHECK(report.degenerate_faces == 1);
  CHECK(faces_of(*mesh) == std::vector<uint32_t>{0, 1, 2});
  CHECK(mesh->lattice[8] == 1);
}

TEST_CASE("the smaller part of a component is turned") {
  const Shape whole = sphere(8, 6);
  Shape shape = whole;
  for (const size_t f : {3u, 17u, 40u}) std::swap(shape.faces[3 * f + 1], shape.faces[3 * f + 2]);
  fvv_mesh_report report = empty_report();
  const auto mesh = canonical(shape, 0.001, &report);
  check_report(report, {0, 0, 0, 0, 3, 0, 0, 0, 0});
  CHECK(faces_of(*mesh) == whole.faces);

  // Of the lowest face's side there are few: the rest stays.
  shape = whole;
  for (const size_t f : {0u, 1u}) std::swap(shape.faces[3 * f + 1], shape.faces[3 * f + 2]);
  const auto again = canonical(shape, 0.001, &report);
  CHECK(report.flipped_faces == 2);
  CHECK(faces_of(*again) == whole.faces);

  // On a tie the lowest face stays.
  Shape pair;
  pair.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  pair.faces = {0, 1, 2, 1, 2, 3};
  const auto tied = canonical(pair, 0.001, &report);
  check_report(report, {0, 0, 0, 0, 1, 0, 4, 0, 0});
  CHECK(faces_of(*tied) == std::vector<uint32_t>{0, 1, 2, 1, 3, 2});

  fvv_mesh_options o = options();
  o.keep_winding = 1;
  const fvv_mesh_source source = pair.source();
  Mesh kept;
  REQUIRE(fvv_mesh_canonicalise(&source, &o, nullptr, &kept, &report, nullptr) == FVV_OK);
  CHECK(report.flipped_faces == 0);
  CHECK(faces_of(kept) == pair.faces);
}

TEST_CASE("a Moebius strip is no failure") {
  Shape shape;
  const uint32_t n = 12;
  for (uint32_t i = 0; i < n; i++) {
    const double a = 6.283185307179586 * i / n;
    for (const double t : {-0.2, 0.2})
      shape.point((1 + t * std::cos(a / 2)) * std::cos(a), (1 + t * std::cos(a / 2)) * std::sin(a),
                  t * std::sin(a / 2));
  }
  for (uint32_t i = 0; i < n; i++) {
    const uint32_t a = 2 * i, b = 2 * i + 1;
    const uint32_t c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? a + 3 : 0;
    shape.face(a, c, b);
    shape.face(c, d, b);
  }
  fvv_mesh_report report = empty_report();
  const auto mesh = canonical(shape, 0.001, &report);
  CHECK(report.boundary_edges == 2 * n);
  CHECK(mesh->face_count == 2 * n);
  // Turned once, it stays: all neighbours agree but those at one seam.
  const fvv_mesh_options o = options(1);
  Shape again;
  again.positions.assign(mesh->lattice, mesh->lattice + 3 * mesh->vertex_count);
  again.faces = faces_of(*mesh);
  const fvv_mesh_source source = again.source();
  Mesh same;
  REQUIRE(fvv_mesh_canonicalise(&source, &o, nullptr, &same, &report, nullptr) == FVV_OK);
  CHECK(report.flipped_faces == 0);
  CHECK(faces_of(same) == again.faces);
}

TEST_CASE("edges of one face and of more than two are counted") {
  fvv_mesh_report report = empty_report();
  (void)canonical(fin(), 0.001, &report);
  check_report(report, {0, 0, 0, 0, 0, 1, 6, 0, 0});
  (void)canonical(bow_tie(), 0.001, &report);
  check_report(report, {1, 0, 0, 0, 0, 0, 0, 0, 0});
  (void)canonical(grid(5), 0.001, &report);
  check_report(report, {0, 0, 0, 0, 0, 0, 16, 0, 0});

  Shape four = fin(); // a fourth face on the same edge is still one edge
  four.point(1, 1, 0.5);
  four.face(0, 1, 5);
  (void)canonical(four, 0.001, &report);
  check_report(report, {0, 0, 0, 0, 0, 1, 8, 0, 0});
}

TEST_CASE("specks are dropped on request, faces that share an edge belong together") {
  Shape shape = sphere(8, 6); // 80 faces
  const uint32_t first = uint32_t(shape.positions.size() / 3);
  Shape speck = tetrahedron(0.01);
  for (size_t i = 0; i < speck.positions.size(); i++) shape.positions.push_back(speck.positions[i] + 3);
  for (const uint32_t i : speck.faces) shape.faces.push_back(first + i);
  const fvv_mesh_source source = shape.source();
  fvv_mesh_report report = empty_report();
  for (const uint32_t least : {0u, 4u, 5u, 80u}) {
    fvv_mesh_options o = options();
    o.min_component_faces = least;
    Mesh mesh;
    REQUIRE(fvv_mesh_canonicalise(&source, &o, nullptr, &mesh, &report, nullptr) == FVV_OK);
    if (least < 5)
      check_report(report, {0, 0, 0, 0, 0, 0, 0, 0, 0});
    else
      check_report(report, {0, 0, 0, 4, 0, 0, 0, 1, 4});
    CHECK(mesh.face_count == (least < 5 ? 84 : 80));
  }
  fvv_mesh_options o = options();
  o.min_component_faces = 81;
  CHECK(refusal(shape, o) ==
        "no face is left of 84: 0 degenerate, 0 duplicate, 84 in components of fewer than 81");
  // Three faces on one edge are one component, although that edge is no manifold.
  o.min_component_faces = 3;
  const Shape edge = fin();
  const fvv_mesh_source fins = edge.source();
  Mesh mesh;
  REQUIRE(fvv_mesh_canonicalise(&fins, &o, nullptr, &mesh, &report, nullptr) == FVV_OK);
  CHECK(report.dropped_components == 0);
}

TEST_CASE("unusable sources are refused by name") {
  const double inf = std::numeric_limits<double>::infinity();
  Shape shape = tetrahedron();
  shape.positions[5] = std::nan("");
  CHECK(refusal(shape, options()) == "vertex 1: z is NaN, not a finite number");
  shape.positions[5] = -inf;
  CHECK(refusal(shape, options()) == "vertex 1: z is -infinity, not a finite number");
  shape.positions[5] = 300000;
  CHECK(refusal(shape, options()) ==
        "vertex 1: z = 300000 m lies more than 2^28 steps of 0.001 m from the origin 0 m");
  shape = tetrahedron();
  shape.faces[7] = 4;
  CHECK(refusal(shape, options()) == "face 2: index 4 of 4 vertices");
  shape = tetrahedron();
  shape.faces.clear();
  CHECK(refusal(shape, options()) == "no face is left: the source has 4 vertices and 0 faces");
  CHECK(refusal(tetrahedron(0.0001), options()) ==
        "no face is left of 4: 4 degenerate, 0 duplicate, 0 in components of fewer than 0");
}

TEST_CASE("options out of range are the caller's error") {
  for (const double step : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    refusal(tetrahedron(), options(step), FVV_ERROR_ARGUMENT);
  fvv_mesh_options o = options();
  o.lattice_origin[1] = std::nan("");
  refusal(tetrahedron(), o, FVV_ERROR_ARGUMENT);
  const Shape shape = tetrahedron();
  const fvv_mesh_source source = shape.source();
  Mesh mesh;
  fvv_mesh_report report = {};
  CHECK(fvv_mesh_canonicalise(&source, &o, nullptr, &mesh, &report, nullptr) == FVV_ERROR_ARGUMENT);
}

TEST_CASE("options of an earlier version have defaults after their end") {
  fvv_mesh_options o = options();
  o.min_component_faces = 1000;
  o.struct_size = offsetof(fvv_mesh_options, min_component_faces);
  const Shape shape = tetrahedron();
  const fvv_mesh_source source = shape.source();
  fvv_mesh_report report = {};
  report.struct_size = offsetof(fvv_mesh_report, degenerate_faces);
  report.boundary_edges = 77;
  Mesh mesh;
  REQUIRE(fvv_mesh_canonicalise(&source, &o, nullptr, &mesh, &report, nullptr) == FVV_OK);
  CHECK(report.boundary_edges == 77);
}

TEST_CASE("the canonicaliser survives every failed allocation") {
  Shape shape = two_components();
  shape.face(0, 0, 1);
  shape.point(9, 9, 9);
  fvv_mesh_options o = options();
  o.min_component_faces = 2;
  const fvv_mesh_source source = shape.source();
  const fvv_allocator allocator = memory::allocator();
  const size_t before = memory::state.live;
  int64_t n = 0;
  fvv_status status = FVV_ERROR_MEMORY;
  for (; status == FVV_ERROR_MEMORY && n < 100; n++) {
    fvv_mesh mesh;
    fvv_diagnostic diagnostic = {};
    memory::reset(n);
    status = fvv_mesh_canonicalise(&source, &o, &allocator, &mesh, nullptr, &diagnostic);
    memory::reset();
    const bool empty = !mesh.lattice && !mesh.faces && !mesh.vertex_count;
    const bool reported = diagnostic.status == status;
    fvv_mesh_free(&mesh);
    const bool leaked = memory::state.live != before;
    CHECK(empty == (status != FVV_OK));
    CHECK(reported);
    CHECK_FALSE(leaked);
  }
  CHECK(status == FVV_OK);
  CHECK(n > 15);
}
