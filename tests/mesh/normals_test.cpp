// Normals, computed and sent. Computed ones: against analytic ones, against sums in other arithmetic, across
// seams, and where there are none.
#include "draco_direct.h"
#include "fvv_catch.h"
#include "memory.h"
#include "shapes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>

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
  return {double(mesh.lattice[3 * v]), double(mesh.lattice[3 * v + 1]), double(mesh.lattice[3 * v + 2])};
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
      const int32_t *p = mesh.lattice + 3 * size_t(face[c]),
                    *q = mesh.lattice + 3 * size_t(face[(c + 1) % 3]);
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
  mesh.lattice = positions.data();
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
  const auto low = std::minmax_element(ball->lattice, ball->lattice + 3 * ball->vertex_count);
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
  CHECK(allowed >= 3);
}

// ---- Sent normals: octahedral indices, hard edges through the canonicaliser, round trips, hostile payloads,
// and how they turn in delta frames.

namespace {

using Vector = std::array<double, 3>;

std::unique_ptr<Mesh> with_normals(const Shape &shape, uint32_t bits, fvv_mesh_report *report = nullptr) {
  return canonical(shape, 0.001, report, bits);
}

std::string refusal(const Shape &shape, uint32_t bits, fvv_status expected = FVV_ERROR_INPUT) {
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  options.normal_bits = bits;
  const fvv_mesh_source source = shape.source();
  Mesh mesh;
  fvv_diagnostic diagnostic = {};
  CHECK(fvv_mesh_canonicalise(&source, &options, nullptr, &mesh, nullptr, &diagnostic) == expected);
  CHECK(!mesh.lattice);
  CHECK(!mesh.normals);
  return diagnostic.message;
}

// Spelled out for one point of the square, in another form than the library's: by the signs of the octants.
Vector unfolded(uint32_t bits, uint32_t u, uint32_t v) {
  const double half = std::ldexp(1.0, int(bits) - 1) - 1, a = u / half - 1, b = v / half - 1;
  Vector n = {a, b, 1 - std::abs(a) - std::abs(b)};
  if (n[2] < 0) n = {std::copysign(1 - std::abs(b), a), std::copysign(1 - std::abs(a), b), n[2]};
  const double length = std::hypot(n[0], n[1], n[2]);
  return {n[0] / length, n[1] / length, n[2] / length};
}

double degrees(const Vector &a, const Vector &b) {
  const Vector cross = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  return std::atan2(std::hypot(cross[0], cross[1], cross[2]), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) *
         57.29577951308232;
}

// Directions all over the sphere, by the golden angle.
std::vector<Vector> directions(size_t count) {
  std::vector<Vector> all;
  for (size_t i = 0; i < count; i++) {
    const double z = 1 - (2 * double(i) + 1) / double(count), r = std::sqrt(1 - z * z),
                 turn = 2.399963229728653 * double(i);
    all.push_back({r * std::cos(turn), r * std::sin(turn), z});
  }
  return all;
}

// Triangles apart from each other, each with normals to choose.
Shape scattered(const std::vector<Vector> &normals) {
  Shape shape;
  for (size_t i = 0; i < normals.size(); i++) {
    const auto v = uint32_t(i);
    shape.point(double(i) * 0.01, double(i % 3 == 1) * 0.005, double(i % 3 == 2) * 0.005);
    if (i % 3 == 2) shape.face(v - 2, v - 1, v);
    shape.normals.insert(shape.normals.end(), normals[i].begin(), normals[i].end());
  }
  return shape;
}

Vector sent(const fvv_mesh &mesh, size_t v) {
  return unfolded(mesh.normal_bits, mesh.normals[2 * v], mesh.normals[2 * v + 1]);
}

} // namespace

