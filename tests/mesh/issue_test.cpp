// One faulty MESH payload at least for each issue from 3001 to 3015, and for the limits.
#include "fvv_catch.h"

#include <algorithm>
#include <string>

#include "draco_direct.h"
#include "shapes.h"

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
  CHECK(mesh.positions == nullptr);
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
  for (const uint8_t profile : {3, 5, 255}) {
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
  mesh->positions[5] = FVV_LATTICE_MAX + 1;
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
