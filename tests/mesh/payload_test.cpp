// MESH payloads: round trips, what the encoder refuses, memory.
#include "fvv_catch.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>

#include "draco_direct.h"
#include "memory.h"
#include "shapes.h"

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

TEST_CASE("every shape comes back from every profile and level with the same triangles") {
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

TEST_CASE("surfaces with hundreds of handles come back") {
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
  CHECK(memcmp(back.positions, mesh->positions, 12 * size_t(mesh->vertex_count)) == 0);
  CHECK(memcmp(back.faces, mesh->faces, 12 * size_t(mesh->face_count)) == 0);
}

TEST_CASE("Draco splits vertices where the surface is no manifold, and the header says so") {
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

TEST_CASE("a plane that codes to next to nothing is coded within the density") {
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
  mesh->positions[0] = FVV_LATTICE_MAX + 1;
  refused(*mesh, 3006);
  mesh->positions[0] = 0;
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

TEST_CASE("sequential bitstreams of other encoders are read") {
  for (const uint32_t n : {4u, 20u, 300u})
    for (const bool compressed : {true, false}) {
      // Fine enough that a face takes more than 3 bytes: Draco refuses its own shorter ones.
      const auto mesh = canonical(grid(n), 1e-7);
      DracoOptions options;
      options.sequential = true;
      options.compressed_indices = compressed;
      Mesh back;
      fvv_diagnostic diagnostic = {};
      const fvv_status status = decode(draco_payload(*mesh, options), &back, &diagnostic);
      INFO(n << ": " << diagnostic.message);
      REQUIRE(status == FVV_OK);
      const bool same_triangles = triangles(back) == triangles(*mesh);
      CHECK(same_triangles);
    }
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
      bool leaked = false, told = true, empty = true;
      for (; status == FVV_ERROR_MEMORY && n < 100000 && !leaked; n++) {
        fvv_mesh back = {};
        fvv_bytes bytes = {};
        fvv_diagnostic diagnostic = {};
        // A destructor of Draco 1.5's encoder allocates 16 bytes (RAnsBitEncoder): when these fail the
        // process ends whatever we do, so that encoding is tested with failures of larger blocks.
        memory::reset(n, encoding ? 32 : 0);
        status = encoding ? fvv_mesh_encode(mesh.get(), profile, 10, &allocator, &bytes, &diagnostic)
                          : fvv_mesh_decode(payload.data(), payload.size(), nullptr, &allocator, &back,
                                            &diagnostic);
        memory::reset();
        told = told && diagnostic.status == status;
        if (status != FVV_OK) empty = empty && !bytes.size && !back.positions && !back.vertex_count;
        fvv_mesh_free(&back);
        fvv_bytes_free(&bytes);
        leaked = memory::state.live != before;
      }
      INFO("profile " << int(profile) << (encoding ? " encoding " : " decoding ") << n);
      CHECK(status == FVV_OK);
      CHECK(n > (profile == FVV_MESH_RAW ? 1 : 30));
      CHECK(told);
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