TEST_CASE("normal indices are the nearest and stay as they are when coded again") {
  for (const uint32_t bits : {2u, 3u, 5u, 8u, 12u}) {
    const std::vector<Vector> wanted = directions(bits < 6 ? 300 : 3000);
    const auto mesh = with_normals(scattered(wanted), bits);
    REQUIRE(mesh->normal_bits == bits);
    REQUIRE(mesh->vertex_count == wanted.size());
    double worst = 0, sum = 0;
    for (size_t v = 0; v < wanted.size(); v++) {
      const double off = degrees(sent(*mesh, v), wanted[v]);
      worst = std::max(worst, off);
      sum += off;
      if (bits > 5) continue;
      double best = 1e9; // of all there are
      for (uint32_t i = 0; i < 1u << bits; i++)
        for (uint32_t j = 0; i < (1u << bits) - 1 && j < (1u << bits) - 1; j++)
          best = std::min(best, degrees(unfolded(bits, i, j), wanted[v]));
      CHECK(off <= Approx(best).margin(1e-9));
    }
    INFO(bits << " bits: mean " << sum / double(wanted.size()) << ", worst " << worst << " degrees");
    if (bits == 8) CHECK((worst < 0.95 && sum / double(wanted.size()) < 0.35));
    if (bits == 12) CHECK(worst < 0.06);
    Shape again = scattered(wanted);
    for (size_t v = 0; v < wanted.size(); v++)
      for (size_t k = 0; k < 3; k++) again.normals[3 * v + k] = sent(*mesh, v)[k];
    const auto second = with_normals(again, bits);
    CHECK(!memcmp(second->normals, mesh->normals, 8 * wanted.size()));
  }
}

TEST_CASE("axes are exact, and directions on the rim of the square have one index") {
  std::vector<Vector> wanted;
  for (const double s : {1.0, -1.0}) {
    wanted.insert(wanted.end(), {{s, 0, 0}, {0, s, 0}, {0, 0, s}});
    wanted.insert(wanted.end(), {{s, 1e-9, -1e-9}, {s, -1e-9, -1e-9}, {1e-9, s * 1e-9, -1}});
  }
  for (uint32_t bits = 2; bits <= 12; bits++) {
    const auto mesh = with_normals(scattered(wanted), bits);
    std::vector<float> normals(3 * wanted.size());
    fvv_diagnostic diagnostic = {};
    REQUIRE(fvv_mesh_normals(mesh.get(), nullptr, normals.data(), &diagnostic) == FVV_OK);
    for (size_t v = 0; v < wanted.size(); v++)
      for (size_t k = 0; k < 3; k++) CHECK(normals[3 * v + k] == float(std::round(wanted[v][k])));
    const uint32_t most = (1u << bits) - 2;
    for (const size_t v : {8u, 5u, 11u}) { // 0 0 -1 and what lies next to it
      CHECK(mesh->normals[2 * v] == most);
      CHECK(mesh->normals[2 * v + 1] == most);
    }
  }
}

TEST_CASE("a component that is zero has no sign, also in the folded half") {
  for (unsigned bits = 2; bits <= 6; bits++) {
    const uint32_t most = (1u << bits) - 2;
    size_t zeros = 0, signs = 0;
    for (uint32_t i = 0; i <= most; i++)
      for (uint32_t j = 0; j <= most; j++) {
        const uint32_t index[2] = {i, j};
        float normal[3];
        fvv_normals_to_floats((uint8_t)bits, index, 1, normal);
        for (const float x : normal) {
          zeros += x == 0;
          signs += x == 0 && std::signbit(x);
        }
      }
    CHECK(zeros > 0);
    CHECK(signs == 0);
  }
}

TEST_CASE("a hard edge keeps its vertices apart, a smooth one does not") {
  fvv_mesh_report report = {};
  report.struct_size = sizeof report;
  const Shape cube = hard_cube(4);
  const auto hard = with_normals(cube, 8, &report);
  CHECK(hard->vertex_count == 6 * 25);
  CHECK(report.boundary_edges == 0);
  CHECK(report.seam_vertices == 6 * 25 - (8 + 12 * 3 + 6 * 9));
  CHECK(report.welded_vertices == 0);
  const auto smooth = with_normals(cube, 0, &report);
  CHECK(smooth->vertex_count == 8 + 12 * 3 + 6 * 9);
  CHECK(!smooth->normals);
  CHECK(smooth->normal_bits == 0);

  // Twice the same vertices with normals of other lengths: welded to the first.
  Shape twice = cube;
  twice.positions.insert(twice.positions.end(), cube.positions.begin(), cube.positions.end());
  for (const double x : cube.normals) twice.normals.push_back(x * 1e200);
  for (size_t i = 0; i < twice.faces.size(); i += 2) twice.faces[i] += 150;
  const auto welded = with_normals(twice, 8, &report);
  CHECK(report.welded_vertices == 150);
  const bool same = triangles(*welded) == triangles(*hard);
  CHECK(same);
}

