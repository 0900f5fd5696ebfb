// MESH payloads: round trips, what the encoder refuses, memory, and a faulty payload at least for each rule.
#include "draco_direct.h"
#include "fvv_catch.h"
#include "memory.h"
#include "shapes.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>

namespace {

struct Named {
  const char *name;
  Shape shape;
  double step;
};

std::vector<Named> shapes() {
  Shape far = tetrahedron(2.0 * FVV_LATTICE_MAX);
  for (double &x : far.positions) x -= FVV_LATTICE_MAX;
  Shape triangle;
  triangle.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  triangle.faces = {0, 1, 2};
  return {{"triangle", triangle, 0.001},
          {"sphere", sphere(24, 16), 0.001},
          {"grid", grid(20), 0.001},
          {"torus", torus(40, 20), 0.001},
          {"two components", two_components(), 0.001},
          {"few holes", ragged(40, 20, 20), 0.001},
          {"many holes", ragged(60, 20, 3), 0.001},
          {"half", ragged(60, 40, 2), 0.01},
          {"fin", fin(), 0.001},
          {"bow-tie", bow_tie(), 0.001},
          {"flat grid", grid(60, 0), 0.01},
          {"at the lattice's bounds", far, 1},
          {"coarse", torus(40, 20), 0.05}};
}

} // namespace

TEST_CASE("every shape comes back from every profile and level with the same triangles", "[slow]") {
  for (const Named &named : shapes()) {
    INFO(named.name);
    const auto mesh = canonical(named.shape, named.step);
    const auto expected = triangles(*mesh);
    for (int level = -2; level <= 10; level++) {
      INFO("level " << level);
      const uint8_t profile = profile_of(level);
      const auto payload = encoded(*mesh, profile, std::max(level, 0));
      const bool same_again = payload == encoded(*mesh, profile, std::max(level, 0));
      CHECK(same_again);
      Mesh back;
      fvv_diagnostic diagnostic = {};
      REQUIRE(decode(payload, &back, &diagnostic) == FVV_OK);
      const bool same_triangles = triangles(back) == expected;
      CHECK(same_triangles);
      fvv_mesh_header header;
      REQUIRE(fvv_mesh_peek(payload.data(), payload.size(), nullptr, &header, &diagnostic) == FVV_OK);
      CHECK(header.profile == profile);
      CHECK(header.vertex_count == back.vertex_count);
      CHECK(header.face_count == back.face_count);
      CHECK(header.data_size == payload.size() - 16);
      // What was decoded is canonical: it can be coded again, and then stays as large as it is.
      const auto again = encoded(back, profile, std::max(level, 0));
      Mesh twice;
      REQUIRE(decode(again, &twice, &diagnostic) == FVV_OK);
      CHECK(twice.vertex_count == back.vertex_count);
    }
  }
}

TEST_CASE("surfaces with hundreds of handles come back", "[slow]") {
  for (const double filled : {0.2, 0.4, 0.6, 0.8})
    for (uint32_t seed = 1; seed <= 4; seed++) {
      INFO("filled " << filled << ", seed " << seed);
      const auto mesh = canonical(sponge(12, filled, seed), 0.01);
      const auto expected = triangles(*mesh);
      for (const int level : {0, 5, 7, 10}) {
        INFO("level " << level);
        Mesh back;
        fvv_diagnostic diagnostic = {};
        REQUIRE(decode(encoded(*mesh, FVV_MESH_DRACO, level), &back, &diagnostic) == FVV_OK);
        const bool same_triangles = triangles(back) == expected;
        CHECK(same_triangles);
      }
    }
}

TEST_CASE("the raw profile keeps the order of vertices and faces") {
  const auto mesh = canonical(sphere(12, 8));
  const auto payload = encoded(*mesh, FVV_MESH_RAW, 5);
  CHECK(payload.size() == 16 + 12 * (size_t(mesh->vertex_count) + mesh->face_count));
  Mesh back;
  fvv_diagnostic diagnostic = {};
  REQUIRE(decode(payload, &back, &diagnostic) == FVV_OK);
  CHECK(memcmp(back.lattice, mesh->lattice, 12 * size_t(mesh->vertex_count)) == 0);
  CHECK(memcmp(back.faces, mesh->faces, 12 * size_t(mesh->face_count)) == 0);
}

