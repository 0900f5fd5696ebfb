// The fast profile: meshoptimizer's output follows the specification, and every rule has its issue.
#include "fvv_catch.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include "fast_plain.h"
#include "memory.h"
#include "shapes.h"

extern "C" {
#include "base/bytes.h"
#include "base/crc32c.h"
}

namespace {

using Payload = std::vector<uint8_t>;

void check_issue(const Payload &payload, uint32_t issue) {
  Mesh mesh;
  fvv_diagnostic diagnostic = {};
  CHECK(decode(payload, &mesh, &diagnostic) == FVV_ERROR_INVALID);
  INFO(diagnostic.message);
  CHECK(diagnostic.issue == issue);
  CHECK(mesh.lattice == nullptr);
  CHECK(mesh.faces == nullptr);
}

bool same(const fvv_mesh &a, const fvv_mesh &b) {
  const size_t vertices = a.vertex_count, faces = a.face_count;
  return a.vertex_count == b.vertex_count && a.face_count == b.face_count &&
         a.texture_bits == b.texture_bits && memcmp(a.lattice, b.lattice, 12 * vertices) == 0 &&
         memcmp(a.faces, b.faces, 12 * faces) == 0 &&
         (!a.texture || memcmp(a.texture, b.texture, 8 * vertices) == 0);
}

size_t vertex_stream(const Payload &payload) {
  return size_t(payload[16]) | size_t(payload[17]) << 8 | size_t(payload[18]) << 16;
}

} // namespace

TEST_CASE("what a plain encoder writes comes back as it was, in its order") {
  // 4, 97, 384 and 800 vertices: less than a group, one block, more than one.
  for (const Shape &shape : {tetrahedron(), sphere(12, 9), charts(7), torus(40, 20)}) {
    const auto mesh = canonical(shape);
    Mesh back;
    fvv_diagnostic diagnostic = {};
    const fvv_status status = decode(FastPlain(*mesh).payload(), &back, &diagnostic);
    INFO(mesh->vertex_count << " vertices: " << diagnostic.message);
    REQUIRE(status == FVV_OK);
    const bool equal = same(back, *mesh);
    CHECK(equal);
  }
}

TEST_CASE("meshes of the vector are those of the decoder that was written from the specification") {
  std::ifstream file(FVV_CASES "/vector_fast_shapes/input.fvv", std::ios::binary),
      list(FVV_LISTINGS "/fast_shapes.crc");
  const Payload stream(std::istreambuf_iterator<char>(file), {});
  std::string wanted;
  size_t count = 0;
  for (size_t at = 24; at + 32 <= stream.size();) {
    const size_t size = size_t(fvv_get_u64(&stream[at + 16])), payload = at + 32;
    if (fvv_get_u32(&stream[at]) == FVV_CHUNK_MESH) {
      Mesh mesh;
      fvv_diagnostic diagnostic = {};
      const fvv_status status =
          decode(Payload(&stream[payload], &stream[payload] + size), &mesh, &diagnostic);
      INFO("frame " << count << ": " << diagnostic.message);
      REQUIRE(status == FVV_OK);
      REQUIRE(list >> wanted);
      const Payload raw = encoded(mesh, FVV_MESH_RAW, 0);
      CHECK(fvv_crc32c(0, raw.data() + 16, raw.size() - 16) == std::stoul(wanted, nullptr, 16));
      count++;
    }
    at = payload + (size + 7) / 8 * 8;
  }
  CHECK(count == 4);
}

TEST_CASE("vertices come in the order of their first use") {
  for (const Shape &shape : {torus(40, 20), charts(7), ragged(60, 20, 3), two_components()}) {
    const auto mesh = canonical(shape);
    Mesh back;
    REQUIRE(decode(encoded(*mesh, FVV_MESH_FAST, 0), &back, nullptr) == FVV_OK);
    CHECK(back.vertex_count == mesh->vertex_count);
    // The codec turns faces, so that two new vertices of one face may come in either order.
    uint32_t next = 0;
    bool ordered = true;
    for (size_t f = 0; f < back.face_count; f++) {
      uint32_t corner[3];
      std::copy_n(back.faces + 3 * f, 3, corner);
      std::sort(corner, corner + 3);
      for (const uint32_t vertex : corner) {
        ordered = ordered && vertex <= next;
        next += vertex == next;
      }
    }
    CHECK(ordered);
    CHECK(next == back.vertex_count);
  }
}