TEST_CASE("normals that are none are refused with their vertex") {
  Shape cube = hard_cube(1);
  for (size_t k = 0; k < 3; k++) cube.normals[3 * 7 + k] = 0;
  CHECK(refusal(cube, 8) == "vertex 7: its normal is (0, 0, 0)");
  cube.normals[3 * 7 + 1] = std::numeric_limits<double>::quiet_NaN();
  CHECK(refusal(cube, 8) == "vertex 7: y of its normal is NaN, not a finite number");
  cube.normals[3 * 7 + 1] = 5e-324;
  CHECK(with_normals(cube, 8)->normal_bits == 8);
  CHECK(refusal(cube, 1, FVV_ERROR_ARGUMENT) == "1 bits for a normal index, not 2 to 12");
  refusal(cube, 13, FVV_ERROR_ARGUMENT);
}

TEST_CASE("normals come through all profiles, with texture coordinates too") {
  for (const bool texture : {false, true})
    for (const uint32_t bits : {2u, 8u, 12u}) {
      Shape shape = hard_cube(5);
      if (texture) shape.texture = charts(5).texture;
      const auto mesh = with_normals(shape, bits);
      for (int level = -2; level <= 10; level++) {
        INFO("level " << level << ", " << bits << " bits");
        const uint8_t profile = level == -2 ? FVV_MESH_FAST : level < 0 ? FVV_MESH_RAW : FVV_MESH_DRACO;
        const auto payload = encoded(*mesh, profile, std::max(level, 0));
        CHECK(payload[1] == (texture ? 3 : 2));
        CHECK(payload[3] == bits);
        Mesh decoded;
        fvv_diagnostic diagnostic = {};
        REQUIRE(decode(payload, &decoded, &diagnostic) == FVV_OK);
        CHECK(decoded.normal_bits == bits);
        const bool same = triangles(decoded) == triangles(*mesh);
        CHECK(same);
        std::vector<uint8_t> cut = payload;
        cut.pop_back();
        Mesh none;
        CHECK(decode(cut, &none, &diagnostic) == FVV_ERROR_INVALID);
      }
      if (!texture) continue;
      Bytes payload;
      Mesh decoded;
      std::vector<uint32_t> vertices(3 * mesh->face_count);
      fvv_diagnostic diagnostic = {};
      REQUIRE(fvv_mesh_encode_mapped(mesh.get(), FVV_MESH_DRACO, 7, nullptr, &payload, &decoded,
                                     vertices.data(), &diagnostic) == FVV_OK);
      for (size_t v = 0; v < decoded.vertex_count; v++)
        CHECK(!memcmp(decoded.normals + 2 * v, mesh->normals + 2 * size_t(vertices[v]), 8));
    }
}

TEST_CASE("3030, 3031: normal bits and indices are in range") {
  const auto mesh = with_normals(hard_cube(1), 8);
  const auto payload = encoded(*mesh, FVV_MESH_RAW, 0);
  const auto check = [](const std::vector<uint8_t> &bytes, uint32_t issue, uint64_t offset) {
    Mesh decoded;
    fvv_diagnostic diagnostic = {};
    CHECK(decode(bytes, &decoded, &diagnostic) == FVV_ERROR_INVALID);
    INFO(diagnostic.message);
    CHECK(diagnostic.issue == issue);
    CHECK(diagnostic.offset == offset);
    CHECK(!decoded.normals);
  };
  for (const uint8_t bits : {0, 1, 13, 255}) {
    auto bad = payload;
    bad[3] = bits;
    check(bad, 3030, 3);
  }
  auto none = encoded(*canonical(tetrahedron()), FVV_MESH_RAW, 0);
  none[3] = 8;
  check(none, 3030, 3);
  const size_t normals = 16 + 12 * 24;
  for (const uint8_t index : {254, 255}) {
    auto bad = payload;
    bad[normals + 8 * 5 + 4] = index;
    if (index == 255) check(bad, 3031, normals + 8 * 5);
    Mesh decoded;
    fvv_diagnostic diagnostic = {};
    if (index == 254) CHECK(decode(bad, &decoded, &diagnostic) == FVV_OK);
  }
  mesh->normals[3] = 255;
  auto compressed = encoded(*with_normals(hard_cube(1), 9), FVV_MESH_DRACO, 5);
  compressed[3] = 7; // indices up to 510 are declared to be up to 126
  check(compressed, 3031, 16);
  Bytes bytes;
  fvv_diagnostic diagnostic = {};
  CHECK(fvv_mesh_encode(mesh.get(), FVV_MESH_RAW, 0, nullptr, &bytes, &diagnostic) == FVV_ERROR_INPUT);
  CHECK(diagnostic.issue == 3031);
}

