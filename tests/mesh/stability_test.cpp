// Meshes as reconstruction leaves them, and worse, through the whole chain: canonicalised, encoded in each
// profile, decoded, moved in delta frames. Each either comes back within the bound or is refused in the words
// that the table has. What must come back is computed here from the source, not by libfvv.
#include "fvv_catch.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "shapes.h"

namespace {

struct Profile {
  const char *name;
  uint8_t id;
  int level;
};
const std::vector<Profile> profiles = {
    {"raw", FVV_MESH_RAW, 0}, {"draco 0", FVV_MESH_DRACO, 0}, {"draco 10", FVV_MESH_DRACO, 10}};

struct Changes {
  uint32_t welded = 0, degenerate = 0, duplicate = 0, unreferenced = 0, flipped = 0, nonmanifold = 0;
  bool operator==(const Changes &o) const {
    return welded == o.welded && degenerate == o.degenerate && duplicate == o.duplicate &&
           unreferenced == o.unreferenced && flipped == o.flipped && nonmanifold == o.nonmanifold;
  }
};

struct Case {
  const char *name;
  Shape shape;
  double step;
  Changes changes;
  std::string refusal; // empty: it comes back
};

constexpr double step = 0.001, inf = std::numeric_limits<double>::infinity();
constexpr uint32_t columns = 24, rows = 16, base_vertices = columns * rows, base_faces = 2 * base_vertices;
Shape base() {
  return torus(columns, rows);
}

Shape scaled(double factor) {
  Shape s = base();
  for (double &x : s.positions) x *= factor;
  return s;
}

Shape with_coordinate(size_t vertex, size_t axis, double value) {
  Shape s = base();
  s.positions[3 * vertex + axis] = value;
  return s;
}

// Every face has vertices of its own.
Shape soup(const Shape &shape) {
  Shape s;
  for (const uint32_t v : shape.faces) {
    const double *p = &shape.positions[3 * size_t(v)];
    s.point(p[0], p[1], p[2]);
    s.faces.push_back(uint32_t(s.faces.size()));
  }
  return s;
}

void add_slivers(Shape &s) {
  const uint32_t last = uint32_t(s.positions.size() / 3);
  s.point(1, 1, 1);
  s.point(1.1, 1.1, 1.1);
  s.point(1.3, 1.3, 1.3);
  s.point(0.00001, 2, 2); // a face 0.01 mm wide
  s.point(0.00002, 2, 2);
  s.point(0.00001, 2, 2.00001);
  s.face(0, 0, 1);
  s.face(7, 7, 7);
  s.face(last, last + 1, last + 2);
  s.face(last + 3, last + 4, last + 5);
}

// Three more faces on the edge of vertices 0 and 1, that is five in all.
void add_fins(Shape &s) {
  for (int i = 1; i <= 3; i++) {
    s.point(2, 0.1 * i, 1);
    s.face(0, 1, uint32_t(s.positions.size() / 3 - 1));
  }
}

// Fans of six faces whose only common vertex is the apex.
Shape fans(uint32_t count) {
  Shape s;
  s.point(0, 0, 0);
  for (uint32_t k = 0; k < count; k++) {
    const uint32_t first = uint32_t(s.positions.size() / 3);
    for (uint32_t i = 0; i < 6; i++) s.point(std::cos(1.0 * i), std::sin(1.0 * i), 0.5 + k);
    for (uint32_t i = 0; i < 6; i++) s.face(0, first + i, first + (i + 1) % 6);
  }
  return s;
}

void turn_each_third(Shape &s) {
  for (size_t f = 0; f < base_faces; f += 3) std::swap(s.faces[3 * f + 1], s.faces[3 * f + 2]);
}

void add_strays(Shape &s) {
  s.point(250000, -250000, 250000); // nearly as far as the lattice goes
  s.point(-250000, 0, 0);
}

template <class... Steps> Shape defect(Steps... steps) {
  Shape s = base();
  (steps(s), ...);
  return s;
}

Shape one_triangle() {
  Shape s;
  s.point(0, 0, 0);
  s.point(1, 0, 0);
  s.point(0, 1, 0);
  s.face(0, 1, 2);
  return s;
}

Shape with_far_index() {
  Shape s = base();
  s.faces[3 * 5 + 1] = base_vertices;
  return s;
}

Shape without_faces() {
  Shape s = base();
  s.faces.clear();
  return s;
}

std::vector<Case> cases() {
  return {
      {"clean", base(), step, {}, ""},
      {"duplicate vertices", soup(base()), step, {3 * base_faces - base_vertices, 0, 0, 0, 0, 0}, ""},
      {"zero-area faces", defect(add_slivers), step, {2, 4, 0, 4, 0, 0}, ""},
      {"non-manifold edge", defect(add_fins), step, {0, 0, 0, 0, 0, 1}, ""},
      {"bow-tie", fans(2), step, {}, ""},
      {"twelve fans in one vertex", fans(12), step, {}, ""},
      {"mixed winding", defect(turn_each_third), step, {0, 0, 0, 0, base_faces / 3, 0}, ""},
      {"unreferenced vertices", defect(add_strays), step, {0, 0, 0, 2, 0, 0}, ""},
      {"all of these",
       defect(add_slivers, add_fins, turn_each_third, add_strays),
       step,
       {2, 4, 0, 6, base_faces / 3, 1},
       ""},
      {"one triangle", one_triangle(), step, {}, ""},
      {"coordinates at 1e6", scaled(1e6), 0.01, {}, ""},
      {"coordinates at 3e38 on a lattice as coarse", scaled(3e38), 1e31, {}, ""},
      {"a coordinate at 1e6 on a fine lattice",
       with_coordinate(3, 0, 1e6),
       step,
       {},
       "vertex 3: x = 1e+06 m lies more than 2^28 steps of 0.001 m from the origin 0 m"},
      {"a coordinate at 3e38",
       with_coordinate(4, 1, 3e38),
       step,
       {},
       "vertex 4: y = 3e+38 m lies more than 2^28 steps of 0.001 m from the origin 0 m"},
      {"NaN", with_coordinate(17, 0, std::nan("")), step, {}, "vertex 17: x is NaN, not a finite number"},
      {"infinity", with_coordinate(18, 1, inf), step, {}, "vertex 18: y is infinity, not a finite number"},
      {"minus infinity",
       with_coordinate(19, 2, -inf),
       step,
       {},
       "vertex 19: z is -infinity, not a finite number"},
      {"empty", Shape(), step, {}, "no face is left: the source has 0 vertices and 0 faces"},
      {"vertices without faces",
       without_faces(),
       step,
       {},
       "no face is left: the source has 384 vertices and 0 faces"},
      {"nothing but zero-area faces",
       scaled(1e-6),
       step,
       {},
       "no face is left of 768: 768 degenerate, 0 duplicate, 0 in components of fewer than 0"},
      {"index out of range", with_far_index(), step, {}, "face 5: index 384 of 384 vertices"},
  };
}

using Point = std::array<int32_t, 3>;
using Corners = std::array<Point, 3>;

bool flat(const Corners &t) {
  int64_t a[3], b[3];
  for (size_t k = 0; k < 3; k++) {
    a[k] = int64_t(t[1][k]) - t[0][k];
    b[k] = int64_t(t[2][k]) - t[0][k];
  }
  return a[1] * b[2] == a[2] * b[1] && a[2] * b[0] == a[0] * b[2] && a[0] * b[1] == a[1] * b[0];
}

// The faces with an area on the lattice, with any winding, each once.
template <class Position>
std::vector<Corners> surface(const uint32_t *faces, size_t count, const Position &position) {
  std::vector<Corners> all;
  for (size_t f = 0; f < count; f++) {
    Corners t;
    for (size_t c = 0; c < 3; c++) t[c] = position(faces[3 * f + c]);
    std::sort(t.begin(), t.end());
    if (!flat(t)) all.push_back(t);
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

std::vector<Corners> surface(const Shape &shape, double of_step) {
  return surface(shape.faces.data(), shape.faces.size() / 3, [&](uint32_t v) {
    Point p;
    for (size_t k = 0; k < 3; k++)
      p[k] = int32_t(std::nearbyint(shape.positions[3 * size_t(v) + k] / of_step));
    return p;
  });
}

std::vector<Corners> surface(const fvv_mesh &mesh) {
  return surface(mesh.faces, mesh.face_count, [&](uint32_t v) {
    const int32_t *p = mesh.lattice + 3 * size_t(v);
    return Point{p[0], p[1], p[2]};
  });
}

// Moves, collapses into one point, comes back: with no error, some, none.
void check_frames(const fvv_mesh &key) {
  Sequence encoder(key), decoder(key);
  const std::vector<int32_t> point(3 * size_t(key.vertex_count), 7);
  int t = 0;
  for (const auto &wanted : {moved(key, 1, 2), moved(key, 2, 2), point, moved(key, 3)}) {
    const uint32_t error = t++ % 2 ? 5 : 0;
    INFO("delta frame " << t << ", error of " << error);
    REQUIRE(decoder.decode(encoder.encode(wanted, error)) == FVV_OK);
    CHECK(decoder.positions() == encoder.positions());
    CHECK(distance(decoder.positions(), wanted) <= int32_t(error));
  }
}

void check_round_trip(const Shape &shape, double of_step, const fvv_mesh &mesh) {
  const auto expected = surface(shape, of_step);
  for (const Profile &profile : profiles) {
    INFO("profile " << profile.name);
    Mesh decoded;
    REQUIRE(decode(encoded(mesh, profile.id, profile.level), &decoded, nullptr) == FVV_OK);
    CHECK((surface(decoded) == expected));
    check_frames(decoded);
  }
}

// A frame of a running sequence with these positions is refused by the vertex too, and harms nothing.
void check_refused_frame(const Shape &shape, double of_step, const std::string &refusal) {
  const double origin[3] = {0, 0, 0};
  std::vector<int32_t> indices(shape.positions.size());
  fvv_diagnostic diagnostic = {};
  CHECK(fvv_lattice_from_metres(origin, of_step, shape.positions.data(), shape.positions.size() / 3,
                                indices.data(), &diagnostic) == FVV_ERROR_INPUT);
  CHECK(diagnostic.message == refusal);
}

} // namespace

TEST_CASE("every defect comes back within the bound or is refused by name") {
  for (const Case &one : cases()) {
    INFO("case: " << one.name);
    fvv_mesh_options options;
    fvv_mesh_options_default(&options);
    options.lattice_step = one.step;
    const fvv_mesh_source source = one.shape.source();
    Mesh mesh;
    fvv_mesh_report report = {};
    report.struct_size = sizeof report;
    fvv_diagnostic diagnostic = {};
    const fvv_status status = fvv_mesh_canonicalise(&source, &options, nullptr, &mesh, &report, &diagnostic);
    if (!one.refusal.empty()) {
      CHECK(status == FVV_ERROR_INPUT);
      CHECK(diagnostic.message == one.refusal);
      CHECK(mesh.vertex_count == 0);
      if (!one.refusal.rfind("vertex", 0)) check_refused_frame(one.shape, one.step, one.refusal);
      continue;
    }
    INFO(diagnostic.message);
    REQUIRE(status == FVV_OK);
    const Changes found = {report.welded_vertices,       report.degenerate_faces, report.duplicate_faces,
                           report.unreferenced_vertices, report.flipped_faces,    report.nonmanifold_edges};
    INFO("welded " << found.welded << ", degenerate " << found.degenerate << ", duplicate " << found.duplicate
                   << ", unreferenced " << found.unreferenced << ", flipped " << found.flipped
                   << ", non-manifold " << found.nonmanifold);
    CHECK((found == one.changes));
    CHECK(report.max_error <= one.step / 2 * (1 + 1e-9));
    check_round_trip(one.shape, one.step, mesh);
  }
}

TEST_CASE("a million triangles come back", "[slow][long]") {
  const Shape shape = torus(1000, 500);
  const double fine = 0.0002;
  REQUIRE(shape.faces.size() == 3000000);
  const auto mesh = canonical(shape, fine);
  const auto expected = surface(shape, fine);
  Mesh decoded;
  for (const Profile &profile : profiles) {
    // The slowest coding takes as long as all else, and at this size does nothing that the others don't.
    if (profile.level == 10) continue;
    INFO("profile " << profile.name);
    fvv_mesh_free(&decoded);
    REQUIRE(decode(encoded(*mesh, profile.id, profile.level), &decoded, nullptr) == FVV_OK);
    CHECK((surface(decoded) == expected));
  }
  Sequence encoder(decoded), decoder(decoded);
  const auto wanted = moved(decoded, 1, 2);
  REQUIRE(decoder.decode(encoder.encode(wanted, 1)) == FVV_OK);
  CHECK((decoder.positions() == encoder.positions()));
  CHECK(distance(decoder.positions(), wanted) <= 1);
}

TEST_CASE("500 frames of a mesh with defects stay as near to the source in metres as the first ones") {
  const Shape shape = defect(add_slivers, add_fins, turn_each_third);
  const auto key = key_of(shape, step);
  const size_t count = 3 * size_t(key->vertex_count);
  const double origin[3] = {0, 0, 0};
  for (const uint32_t error : {0u, 1u}) {
    Sequence encoder(*key), decoder(*key);
    double early = 0, late = 0;
    for (int t = 1; t <= 500; t++) {
      INFO("error of " << error << ", frame " << t);
      // Slow motion, a small part of a step a frame: a coder of differences alone would lose it.
      std::vector<double> source(count), now(count);
      for (size_t i = 0; i < count; i++)
        source[i] = step * key->lattice[i] + 0.01 * std::sin(0.004 * t + 0.1 * double(i % 50)) + 0.00013 * t;
      std::vector<int32_t> wanted(count);
      REQUIRE(fvv_lattice_from_metres(origin, step, source.data(), count / 3, wanted.data(), nullptr) ==
              FVV_OK);
      REQUIRE(decoder.decode(encoder.encode(wanted, error)) == FVV_OK);
      const auto positions = decoder.positions();
      double worst = 0, sum = 0;
      for (size_t i = 0; i < count; i++) {
        const double off = std::fabs(step * positions[i] - source[i]);
        worst = std::max(worst, off);
        sum += off;
      }
      REQUIRE(worst <= step * (error + 0.5) * (1 + 1e-9));
      (t <= 50 ? early : t > 450 ? late : sum) += sum;
    }
    CHECK(late < 1.1 * early);
  }
}
