// Texture coordinates: what the canonicaliser makes of them, round trips, the cost.
#include "fvv_catch.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <set>
#include <string>

#include "draco_direct.h"
#include "memory.h"
#include "shapes.h"

namespace {

fvv_mesh_options options(uint32_t bits, double step = 0.001) {
  fvv_mesh_options o;
  fvv_mesh_options_default(&o);
  o.lattice_step = step;
  o.texture_bits = bits;
  return o;
}

std::unique_ptr<Mesh> with_bits(const Shape &shape, uint32_t bits, fvv_mesh_report *report = nullptr,
                                double step = 0.001) {
  const fvv_mesh_options o = options(bits, step);
  const fvv_mesh_source source = shape.source();
  auto mesh = std::make_unique<Mesh>();
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_mesh_canonicalise(&source, &o, nullptr, mesh.get(), report, &diagnostic);
  INFO(diagnostic.message);
  REQUIRE(status == FVV_OK);
  return mesh;
}

fvv_mesh_report empty_report() {
  fvv_mesh_report report = {};
  report.struct_size = sizeof report;
  return report;
}

// Each face has vertices of its own with texture coordinates at random: only seams.
Shape confetti(Shape shape) {
  Shape out;
  uint32_t state = 5;
  for (const uint32_t v : shape.faces) {
    out.faces.push_back(uint32_t(out.faces.size()));
    for (size_t k = 0; k < 3; k++) out.positions.push_back(shape.positions[3 * v + k]);
    for (int k = 0; k < 2; k++) {
      state = state * 1664525 + 1013904223;
      out.texture.push_back(state / 4294967295.0);
    }
  }
  return out;
}

// Planar coordinates in one chart over any shape: x and y of the box. Vertices keep their connectivity.
Shape projected(Shape shape) {
  double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
  for (size_t i = 0; i < shape.positions.size(); i++) {
    if (i % 3 == 2) continue;
    low[i % 3] = std::min(low[i % 3], shape.positions[i]);
    high[i % 3] = std::max(high[i % 3], shape.positions[i]);
  }
  for (size_t i = 0; i < shape.positions.size(); i++)
    if (i % 3 != 2) shape.texture.push_back((shape.positions[i] - low[i % 3]) / (high[i % 3] - low[i % 3]));
  return shape;
}

struct Named {
  const char *name;
  Shape shape;
  double step;
};

std::vector<Named> textured() {
  Shape far = tetrahedron(2.0 * FVV_LATTICE_MAX);
  for (double &x : far.positions) x -= FVV_LATTICE_MAX;
  return {{"six charts", charts(7), 0.001},
          {"charts of two triangles", charts(1), 0.001},
          {"one chart", projected(grid(20)), 0.001},
          {"torus", projected(torus(40, 20)), 0.001},
          {"confetti", confetti(sphere(12, 8)), 0.001},
          {"fin", projected(fin()), 0.001},
          {"bow-tie", projected(bow_tie()), 0.001},
          {"many holes", projected(ragged(60, 20, 3)), 0.001},
          {"handles", projected(sponge(8, 0.4, 3)), 0.01},
          {"flat grid", projected(grid(300, 0)), 0.01},
          {"slow edgebreaker", projected(holed_hubs(3000)), 1e-4},
          {"at the lattice's bounds", projected(far), 1}};
}

std::string refusal(const Shape &shape, const fvv_mesh_options &o, uint32_t issue,
                    fvv_status expected = FVV_ERROR_INPUT) {
  const fvv_mesh_source source = shape.source();
  Mesh mesh;
  fvv_diagnostic diagnostic = {};
  CHECK(fvv_mesh_canonicalise(&source, &o, nullptr, &mesh, nullptr, &diagnostic) == expected);
  CHECK(diagnostic.issue == issue);
  CHECK(!mesh.lattice);
  CHECK(!mesh.texture);
  return diagnostic.message;
}

} // namespace

TEST_CASE("texture indices are the nearest, ties to even, and come back exactly") {
  for (uint32_t bits = 1; bits <= 16; bits++) {
    const double steps = std::ldexp(1.0, int(bits));
    Shape shape = tetrahedron();
    shape.texture = {0, 1, 0.5 / steps, 1.5 / steps, 0.49999 / steps, 0.50001 / steps, 1 - 0.5 / steps, 0.3};
    const auto mesh = with_bits(shape, bits);
    REQUIRE(mesh->texture_bits == bits);
    const auto last = uint32_t(steps);
    const std::vector<uint32_t> expected = {0, last, 0, 2, 0, 1, last, uint32_t(std::nearbyint(0.3 * steps))};
    CHECK(std::vector<uint32_t>(mesh->texture, mesh->texture + 8) == expected);
    float uv[8];
    fvv_texture_to_floats(mesh->texture_bits, mesh->texture, 4, uv);
    for (size_t i = 0; i < 8; i++) CHECK(double(uv[i]) == std::ldexp(double(expected[i]), -int(bits)));
  }
}