TEST_CASE("Draco splits vertices where the surface is no manifold, and the header counts them") {
  const auto bow = canonical(bow_tie());
  CHECK(bow->vertex_count == 7);
  const auto payload = encoded(*bow, FVV_MESH_DRACO, 7);
  CHECK(payload[4] == 8);
  Mesh back;
  fvv_diagnostic diagnostic = {};
  REQUIRE(decode(payload, &back, &diagnostic) == FVV_OK);
  CHECK(back.vertex_count == 8);
  CHECK(back.face_count == 8);
}

TEST_CASE("a plane that codes to next to nothing is coded within the density", "[slow][long]") {
  const auto mesh = canonical(grid(300, 0), 0.01);
  const auto payload = encoded(*mesh, FVV_MESH_DRACO, 10);
  const size_t size = payload.size() - 16;
  CHECK(mesh->face_count <= 16 * size);
  CHECK(size < mesh->face_count); // and still in less than a byte a face
  Mesh back;
  fvv_diagnostic diagnostic = {};
  REQUIRE(decode(payload, &back, &diagnostic) == FVV_OK);
  const bool same_triangles = triangles(back) == triangles(*mesh);
  CHECK(same_triangles);
}

TEST_CASE("positions at the lattice's bounds cost no more memory than others") {
  Shape far = tetrahedron(2.0 * FVV_LATTICE_MAX);
  for (double &x : far.positions) x -= FVV_LATTICE_MAX;
  const auto mesh = canonical(far, 1);
  for (int level = 0; level <= 10; level++) {
    memory::reset();
    const size_t before = memory::state.live;
    (void)encoded(*mesh, FVV_MESH_DRACO, level);
    const size_t peak = memory::state.peak - before;
    CHECK(peak < 1 << 20);
  }
}

TEST_CASE("a mesh whose edgebreaker symbols would be too slow is coded without them") {
  const auto mesh = canonical(holed_hubs(3000), 1e-4);
  const auto payload = encoded(*mesh, FVV_MESH_DRACO, 7);
  CHECK(payload[24] == 0); // sequential
  Mesh back;
  fvv_diagnostic diagnostic = {};
  REQUIRE(decode(payload, &back, &diagnostic) == FVV_OK);
  const bool same_triangles = triangles(back) == triangles(*mesh);
  CHECK(same_triangles);
}

TEST_CASE("the encoder refuses meshes that no reader would take") {
  const auto refused = [](const fvv_mesh &mesh, uint32_t issue) {
    for (const uint8_t profile : {FVV_MESH_RAW, FVV_MESH_DRACO, FVV_MESH_FAST}) {
      Bytes payload;
      fvv_diagnostic diagnostic = {};
      CHECK(fvv_mesh_encode(&mesh, profile, 5, nullptr, &payload, &diagnostic) == FVV_ERROR_INPUT);
      CHECK(diagnostic.issue == issue);
      CHECK(payload.size == 0);
    }
  };
  const auto mesh = canonical(tetrahedron());
  mesh->faces[4] = 4;
  refused(*mesh, 3005);
  mesh->faces[4] = mesh->faces[5];
  refused(*mesh, 3005);
  mesh->faces[4] = 1;
  mesh->lattice[0] = FVV_LATTICE_MAX + 1;
  refused(*mesh, 3006);
  mesh->lattice[0] = 0;
  mesh->face_count = 1;
  refused(*mesh, 3011);
  mesh->face_count = 0;
  refused(*mesh, 3003);
  mesh->face_count = 4;
  Bytes payload;
  CHECK(fvv_mesh_encode(mesh.get(), FVV_MESH_DELTA, 5, nullptr, &payload, nullptr) == FVV_ERROR_ARGUMENT);
  for (const int level : {-1, 11})
    CHECK(fvv_mesh_encode(mesh.get(), FVV_MESH_DRACO, level, nullptr, &payload, nullptr) ==
          FVV_ERROR_ARGUMENT);
  CHECK(fvv_mesh_encode(mesh.get(), FVV_MESH_DRACO, 5, nullptr, &payload, nullptr) == FVV_OK);
}