TEST_CASE("a smooth hull takes about a byte a face and five a vertex") {
  const auto mesh = canonical(torus(132, 133, 0.5), 0.0009);
  const auto payload = encoded(*mesh, FVV_MESH_FAST, 0);
  const size_t vertices = vertex_stream(payload), faces = payload.size() - 20 - vertices;
  CHECK(double(faces) / mesh->face_count < 1.2);
  CHECK(double(vertices) / mesh->vertex_count < 6);
  CHECK(payload == encoded(*mesh, FVV_MESH_FAST, 10));
}

TEST_CASE("a fast mesh is the key of delta frames") {
  Mesh key;
  REQUIRE(decode(encoded(*canonical(torus(40, 20)), FVV_MESH_FAST, 0), &key, nullptr) == FVV_OK);
  Sequence encoder(key), decoder(key);
  for (int t = 1; t < 4; t++) {
    Bytes payload;
    REQUIRE(fvv_mesh_sequence_encode(encoder.handle, moved(key, t, 2).data(), nullptr, &payload, nullptr) ==
            FVV_OK);
    REQUIRE(fvv_mesh_sequence_decode(decoder.handle, payload.data, payload.size, nullptr) == FVV_OK);
    const bool equal = same(*fvv_mesh_sequence_mesh(encoder.handle), *fvv_mesh_sequence_mesh(decoder.handle));
    CHECK(equal);
  }
}

TEST_CASE("3023: the vertex stream follows its size and fits") {
  const auto mesh = canonical(tetrahedron());
  const Payload payload = FastPlain(*mesh).payload();
  for (size_t size = 16; size < 20; size++)
    check_issue({payload.begin(), payload.begin() + ptrdiff_t(size)}, 3023);
  Payload bad = payload;
  bad[19] = 0x80;
  check_issue(bad, 3023);
  bad = payload;
  const size_t rest = payload.size() - 20;
  bad[16] = uint8_t(rest + 1);
  bad[17] = uint8_t((rest + 1) >> 8);
  check_issue(bad, 3023);
  bad[16] = uint8_t(rest);
  bad[17] = uint8_t(rest >> 8);
  check_issue(bad, 3024);
}

TEST_CASE("3024: the streams have the bytes that the counts ask for") {
  // All vertices on one point, 64 to each byte of a vertex: nothing can be denser.
  constexpr uint8_t vertices = 200, faces = 198;
  Payload flat = {4, 0, 0, 0, vertices, 0, 0, 0, faces, 0, 0, 0, 0, 0, 0, 0, 33 + 12 * 4, 0, 0, 0, 0xa0};
  flat.insert(flat.end(), 12 * 4 + 32, 0);
  flat.push_back(0xe1);
  flat.push_back(0xf0); // 0 1 2, then one vertex more each
  flat.insert(flat.end(), faces - 1, 0x00);
  flat.insert(flat.end(), 16, 0);
  Mesh mesh;
  fvv_diagnostic diagnostic = {};
  const fvv_status status = decode(flat, &mesh, &diagnostic);
  INFO(diagnostic.message);
  REQUIRE(status == FVV_OK);
  CHECK(mesh.faces[3 * (faces - 1) + 2] == vertices - 1);
  Payload bad = flat;
  bad[4] = 1;
  bad[5] = 1; // 257 of 256 that fit
  check_issue(bad, 3024);
  bad[4] = 0;
  check_issue(bad, 3011);
  bad = flat;
  bad[8]++;
  check_issue(bad, 3024);
  bad = flat;
  bad.erase(bad.end() - 20);
  check_issue(bad, 3024);
}

TEST_CASE("3025: version, filling and end of the vertex stream") {
  const auto mesh = canonical(charts(2));
  FastPlain plain(*mesh);
  for (const int version : {0xa1, 0xa2, 0xaf, 0x00, 0xe1}) {
    plain.vertex_codec = uint8_t(version);
    check_issue(plain.payload(), 3025);
  }
  plain = FastPlain(*mesh);
  for (const size_t from_end : {32u, 21u}) {
    FastPlain bad = plain;
    bad.vertices[bad.vertices.size() - from_end] = 1;
    check_issue(bad.payload(), 3025);
  }
  FastPlain bad = plain;
  bad.vertices.insert(bad.vertices.begin(), 0xff);
  check_issue(bad.payload(), 3025);
  bad = plain;
  bad.vertices.erase(bad.vertices.begin());
  check_issue(bad.payload(), 3025);
}