TEST_CASE("vertices are welded when lattice point and texture indices agree") {
  Shape shape = charts(3);
  fvv_mesh_report report = empty_report();
  const auto mesh = with_bits(shape, 12, &report);
  // 6 charts of 16 vertices; of the cube's surface 8 corners, 12 * 2 points on edges, 6 * 4 inside.
  CHECK(mesh->vertex_count == 96);
  CHECK(report.seam_vertices == 96 - (8 + 24 + 24));
  CHECK(report.welded_vertices == 0);
  // Closed and consistent, although every chart has a rim.
  CHECK(report.boundary_edges == 0);
  CHECK(report.nonmanifold_edges == 0);
  CHECK(report.flipped_faces == 0);
  CHECK(report.clamped_vertices == 0);

  // The same vertices twice, a little off: they are welded to the first.
  const size_t count = shape.positions.size() / 3;
  for (size_t i = 0; i < 3 * count; i++) shape.positions.push_back(shape.positions[i] + 0.0001);
  for (size_t i = 0; i < 2 * count; i++) shape.texture.push_back(std::min(shape.texture[i] + 1e-9, 1.0));
  for (size_t i = 0; i < shape.faces.size(); i += 2) shape.faces[i] += uint32_t(count);
  const auto again = with_bits(shape, 12, &report);
  CHECK(report.welded_vertices == 96);
  CHECK(again->vertex_count == 96);
  const bool same = triangles(*again) == triangles(*mesh);
  CHECK(same);

  // Without texture coordinates the seams close.
  for (const bool asked : {true, false}) {
    Shape plain = charts(3);
    if (asked) plain.texture.clear();
    const auto closed = with_bits(plain, asked ? 12 : 0, &report);
    CHECK(closed->vertex_count == 56);
    CHECK((!closed->texture && !closed->texture_bits));
    CHECK((report.welded_vertices == 40 && report.seam_vertices == 0));
  }
}

TEST_CASE("faces across a seam are judged by positions") {
  Shape shape = charts(2);
  const auto expected = triangles(*with_bits(shape, 12));
  // Turned faces are turned back with their texture coordinates.
  for (const size_t f : {0u, 9u, 20u, 47u}) std::swap(shape.faces[3 * f + 1], shape.faces[3 * f + 2]);
  fvv_mesh_report report = empty_report();
  const auto turned = with_bits(shape, 12, &report);
  CHECK(report.flipped_faces == 4);
  const bool same = triangles(*turned) == expected;
  CHECK(same);

  // A copy of face 3 with other texture coordinates is a duplicate, the first stays.
  for (size_t c = 0; c < 3; c++) {
    const size_t v = shape.faces[9 + c];
    for (size_t k = 0; k < 3; k++) shape.positions.push_back(shape.positions[3 * v + k]);
    shape.texture.insert(shape.texture.end(), {0.25, 0.75});
    shape.faces.push_back(uint32_t(shape.positions.size() / 3 - 1));
  }
  // Two corners of one place with different texture coordinates: no area.
  const uint32_t last = uint32_t(shape.positions.size() / 3);
  shape.point(shape.positions[0], shape.positions[1], shape.positions[2]);
  shape.texture.insert(shape.texture.end(), {0.9, 0.9});
  shape.face(0, last, 4);
  const auto mended = with_bits(shape, 12, &report);
  CHECK(report.duplicate_faces == 1);
  CHECK(report.degenerate_faces == 1);
  CHECK(report.unreferenced_vertices == 4);
  const bool same_again = triangles(*mended) == expected;
  CHECK(same_again);

  // The cube is one component of 48 faces, not six of 8; a lone triangle is a speck.
  const uint32_t first = uint32_t(shape.positions.size() / 3);
  for (const double x : {3.0, 4.0, 5.0}) {
    shape.point(x, x * x, 0);
    shape.texture.insert(shape.texture.end(), {0.1 * x, 0.5});
  }
  shape.faces.insert(shape.faces.begin(), {first, first + 1, first + 2});
  fvv_mesh_options o = options(12);
  o.min_component_faces = 48;
  const fvv_mesh_source source = shape.source();
  Mesh kept;
  REQUIRE(fvv_mesh_canonicalise(&source, &o, nullptr, &kept, &report, nullptr) == FVV_OK);
  CHECK((report.dropped_components == 1 && report.dropped_component_faces == 1));
  const bool same_kept = triangles(kept) == expected;
  CHECK(same_kept);
}