TEST_CASE("encoder and decoder survive every failed allocation, Draco's too") {
  const fvv_allocator allocator = memory::allocator();
  const auto mesh = canonical(torus(40, 20));
  for (const uint8_t profile : {FVV_MESH_RAW, FVV_MESH_DRACO}) {
    const auto payload = encoded(*mesh, profile, 10);
    for (const bool encoding : {true, false}) {
      const size_t before = memory::state.live;
      fvv_status status = FVV_ERROR_MEMORY;
      int64_t n = 0;
      bool leaked = false, reported = true, empty = true;
      for (; status == FVV_ERROR_MEMORY && n < 100000 && !leaked; n++) {
        fvv_mesh back = {};
        fvv_bytes bytes = {};
        fvv_diagnostic diagnostic = {};
        // A destructor of Draco 1.5's encoder allocates 16 bytes (RAnsBitEncoder): when these fail the
        // process ends in any case, so that encoding is tested with failures of larger blocks.
        memory::reset(n, encoding ? 32 : 0);
        status = encoding ? fvv_mesh_encode(mesh.get(), profile, 10, &allocator, &bytes, &diagnostic)
                          : fvv_mesh_decode(payload.data(), payload.size(), nullptr, &allocator, &back,
                                            &diagnostic);
        memory::reset();
        reported = reported && diagnostic.status == status;
        if (status != FVV_OK) empty = empty && !bytes.size && !back.lattice && !back.vertex_count;
        fvv_mesh_free(&back);
        fvv_bytes_free(&bytes);
        leaked = memory::state.live != before;
      }
      INFO("profile " << int(profile) << (encoding ? " encoding " : " decoding ") << n);
      CHECK(status == FVV_OK);
      CHECK(n > (profile == FVV_MESH_RAW ? 1 : 30));
      CHECK(reported);
      CHECK(empty);
      CHECK_FALSE(leaked);
    }
  }
}

TEST_CASE("a smooth hull of 35,000 triangles costs at most 20 bits a vertex") {
  // 1.9 m across at 0.9 mm: 11 bits; 17,556 vertices, those along the surface irregular as in a real hull.
  const auto mesh = canonical(torus(132, 133, 0.5), 0.0009);
  for (const int level : {0, 5, 7, 10}) {
    const auto begin = std::chrono::steady_clock::now();
    const auto payload = encoded(*mesh, FVV_MESH_DRACO, level);
    const auto middle = std::chrono::steady_clock::now();
    Mesh back;
    fvv_diagnostic diagnostic = {};
    REQUIRE(decode(payload, &back, &diagnostic) == FVV_OK);
    const auto end = std::chrono::steady_clock::now();
    const double bits = 8.0 * double(payload.size()) / mesh->vertex_count;
    const auto ms = [](auto d) { return std::chrono::duration<double, std::milli>(d).count(); };
    std::printf("level %2d: %u faces, %zu bytes, %.2f bits a vertex, encode %.1f ms, decode %.1f ms\n", level,
                mesh->face_count, payload.size(), bits, ms(middle - begin), ms(end - middle));
    if (level == 7) CHECK(bits < 20);
  }
}

// ---- One faulty MESH payload at least for each issue from 3001 to 3015, and for the limits.