TEST_CASE("3010: a Draco bitstream has normals exactly when the header has normal bits") {
  const auto with = with_normals(hard_cube(2), 8), without = with_normals(hard_cube(2), 0);
  auto missing = encoded(*without, FVV_MESH_DRACO, 5), extra = encoded(*with, FVV_MESH_DRACO, 5);
  missing[1] = FVV_MESH_HAS_NORMALS;
  missing[3] = 8;
  extra[1] = extra[3] = 0;
  auto instead = encoded(*with, FVV_MESH_DRACO, 5); // normals where texture coordinates are declared
  instead[1] = FVV_MESH_HAS_TEXTURE;
  instead[2] = 8;
  instead[3] = 0;
  DracoOptions vectors; // three components
  vectors.normals = true;
  auto wide = draco_payload(*without, vectors);
  wide[1] = FVV_MESH_HAS_NORMALS;
  wide[3] = 8;
  for (const auto *payload : {&missing, &extra, &instead, &wide}) {
    Mesh decoded;
    fvv_diagnostic diagnostic = {};
    CHECK(decode(*payload, &decoded, &diagnostic) == FVV_ERROR_INVALID);
    INFO(diagnostic.message);
    CHECK(diagnostic.issue == 3010);
  }
}

TEST_CASE("sent normals turn with the faces of a moving mesh") {
  Shape shape = hard_cube(3);
  for (double &x : shape.positions) x -= 0.5;
  // Normals that lean a little, so that a turn about the face's normal would show.
  for (size_t i = 0; i < shape.normals.size(); i += 3) shape.normals[i] += 0.02;
  const auto key = with_normals(shape, 12);
  fvv_mesh_delta_options exact;
  fvv_mesh_delta_options_default(&exact);
  exact.max_error = 0;
  for (const uint8_t profile : {FVV_MESH_RAW, FVV_MESH_DRACO, FVV_MESH_FAST}) {
    Mesh decoded;
    fvv_diagnostic diagnostic = {};
    REQUIRE(decode(encoded(*key, profile, 5), &decoded, &diagnostic) == FVV_OK);
    fvv_mesh_sequence *encoder = nullptr, *decoder = nullptr;
    REQUIRE(fvv_mesh_sequence_open(&decoded, nullptr, &encoder, &diagnostic) == FVV_OK);
    REQUIRE(fvv_mesh_sequence_open(&decoded, nullptr, &decoder, &diagnostic) == FVV_OK);
    std::vector<int32_t> moved(3 * size_t(decoded.vertex_count));
    for (int frame = 1; frame <= 4; frame++) {
      // About z; sides upright on it turn with it, by the smallest rotation.
      const double turn = 0.4 * frame, c = std::cos(turn), s = std::sin(turn);
      const auto rotate = [&](Vector p) { return Vector{c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]}; };
      for (size_t v = 0; v < decoded.vertex_count; v++) {
        const int32_t *p = decoded.lattice + 3 * v;
        const Vector to = rotate({double(p[0]), double(p[1]), double(p[2])});
        for (size_t k = 0; k < 3; k++) moved[3 * v + k] = int32_t(std::lround(to[k]));
      }
      Bytes payload;
      REQUIRE(fvv_mesh_sequence_encode(encoder, moved.data(), &exact, &payload, &diagnostic) == FVV_OK);
      CHECK(payload.data[1] == FVV_MESH_HAS_NORMALS);
      CHECK(payload.data[3] == 12);
      const std::vector<uint8_t> bytes = payload.copy();
      REQUIRE(fvv_mesh_sequence_decode(decoder, bytes.data(), bytes.size(), &diagnostic) == FVV_OK);
      const fvv_mesh *now = fvv_mesh_sequence_mesh(decoder);
      const bool same =
          !memcmp(now->normals, fvv_mesh_sequence_mesh(encoder)->normals, 8 * size_t(now->vertex_count));
      CHECK(same);
      double worst = 0;
      for (size_t v = 0; v < now->vertex_count; v++) {
        const Vector before = sent(decoded, v), found = sent(*now, v);
        const bool level = std::abs(before[2]) > 0.9; // the normals of top and bottom do not turn
        worst = std::max(worst, degrees(found, level ? before : rotate(before)));
      }
      CHECK(worst < 0.5); // of rounding to the lattice and of two times 12 bits
    }
    fvv_mesh_sequence_close(encoder);
    fvv_mesh_sequence_close(decoder);
  }
}