TEST_CASE("texture coordinates outside the picture are refused by name, but for rounding") {
  const double inf = std::numeric_limits<double>::infinity(), tolerance = 1.0 / 65536;
  Shape shape = projected(tetrahedron());
  const auto at = [&](size_t i, double x) {
    Shape bad = shape;
    bad.texture[i] = x;
    return bad;
  };
  CHECK(refusal(at(5, std::nan("")), options(12), 0) ==
        "vertex 2: texture coordinate v is NaN, not a finite number");
  CHECK(refusal(at(0, -inf), options(12), 0) ==
        "vertex 0: texture coordinate u is -infinity, not a finite number");
  CHECK(refusal(at(7, inf), options(12), 0) ==
        "vertex 3: texture coordinate v is infinity, not a finite number");
  CHECK(refusal(at(6, 1.5), options(12), 3015) == "vertex 3: texture coordinate u = 1.5 is outside 0 to 1");
  CHECK(refusal(at(3, -0.01), options(12), 3015) ==
        "vertex 1: texture coordinate v = -0.01 is outside 0 to 1");
  refusal(at(3, std::nextafter(-tolerance, -1)), options(12), 3015);
  refusal(at(3, std::nextafter(1 + tolerance, 2)), options(12), 3015);
  fvv_mesh_report report = empty_report();
  const auto low = with_bits(at(3, -tolerance), 16, &report);
  CHECK((low->texture[3] == 0 && report.clamped_vertices == 1));
  const auto high = with_bits(at(3, 1 + tolerance), 16, &report);
  CHECK((high->texture[3] == 65536 && report.clamped_vertices == 1));
  // Not used without coordinates.
  (void)with_bits(at(5, std::nan("")), 0);
  CHECK(refusal(shape, options(17), 0, FVV_ERROR_ARGUMENT) == "17 bits for a texture index, at most 16");
  refusal(shape, options(UINT32_MAX), 0, FVV_ERROR_ARGUMENT);
}

TEST_CASE("texture coordinates come back from every profile and level", "[slow][long]") {
  for (const Named &named : textured())
    for (const uint32_t bits : {1u, 12u, 16u}) {
      const auto mesh = with_bits(named.shape, bits, nullptr, named.step);
      const auto expected = triangles(*mesh);
      const bool large = mesh->face_count > 10000;
      for (int level = -2; level <= 10; level += large ? 4 : 1) {
        INFO(named.name << ", " << bits << " bits, level " << level);
        const uint8_t profile = profile_of(level);
        const auto payload = encoded(*mesh, profile, std::max(level, 0));
        const bool same_again = payload == encoded(*mesh, profile, std::max(level, 0));
        CHECK(same_again);
        Mesh back;
        fvv_diagnostic diagnostic = {};
        REQUIRE(decode(payload, &back, &diagnostic) == FVV_OK);
        CHECK(back.texture_bits == bits);
        const bool same_triangles = triangles(back) == expected;
        CHECK(same_triangles);
        fvv_mesh_header header;
        REQUIRE(fvv_mesh_peek(payload.data(), payload.size(), nullptr, &header, &diagnostic) == FVV_OK);
        CHECK(header.texture_bits == bits);
      }
    }
}

TEST_CASE("the raw profile has texture indices between positions and faces") {
  const auto mesh = with_bits(charts(1), 3);
  const auto payload = encoded(*mesh, FVV_MESH_RAW, 0);
  REQUIRE(payload.size() == 16 + 24 * 20 + 12 * 12);
  CHECK((payload[0] == 0 && payload[1] == 1 && payload[2] == 3 && payload[3] == 0));
  CHECK(memcmp(payload.data() + 16, mesh->lattice, 24 * 12) == 0);
  CHECK(memcmp(payload.data() + 16 + 24 * 12, mesh->texture, 24 * 8) == 0);
  CHECK(memcmp(payload.data() + 16 + 24 * 20, mesh->faces, 12 * 12) == 0);
}