namespace {

void put_u32(std::vector<uint8_t> &payload, size_t offset, uint32_t value) {
  for (int i = 0; i < 4; i++) payload[offset + size_t(i)] = uint8_t(value >> (8 * i));
}

void check_issue(const std::vector<uint8_t> &payload, uint32_t issue, fvv_status status = FVV_ERROR_INVALID) {
  Mesh mesh;
  fvv_diagnostic diagnostic = {};
  const fvv_status found = decode(payload, &mesh, &diagnostic);
  INFO(diagnostic.message);
  CHECK(found == status);
  CHECK(diagnostic.status == status);
  CHECK(diagnostic.issue == issue);
  CHECK(diagnostic.chunk_type == FVV_CHUNK_MESH);
  CHECK(diagnostic.message[0] != 0);
  CHECK(mesh.lattice == nullptr);
  CHECK(mesh.faces == nullptr);
  CHECK(mesh.vertex_count == 0);
  CHECK(mesh.face_count == 0);
}

} // namespace

TEST_CASE("3001: header and reserved bytes") {
  auto payload = encoded(*canonical(tetrahedron()), FVV_MESH_RAW, 0);
  for (size_t size = 0; size < 16; size++)
    check_issue({payload.begin(), payload.begin() + ptrdiff_t(size)}, 3001);
  for (const size_t offset : {12, 13, 14, 15}) {
    auto bad = payload;
    bad[offset] = 1;
    check_issue(bad, 3001);
  }
}

TEST_CASE("3002: unknown profiles and attributes") {
  auto payload = encoded(*canonical(tetrahedron()), FVV_MESH_RAW, 0);
  for (const uint8_t profile : {3, 6, 255}) {
    payload[0] = profile;
    check_issue(payload, 3002, FVV_ERROR_UNSUPPORTED);
  }
  payload[0] = FVV_MESH_RAW;
  for (const uint8_t attributes : {4, 5, 0x80}) {
    payload[1] = attributes;
    check_issue(payload, 3002, FVV_ERROR_UNSUPPORTED);
  }
}

TEST_CASE("3003: a mesh has vertices and faces") {
  auto payload = encoded(*canonical(tetrahedron()), FVV_MESH_RAW, 0);
  put_u32(payload, 4, 2);
  check_issue(payload, 3003);
  put_u32(payload, 4, 4);
  put_u32(payload, 8, 0);
  check_issue(payload, 3003);
}

TEST_CASE("3004: a raw payload has its exact size") {
  auto payload = encoded(*canonical(tetrahedron()), FVV_MESH_RAW, 0);
  payload.push_back(0);
  check_issue(payload, 3004);
  payload.resize(payload.size() - 2);
  check_issue(payload, 3004);
  payload.push_back(0);
  put_u32(payload, 4, 5);
  check_issue(payload, 3004);
}

TEST_CASE("3005: face indices are in range and differ") {
  const auto payload = encoded(*canonical(tetrahedron()), FVV_MESH_RAW, 0);
  for (const uint32_t index : {4u, 0xffffffffu}) {
    auto bad = payload;
    put_u32(bad, 16 + 48 + 12 + 4, index);
    check_issue(bad, 3005);
  }
  auto bad = payload; // face 1 is 0 1 3
  put_u32(bad, 16 + 48 + 12 + 4, 3);
  check_issue(bad, 3005);
  Mesh mesh;
  fvv_diagnostic diagnostic = {};
  CHECK(decode(bad, &mesh, &diagnostic) == FVV_ERROR_INVALID);
  CHECK(diagnostic.offset == 16 + 48 + 12);
  CHECK(std::string(diagnostic.message) == "face 1: corners 0, 3 and 3 are not three different vertices");
}

TEST_CASE("3006: positions lie within the lattice") {
  auto mesh = canonical(tetrahedron());
  const auto payload = encoded(*mesh, FVV_MESH_RAW, 0);
  for (const int32_t index : {FVV_LATTICE_MAX + 1, -FVV_LATTICE_MAX - 1, INT32_MIN}) {
    auto bad = payload;
    put_u32(bad, 16 + 12 + 8, uint32_t(index));
    check_issue(bad, 3006);
  }
  mesh->lattice[5] = FVV_LATTICE_MAX + 1;
  check_issue(draco_payload(*mesh, {}), 3006);
}