TEST_CASE("3018: a delta frame has the normal bits of its key mesh") {
  const auto key = with_normals(hard_cube(2), 8);
  fvv_mesh_sequence *sequence = nullptr;
  fvv_diagnostic diagnostic = {};
  REQUIRE(fvv_mesh_sequence_open(key.get(), nullptr, &sequence, &diagnostic) == FVV_OK);
  Bytes payload;
  REQUIRE(fvv_mesh_sequence_encode(sequence, key->lattice, nullptr, &payload, &diagnostic) == FVV_OK);
  fvv_mesh_sequence_close(sequence);
  REQUIRE(fvv_mesh_sequence_open(key.get(), nullptr, &sequence, &diagnostic) == FVV_OK);
  std::vector<uint8_t> bytes = payload.copy();
  bytes[3] = 9;
  CHECK(fvv_mesh_sequence_decode(sequence, bytes.data(), bytes.size(), &diagnostic) == FVV_ERROR_INVALID);
  CHECK(diagnostic.issue == 3018);
  fvv_mesh_sequence_close(sequence);
}

TEST_CASE("sent normals survive a vertex whose faces vanish or turn over") {
  Shape shape;
  for (const double x : {0.0, 0.01, 0.0}) shape.point(x, shape.positions.size() == 6 ? 0.01 : 0, 0);
  shape.face(0, 1, 2);
  shape.normals = {0, 0, 1, 0.6, 0, 0.8, 0, 0.6, 0.8};
  const auto key = with_normals(shape, 8);
  fvv_mesh_sequence *sequence = nullptr;
  fvv_diagnostic diagnostic = {};
  REQUIRE(fvv_mesh_sequence_open(key.get(), nullptr, &sequence, &diagnostic) == FVV_OK);
  fvv_mesh_delta_options exact;
  fvv_mesh_delta_options_default(&exact);
  exact.max_error = 0;
  const std::vector<std::vector<int32_t>> frames = {{0, 0, 0, 10, 0, 0, 20, 0, 0},  // no area
                                                    {0, 0, 0, 0, 10, 0, 10, 0, 0},  // turned over
                                                    {0, 0, 0, 10, 0, 0, 0, 10, 0}}; // as it was
  for (size_t i = 0; i < frames.size(); i++) {
    Bytes payload;
    REQUIRE(fvv_mesh_sequence_encode(sequence, frames[i].data(), &exact, &payload, &diagnostic) == FVV_OK);
    for (size_t v = 0; v < 3; v++) {
      const Vector before = sent(*key, v), now = sent(*fvv_mesh_sequence_mesh(sequence), v);
      for (size_t k = 0; k < 3; k++) CHECK(now[k] == Approx(i == 1 ? -before[k] : before[k]).margin(1e-12));
    }
  }
  fvv_mesh_sequence_close(sequence);
}

TEST_CASE("meshes with normals give their memory back when it runs out") {
  const Shape shape = hard_cube(3);
  const fvv_mesh_source source = shape.source();
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  options.normal_bits = 8;
  const fvv_allocator allocator = memory::allocator();
  for (int64_t allowed = 0, done = 0; !done; allowed++) {
    memory::reset(allowed);
    const size_t live = memory::state.live;
    fvv_mesh mesh = {};
    fvv_mesh_sequence *sequence = nullptr;
    fvv_diagnostic diagnostic = {};
    fvv_status status = fvv_mesh_canonicalise(&source, &options, &allocator, &mesh, nullptr, &diagnostic);
    if (status == FVV_OK) status = fvv_mesh_sequence_open(&mesh, &allocator, &sequence, &diagnostic);
    fvv_mesh_sequence_close(sequence);
    fvv_mesh_free(&mesh);
    const size_t left = memory::state.live;
    memory::reset();
    CHECK(left == live);
    CHECK((status == FVV_OK || status == FVV_ERROR_MEMORY));
    done = status == FVV_OK;
  }
}