TEST_CASE("the encoder refuses texture indices that no reader would take") {
  const auto refused = [](const fvv_mesh &mesh, uint32_t issue) {
    for (const uint8_t profile : {FVV_MESH_RAW, FVV_MESH_DRACO, FVV_MESH_FAST}) {
      Bytes payload;
      fvv_diagnostic diagnostic = {};
      CHECK(fvv_mesh_encode(&mesh, profile, 5, nullptr, &payload, &diagnostic) == FVV_ERROR_INPUT);
      CHECK(diagnostic.issue == issue);
      CHECK(payload.size == 0);
    }
  };
  const auto mesh = with_bits(charts(1), 4);
  mesh->texture[9] = 17;
  refused(*mesh, 3015);
  mesh->texture[9] = 16;
  for (const uint8_t bits : {0, 17, 200}) {
    mesh->texture_bits = bits;
    refused(*mesh, 3014);
  }
  uint32_t *texture = mesh->texture;
  mesh->texture = nullptr;
  mesh->texture_bits = 4;
  refused(*mesh, 3014);
  mesh->texture = texture;
}

TEST_CASE("texture coordinates and failed allocations") {
  const fvv_allocator allocator = memory::allocator();
  const Shape shape = charts(6);
  const fvv_mesh_source source = shape.source();
  const fvv_mesh_options o = options(12);
  const auto mesh = canonical(shape);
  for (const int what : {0, 1, 2, 3, 4}) { // canonicalise; encode and decode raw; the same with Draco
    const uint8_t profile = what > 2 ? FVV_MESH_DRACO : FVV_MESH_RAW;
    const auto payload = encoded(*mesh, profile, 7);
    const size_t before = memory::state.live;
    fvv_status status = FVV_ERROR_MEMORY;
    int64_t n = 0;
    bool leaked = false, reported = true, empty = true;
    for (; status == FVV_ERROR_MEMORY && n < 100000 && !leaked; n++) {
      fvv_mesh back = {};
      fvv_bytes bytes = {};
      fvv_diagnostic diagnostic = {};
      // As for positions: a destructor of Draco's encoder allocates 16 bytes and ends the process without.
      memory::reset(n, what == 3 ? 32 : 0);
      if (what == 0)
        status = fvv_mesh_canonicalise(&source, &o, &allocator, &back, nullptr, &diagnostic);
      else if (what % 2)
        status = fvv_mesh_encode(mesh.get(), profile, 7, &allocator, &bytes, &diagnostic);
      else
        status = fvv_mesh_decode(payload.data(), payload.size(), nullptr, &allocator, &back, &diagnostic);
      memory::reset();
      reported = reported && diagnostic.status == status;
      if (status != FVV_OK) empty = empty && !bytes.size && !back.lattice && !back.texture;
      fvv_mesh_free(&back);
      fvv_bytes_free(&bytes);
      leaked = memory::state.live != before;
    }
    INFO("case " << what << ", " << n << " allocations");
    CHECK(status == FVV_OK);
    CHECK(n > 3);
    CHECK(reported);
    CHECK(empty);
    CHECK_FALSE(leaked);
  }
}

TEST_CASE("texture coordinates in sequential bitstreams of other encoders are read") {
  DracoOptions sequential;
  sequential.sequential = true;
  const auto mesh = with_bits(projected(grid(40)), 14, nullptr, 1e-7);
  Mesh back;
  fvv_diagnostic diagnostic = {};
  REQUIRE(decode(draco_payload(*mesh, sequential), &back, &diagnostic) == FVV_OK);
  const bool same_triangles = triangles(back) == triangles(*mesh);
  CHECK(same_triangles);
}

TEST_CASE("texture coordinates of a dense chart cost at most 13 of 24 bits") {
  const auto plain = canonical(torus(132, 133, 0.5), 0.0009);
  const auto mesh = with_bits(projected(torus(132, 133, 0.5)), 12, nullptr, 0.0009);
  for (const int level : {0, 5, 7, 10}) {
    const size_t without = encoded(*plain, FVV_MESH_DRACO, level).size();
    const size_t with = encoded(*mesh, FVV_MESH_DRACO, level).size();
    const double bits = 8.0 * double(with - without) / mesh->vertex_count;
    std::printf("level %2d: %zu bytes, %zu with texture coordinates of 12 bits: %.2f bits a vertex more\n",
                level, without, with, bits);
    if (level >= 5) CHECK(bits < 13);
  }
}