TEST_CASE("3007: the Draco header") {
  const auto mesh = canonical(tetrahedron());
  const auto payload = encoded(*mesh, FVV_MESH_DRACO, 5);
  const struct {
    size_t offset;
    uint8_t value;
  } cases[] = {{16, 'd'}, {20, 'A'}, {21, 1}, {21, 3}, {22, 1},   {22, 3},
               {23, 0},   {23, 2},   {24, 2}, {25, 1}, {26, 0x80}};
  for (const auto &c : cases) {
    auto bad = payload;
    bad[c.offset] = c.value;
    check_issue(bad, 3007);
  }
  auto bad = payload;
  bad.resize(26);
  check_issue(bad, 3007);
  check_issue(draco_payload(*mesh,
                            [] {
                              DracoOptions o;
                              o.metadata = true;
                              return o;
                            }()),
              3007);
}

TEST_CASE("3008: the counts are those of the MESH header") {
  auto payload = encoded(*canonical(tetrahedron()), FVV_MESH_DRACO, 5);
  for (const size_t offset : {4, 8})
    for (const int change : {-1, 1}) {
      auto bad = payload;
      bad[offset] = uint8_t(bad[offset] + change);
      check_issue(bad, 3008);
    }
  // Both say 5 vertices; the symbols make four.
  payload[4] = 5;
  payload[28] = 5;
  check_issue(payload, 3009);
}

TEST_CASE("3009: the Draco bitstream is whole and ends where the payload does") {
  const auto mesh = canonical(torus(40, 20));
  for (const int level : {0, 5, 8, 10}) {
    auto payload = encoded(*mesh, FVV_MESH_DRACO, level);
    payload.push_back(0);
    check_issue(payload, 3009);
    payload.resize(payload.size() - 2);
    check_issue(payload, 3009);
    payload.resize(payload.size() - 200);
    check_issue(payload, 3009);
  }
  auto payload = encoded(*mesh, FVV_MESH_DRACO, 5);
  payload[27] = 1; // the deprecated traversal
  check_issue(payload, 3009);
}

TEST_CASE("sequential bitstreams of other encoders are read, with corners as they are", "[slow]") {
  for (const uint32_t n : {4u, 20u, 300u}) {
    // Fine enough that a face takes more than 3 bytes: Draco refuses its own shorter ones.
    const auto mesh = canonical(grid(n), 1e-7);
    DracoOptions options;
    options.sequential = true;
    Mesh back;
    fvv_diagnostic diagnostic = {};
    const fvv_status status = decode(draco_payload(*mesh, options), &back, &diagnostic);
    INFO(n << ": " << diagnostic.message);
    REQUIRE(status == FVV_OK);
    const bool same_triangles = triangles(back) == triangles(*mesh);
    CHECK(same_triangles);
    options.compressed_indices = true;
    check_issue(draco_payload(*mesh, options), 3009);
  }
}

TEST_CASE("3010: the second attribute is int32 texture coordinates, if they are declared") {
  const auto plain = canonical(tetrahedron()), textured = canonical(charts(2));
  for (const bool sequential : {false, true}) {
    DracoOptions options;
    options.sequential = sequential;
    Mesh back;
    fvv_diagnostic diagnostic = {};
    CHECK(decode(draco_payload(*textured, options), &back, &diagnostic) == FVV_OK);
    // Declared and not there, there and not declared.
    auto bad = draco_payload(*plain, options);
    bad[1] = 1;
    bad[2] = 12;
    check_issue(bad, 3010);
    bad = draco_payload(*textured, options);
    bad[1] = bad[2] = 0;
    check_issue(bad, 3010);
    options.normals = true;
    check_issue(draco_payload(*textured, options), 3010);
    bad = draco_payload(*plain, options); // a second attribute of the wrong kind
    bad[1] = 1;
    bad[2] = 12;
    check_issue(bad, 3010);
  }
  DracoOptions seams;
  seams.single_connectivity = false;
  check_issue(draco_payload(*textured, seams), 3010);
  const auto payload = encoded(*textured, FVV_MESH_DRACO, 5);
  const uint8_t descriptor[] = {2, 0, 5, 3, 0, 0, 3, 5, 2, 0, 1, 1, 1};
  const auto at = std::search(payload.begin(), payload.end(), descriptor, descriptor + 13) - payload.begin();
  REQUIRE(size_t(at) + 13 < payload.size());
  for (const ptrdiff_t i : {0, 6, 7, 8, 9, 11, 12}) {
    auto bad = payload;
    bad[size_t(at + i)]++;
    check_issue(bad, 3010);
  }
}