TEST_CASE("3026: version, table, numbers and end of the index stream") {
  const auto mesh = canonical(tetrahedron());
  const FastPlain plain(*mesh);
  for (const int version : {0xe0, 0xe2, 0xd1, 0x00}) {
    FastPlain bad = plain;
    bad.index_codec = uint8_t(version);
    check_issue(bad.payload(), 3026);
  }
  for (const size_t at : {0u, 13u, 14u, 15u})
    for (const int entry : {0xf0, 0x0f}) {
      FastPlain bad = plain;
      bad.table[at] = uint8_t(entry);
      check_issue(bad.payload(), 3026);
    }
  FastPlain bad = plain;
  bad.numbers.push_back(0);
  check_issue(bad.payload(), 3026);
  bad.numbers.resize(plain.numbers.size() - 1);
  check_issue(bad.payload(), 3026);
  bad = plain;
  bad.numbers.back() |= 0x80; // the same number in two bytes
  bad.numbers.push_back(0);
  check_issue(bad.payload(), 3026);
  bad = plain;
  bad.numbers.pop_back();
  for (const int byte : {0x80, 0x80, 0x80, 0x80, 0x10}) bad.numbers.push_back(uint8_t(byte)); // 2^32
  check_issue(bad.payload(), 3026);
}

TEST_CASE("a fast mesh keeps the rules of every mesh") {
  const auto mesh = canonical(tetrahedron());
  mesh->faces[4] = 4;
  check_issue(FastPlain(*mesh).payload(), 3005);
  mesh->faces[4] = mesh->faces[5];
  check_issue(FastPlain(*mesh).payload(), 3005);
  const auto outside = canonical(tetrahedron());
  outside->lattice[7] = FVV_LATTICE_MAX + 1;
  check_issue(FastPlain(*outside).payload(), 3006);
  outside->lattice[7] = -FVV_LATTICE_MAX;
  Mesh back;
  CHECK(decode(FastPlain(*outside).payload(), &back, nullptr) == FVV_OK);
  const auto textured = canonical(charts(1));
  textured->texture[3] = 4097;
  check_issue(FastPlain(*textured).payload(), 3015);
}

TEST_CASE("3005: entries of the FIFOs that were never written are no vertices") {
  const auto mesh = canonical(tetrahedron());
  // An edge, a vertex, and two vertices by the table, before there are any.
  for (const int code : {0x00, 0x70, 0xe0, 0xf1}) {
    FastPlain bad(*mesh);
    bad.codes[0] = uint8_t(code);
    bad.table[1] = 0x1e;
    bad.numbers.erase(bad.numbers.begin(), bad.numbers.begin() + 4);
    check_issue(bad.payload(), 3005);
  }
}

TEST_CASE("fast meshes survive every failed allocation") {
  const fvv_allocator allocator = memory::allocator();
  for (const Shape &shape : {torus(40, 20), charts(6)}) {
    const auto mesh = canonical(shape);
    const auto payload = encoded(*mesh, FVV_MESH_FAST, 0);
    for (const bool encoding : {true, false}) {
      const size_t before = memory::state.live;
      fvv_status status = FVV_ERROR_MEMORY;
      int64_t n = 0;
      bool leaked = false, reported = true, empty = true;
      for (; status == FVV_ERROR_MEMORY && n < 1000 && !leaked; n++) {
        fvv_mesh back = {};
        fvv_bytes bytes = {};
        fvv_diagnostic diagnostic = {};
        memory::reset(n);
        status = encoding ? fvv_mesh_encode(mesh.get(), FVV_MESH_FAST, 0, &allocator, &bytes, &diagnostic)
                          : fvv_mesh_decode(payload.data(), payload.size(), nullptr, &allocator, &back,
                                            &diagnostic);
        memory::reset();
        reported = reported && diagnostic.status == status;
        if (status != FVV_OK) empty = empty && !bytes.size && !back.lattice && !back.texture;
        fvv_mesh_free(&back);
        fvv_bytes_free(&bytes);
        leaked = memory::state.live != before;
      }
      INFO((encoding ? "encoding " : "decoding ") << n);
      CHECK(status == FVV_OK);
      CHECK(n > (encoding ? 10 : 3));
      CHECK(reported);
      CHECK(empty);
      CHECK_FALSE(leaked);
    }
  }
}