TEST_CASE("3009: texture coordinates are not predicted from positions") {
  DracoOptions options;
  options.portable_prediction = true;
  const auto payload = draco_payload(*canonical(charts(6)), options);
  check_issue(payload, 3009);
  Mesh mesh;
  fvv_diagnostic diagnostic = {};
  CHECK(decode(payload, &mesh, &diagnostic) == FVV_ERROR_INVALID);
  CHECK(std::string(diagnostic.message) ==
        "texture coordinates predicted by method 5, which is not one for them");
}

TEST_CASE("3010: the only attribute is int32 positions") {
  const auto mesh = canonical(tetrahedron());
  DracoOptions floats, normals;
  floats.floats = true;
  normals.normals = true;
  check_issue(draco_payload(*mesh, floats), 3010);
  check_issue(draco_payload(*mesh, normals), 3010);
  floats.sequential = normals.sequential = true;
  check_issue(draco_payload(*mesh, floats), 3010);
  check_issue(draco_payload(*mesh, normals), 3010);
  const auto payload = encoded(*mesh, FVV_MESH_DRACO, 5);
  const uint8_t descriptor[] = {1, 0, 5, 3, 0};
  const auto at = std::search(payload.begin(), payload.end(), descriptor, descriptor + 5) - payload.begin();
  for (const ptrdiff_t i : {0, 1, 2, 3, 4, 6}) {
    auto bad = payload;
    bad[size_t(at + i)]++;
    check_issue(bad, 3010);
  }
}

TEST_CASE("3011: every vertex is used") {
  auto mesh = canonical(tetrahedron());
  auto payload = encoded(*mesh, FVV_MESH_RAW, 0);
  put_u32(payload, 4, 5);
  payload.insert(payload.begin() + 16 + 48, 12, 0);
  check_issue(payload, 3011);
}

TEST_CASE("3012: the counts are within what the bytes can carry") {
  auto payload = encoded(*canonical(tetrahedron()), FVV_MESH_DRACO, 5);
  const uint32_t most = uint32_t(16 * (payload.size() - 16));
  for (const size_t offset : {4, 8}) {
    auto bad = payload;
    put_u32(bad, offset, most + 1);
    check_issue(bad, 3012);
    put_u32(bad, offset, most);
    check_issue(bad, 3008);
  }
}

TEST_CASE("3014: texture bits go with texture coordinates") {
  auto payload = encoded(*canonical(tetrahedron()), FVV_MESH_RAW, 0);
  for (const uint8_t bits : {1, 16, 255}) {
    payload[2] = bits;
    check_issue(payload, 3014);
  }
  const auto mesh = canonical(charts(2));
  for (const uint8_t profile : {FVV_MESH_RAW, FVV_MESH_DRACO}) {
    payload = encoded(*mesh, profile, 5);
    CHECK(payload[1] == 1);
    CHECK(payload[2] == 12);
    for (const uint8_t bits : {0, 17, 255}) {
      payload[2] = bits;
      check_issue(payload, 3014);
    }
  }
}

TEST_CASE("3015: texture indices are within 2^bits") {
  auto mesh = canonical(charts(2));
  const auto raw = encoded(*mesh, FVV_MESH_RAW, 0);
  const size_t third = 16 + 12 * size_t(mesh->vertex_count) + 8 * 3;
  for (const uint32_t index : {4097u, 0x80000000u, 0xffffffffu}) {
    auto bad = raw;
    put_u32(bad, third + 4, index);
    check_issue(bad, 3015);
    Mesh back;
    fvv_diagnostic diagnostic = {};
    CHECK(decode(bad, &back, &diagnostic) == FVV_ERROR_INVALID);
    CHECK(diagnostic.offset == third);
    CHECK(std::string(diagnostic.message) == "vertex 3: v index " + std::to_string(index) + " is above 2^12");
  }
  // The far edge is inside.
  auto edge = raw;
  put_u32(edge, third + 4, 4096);
  Mesh back;
  fvv_diagnostic diagnostic = {};
  CHECK(decode(edge, &back, &diagnostic) == FVV_OK);
  for (const uint32_t index : {4097u, 0xffffffffu}) {
    mesh->texture[7] = index;
    check_issue(draco_payload(*mesh, {}), 3015);
  }
}

TEST_CASE("7001: limits") {
  const auto mesh = canonical(tetrahedron());
  for (const uint8_t profile : {FVV_MESH_RAW, FVV_MESH_DRACO}) {
    const auto payload = encoded(*mesh, profile, 5);
    fvv_limits limits;
    fvv_limits_default(&limits);
    limits.max_vertices = limits.max_faces = 4;
    Mesh fits, refused;
    fvv_diagnostic diagnostic = {};
    CHECK(fvv_mesh_decode(payload.data(), payload.size(), &limits, nullptr, &fits, &diagnostic) == FVV_OK);
    limits.max_vertices = 3;
    CHECK(fvv_mesh_decode(payload.data(), payload.size(), &limits, nullptr, &refused, &diagnostic) ==
          FVV_ERROR_LIMIT);
    CHECK(diagnostic.issue == FVV_ISSUE_LIMIT);
    limits.max_vertices = 4;
    limits.max_faces = 3;
    fvv_mesh_header header;
    CHECK(fvv_mesh_peek(payload.data(), payload.size(), &limits, &header, &diagnostic) == FVV_ERROR_LIMIT);
    CHECK(header.vertex_count == 0);
  }
}

TEST_CASE("3013: Draco's decoder takes linear time") {
  check_issue(draco_payload(*canonical(holed_hubs(3000), 1e-4), {}), 3013);
}

TEST_CASE("a mesh that readers with default limits refuse is not encoded") {
  fvv_limits limits;
  fvv_limits_default(&limits);
  // Faces of three vertices each, on a line of the lattice far from each other.
  const uint32_t count = limits.max_vertices / 3 + 1;
  std::vector<int32_t> positions(9 * size_t(count));
  std::vector<uint32_t> faces(3 * size_t(count));
  for (uint32_t f = 0; f < count; f++) {
    const int32_t x = int32_t(2 * f), corners[9] = {x, 0, 0, x + 1, 0, 0, x, 1, 0};
    std::copy_n(corners, 9, &positions[9 * size_t(f)]);
    for (uint32_t c = 0; c < 3; c++) faces[3 * size_t(f) + c] = 3 * f + c;
  }
  for (const uint8_t profile : {FVV_MESH_RAW, FVV_MESH_FAST, FVV_MESH_DRACO}) {
    const fvv_mesh mesh = {positions.data(), faces.data(), 3 * count, count, nullptr, 0, nullptr, 0, {}};
    fvv_bytes payload = {};
    fvv_diagnostic d = {};
    CHECK(fvv_mesh_encode(&mesh, profile, 7, nullptr, &payload, &d) == FVV_ERROR_INPUT);
    CHECK(d.issue == FVV_ISSUE_LIMIT);
    CHECK(std::string(d.message) == "4194306 vertices of a mesh, readers accept at most 4194304");
    CHECK(payload.size == 0);
    fvv_bytes_free(&payload);
  }
}
