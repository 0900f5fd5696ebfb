// Patched frames: what comes back, what is refused, and what it costs (clause 8.14).
#include "fvv_catch.h"

#include <algorithm>
#include <cstring>
#include <random>
#include <string>

#include "base/bytes.h"
#include "memory.h"
#include "shapes.h"

namespace {

using Payload = std::vector<uint8_t>;

bool equal(const fvv_mesh &a, const fvv_mesh &b) {
  if (a.vertex_count != b.vertex_count || a.face_count != b.face_count) return false;
  const size_t vertices = a.vertex_count;
  return !memcmp(a.lattice, b.lattice, 12 * vertices) &&
         !memcmp(a.faces, b.faces, 12 * size_t(a.face_count)) && !a.texture == !b.texture &&
         !a.normals == !b.normals && (!a.texture || !memcmp(a.texture, b.texture, 8 * vertices)) &&
         (!a.normals || !memcmp(a.normals, b.normals, 8 * vertices));
}

// The parts of a patched payload, written by hand.
struct Parts {
  Payload header; // of the chunk, 16 bytes
  std::vector<uint64_t> runs;
  Payload patch, delta;
  std::vector<uint64_t> sizes; // where they are to be others than those of the parts

  explicit Parts(const Payload &payload) : header(payload.begin(), payload.begin() + 16) {
    fvv_cursor cursor = {payload.data(), payload.size(), 16, 0};
    const auto absent = size_t(fvv_cursor_uleb(&cursor)), size = size_t(fvv_cursor_uleb(&cursor));
    const size_t end = cursor.position + absent;
    while (cursor.position < end) runs.push_back(fvv_cursor_uleb(&cursor));
    REQUIRE((!cursor.failed && cursor.position == end));
    patch.assign(payload.begin() + long(end), payload.begin() + long(end + size));
    delta.assign(payload.begin() + long(end + size), payload.end());
  }
  Payload whole() const {
    const auto put = [](Payload &to, uint64_t number) {
      uint8_t bytes[10];
      to.insert(to.end(), bytes, bytes + fvv_put_uleb(bytes, number));
    };
    Payload absent, out = header;
    for (const uint64_t run : runs) put(absent, run);
    put(out, sizes.empty() ? absent.size() : sizes[0]);
    put(out, sizes.empty() ? patch.size() : sizes[1]);
    for (const Payload *part : std::initializer_list<const Payload *>{&absent, &patch, &delta})
      out.insert(out.end(), part->begin(), part->end());
    return out;
  }
  void count(size_t at, int more) {
    fvv_put_u32(&header[at], uint32_t(int(fvv_get_u32(&header[at])) + more));
  }
};

// A key mesh, a frame that moves it and one that replaces faces 40 to 99 and moves on.
struct Corpus {
  std::unique_ptr<Mesh> key;
  Payload first, patched, last;
};
Corpus corpus(const Shape &shape, uint8_t profile = FVV_MESH_RAW) {
  Corpus out = {key_of(shape, 0.002), {}, {}, {}};
  Sequence encoder(*out.key);
  out.first = encoder.encode(moved(*out.key, 1), 1);
  CutOut cut = cut_out(*out.key, moved(*out.key, 2), 40, 60);
  const fvv_mesh mesh = cut.mesh();
  out.patched = encoder.encode(moved(*out.key, 2), cut.patch(mesh, profile), 1);
  out.last = encoder.encode(moved(*out.key, 3), 1);
  return out;
}

// Triangles of a decoded frame by position alone, from the least corner on.
std::vector<Triangle> placed(const fvv_mesh &mesh) {
  fvv_mesh bare = mesh;
  bare.texture = bare.normals = nullptr;
  return triangles(bare);
}

} // namespace

TEST_CASE("patched frames come back, equal in encoder and decoder") {
  for (const uint8_t profile : {FVV_MESH_RAW, FVV_MESH_DRACO, FVV_MESH_FAST})
    for (const Shape &shape : {torus(40, 24), charts(6), hard_cube(6)}) {
      const auto key = key_of(shape, 0.002);
      Sequence encoder(*key), decoder(*key);
      // The range that is left out grows, moves, disappears for a plain frame, and is back.
      const uint32_t ranges[][2] = {{10, 30}, {10, 50}, {30, 90}, {0, 0}, {0, key->face_count}, {5, 1}};
      for (int t = 1; t <= 6; t++) {
        const uint32_t *range = ranges[t - 1];
        const auto wanted = moved(*key, t, 1);
        const uint32_t error = uint32_t(t % 3);
        if (!range[1]) {
          REQUIRE(decoder.decode(encoder.encode(wanted, error)) == FVV_OK);
          CHECK(!fvv_mesh_sequence_patch(decoder.handle));
          CHECK(!fvv_mesh_sequence_absent(decoder.handle));
          CHECK(fvv_mesh_sequence_mesh(decoder.handle)->face_count == key->face_count);
          continue;
        }
        CutOut cut = cut_out(*key, wanted, range[0], range[1]);
        const fvv_mesh mesh = cut.mesh();
        REQUIRE(decoder.decode(encoder.encode(wanted, cut.patch(mesh, profile), error)) == FVV_OK);
        const fvv_mesh &got = *fvv_mesh_sequence_mesh(decoder.handle);
        CHECK(equal(got, *fvv_mesh_sequence_mesh(encoder.handle)));
        const fvv_mesh *patch = fvv_mesh_sequence_patch(decoder.handle);
        REQUIRE(patch);
        CHECK(got.vertex_count == key->vertex_count + patch->vertex_count);
        CHECK(got.face_count == key->face_count);
        CHECK(std::equal(cut.absent.begin(), cut.absent.end(), fvv_mesh_sequence_absent(decoder.handle)));
        // The border has no gap: the patch is what was cut out, so the surface is that of a plain frame.
        fvv_mesh plain = *key;
        plain.lattice = got.lattice;
        CHECK(placed(plain) == placed(got));
        const std::vector<int32_t> positions(got.lattice, got.lattice + 3 * size_t(key->vertex_count));
        CHECK(distance(positions, wanted) <= int32_t(error));
      }
    }
}

TEST_CASE("a patch may have other vertices and faces than those that it replaces, or be none") {
  const auto key = key_of(torus(40, 24), 0.002);
  const auto hat = canonical(tetrahedron(0.3), 0.002);
  Sequence encoder(*key), decoder(*key);
  std::vector<uint8_t> absent(key->face_count);
  std::fill(absent.begin() + 100, absent.begin() + 110, uint8_t(1));
  const fvv_mesh_patch two = {sizeof two, absent.data(), hat.get(), nullptr, FVV_MESH_RAW, 0};
  REQUIRE(decoder.decode(encoder.encode(moved(*key, 1), two, 1)) == FVV_OK);
  const fvv_mesh *mesh = fvv_mesh_sequence_mesh(decoder.handle);
  CHECK(mesh->vertex_count == key->vertex_count + 4);
  CHECK(mesh->face_count == key->face_count - 10 + 4);
  CHECK(!memcmp(mesh->lattice + 3 * size_t(key->vertex_count), hat->lattice, 4 * 12));
  CHECK(mesh->faces[3 * (size_t(mesh->face_count) - 1)] == key->vertex_count + hat->faces[9]);
  // Only what disappears, and then only what is added; NULL: nothing is left out.
  const fvv_mesh_patch hole = {sizeof hole, absent.data(), nullptr, nullptr, 0, 0};
  REQUIRE(decoder.decode(encoder.encode(moved(*key, 2), hole, 1)) == FVV_OK);
  CHECK(fvv_mesh_sequence_mesh(decoder.handle)->face_count == key->face_count - 10);
  CHECK(!fvv_mesh_sequence_patch(decoder.handle));
  CHECK(fvv_mesh_sequence_absent(decoder.handle));
  const fvv_mesh_patch added = {sizeof added, nullptr, hat.get(), nullptr, FVV_MESH_FAST, 0};
  REQUIRE(decoder.decode(encoder.encode(moved(*key, 3), added, 1)) == FVV_OK);
  CHECK(fvv_mesh_sequence_mesh(decoder.handle)->face_count == key->face_count + 4);
}

TEST_CASE("the vertices of the key mesh move as if there were no patch") {
  const auto key = key_of(torus(40, 24), 0.002);
  Sequence plain(*key), patched(*key);
  for (int t = 1; t <= 4; t++) {
    const auto wanted = moved(*key, t, 2);
    const Payload delta = plain.encode(wanted, 1);
    if (t % 2 == 0) {
      CHECK(patched.encode(wanted, 1) == delta);
      continue;
    }
    CutOut cut = cut_out(*key, wanted, 200, 50);
    const fvv_mesh mesh = cut.mesh();
    const Parts parts(patched.encode(wanted, cut.patch(mesh), 1));
    CHECK(parts.delta == Payload(delta.begin() + 16, delta.end()));
    CHECK(parts.runs.size() == 3);
  }
}

TEST_CASE("normals of a frame with vertices that no face uses are computed") {
  const auto key = key_of(torus(40, 24), 0.002);
  Sequence encoder(*key);
  std::vector<uint8_t> absent(key->face_count, 1);
  absent[0] = 0;
  const fvv_mesh_patch patch = {sizeof patch, absent.data(), nullptr, nullptr, 0, 0};
  encoder.encode(moved(*key, 1), patch, 1);
  const fvv_mesh *mesh = fvv_mesh_sequence_mesh(encoder.handle);
  std::vector<float> normals(3 * size_t(mesh->vertex_count));
  REQUIRE(fvv_mesh_normals(mesh, nullptr, normals.data(), nullptr) == FVV_OK);
  size_t vertices = 0;
  for (size_t i = 0; i < normals.size(); i += 3) vertices += normals[i] || normals[i + 1] || normals[i + 2];
  CHECK(vertices == 3);
}

TEST_CASE("3018, 3033 to 3036: each rule of a patched payload has its issue") {
  const Corpus c = corpus(torus(40, 24));
  const auto look = [&](const Payload &payload, uint64_t *offset = nullptr) -> uint32_t {
    Sequence decoder(*c.key);
    REQUIRE(decoder.decode(c.first) == FVV_OK);
    fvv_diagnostic diagnostic = {};
    const fvv_status status = decoder.decode(payload, &diagnostic);
    if (offset) *offset = diagnostic.offset;
    if (status == FVV_OK) return decoder.decode(c.last) == FVV_OK ? 0 : 1;
    CHECK(status == FVV_ERROR_INVALID);
    CHECK(decoder.decode(c.last) == FVV_ERROR_STATE);
    return diagnostic.issue;
  };
  const auto changed = [&](auto change) {
    Parts parts(c.patched);
    change(parts);
    return parts.whole();
  };
  REQUIRE(look(c.patched) == 0);
  REQUIRE(look(changed([](Parts &) {})) == 0);
  REQUIRE(Parts(c.patched).runs == (std::vector<uint64_t>{40, 60, c.key->face_count - 100}));
  // Sizes.
  CHECK(look(changed([](Parts &p) { p.sizes = {100000, 0}; })) == FVV_ISSUE_PATCHED_SIZE);
  CHECK(look(changed([](Parts &p) { p.sizes = {4, 100000}; })) == FVV_ISSUE_PATCHED_SIZE);
  CHECK(look(changed([](Parts &p) { p.sizes = {UINT64_MAX, UINT64_MAX}; })) == FVV_ISSUE_PATCHED_SIZE);
  CHECK(look({c.patched.begin(), c.patched.begin() + 16}) == FVV_ISSUE_PATCHED_SIZE);
  Payload overlong = c.patched;
  overlong[16] |= 128;
  overlong.insert(overlong.begin() + 17, 0);
  CHECK(look(overlong) == FVV_ISSUE_PATCHED_SIZE);
  // Runs.
  CHECK(look(changed([](Parts &p) { p.runs[2]--; })) == FVV_ISSUE_PATCHED_FACES);
  CHECK(look(changed([](Parts &p) { p.runs[2]++; })) == FVV_ISSUE_PATCHED_FACES);
  CHECK(look(changed([](Parts &p) { p.runs[2] = UINT64_MAX; })) == FVV_ISSUE_PATCHED_FACES);
  CHECK(look(changed([](Parts &p) { p.runs.push_back(0); })) == FVV_ISSUE_PATCHED_FACES);
  CHECK(look(changed([](Parts &p) { p.runs = {40, 0, 60, p.runs[2]}; })) == FVV_ISSUE_PATCHED_FACES);
  CHECK(look(changed([](Parts &p) { p.runs.clear(); })) == FVV_ISSUE_PATCHED_FACES);
  CHECK(look(changed([](Parts &p) { p.runs = {0, 60, 40 + p.runs[2]}; })) == 0);
  Payload long_run = c.patched;
  const size_t first_run = 16 + 1 + 2; // sizes take 1 and 2 bytes
  REQUIRE(long_run[first_run] == 40);
  long_run[first_run] |= 128;
  long_run.insert(long_run.begin() + long(first_run) + 1, 0);
  long_run[16]++;
  CHECK(look(long_run) == FVV_ISSUE_PATCHED_FACES);
  // Counts.
  for (const size_t at : {size_t(4), size_t(8)})
    for (const int more : {-1, 1})
      CHECK(look(changed([&](Parts &p) { p.count(at, more); })) == FVV_ISSUE_PATCHED_COUNTS);
  CHECK(look(changed([](Parts &p) { p.patch.clear(); })) == FVV_ISSUE_PATCHED_COUNTS);
  CHECK(look(changed([](Parts &p) { p.runs = {41, 59, p.runs[2]}; })) == FVV_ISSUE_PATCHED_COUNTS);
  // The patch: its kind, and faults of its own, at their place in the chunk.
  uint64_t offset = 0;
  const size_t patch = first_run + 4;
  for (const uint8_t profile : {2, 3, 5, 9}) {
    CHECK(look(changed([&](Parts &p) { p.patch[0] = profile; }), &offset) == FVV_ISSUE_PATCHED_MESH);
    CHECK(offset == patch);
  }
  CHECK(look(changed([](Parts &p) {
          p.patch[1] = 1;
          p.patch[2] = 12;
        })) == FVV_ISSUE_PATCHED_MESH);
  CHECK(look(changed([](Parts &p) { p.patch[12] = 1; }), &offset) == FVV_ISSUE_MESH_PAYLOAD);
  CHECK(offset == patch + 12);
  CHECK(look(changed([](Parts &p) { p.patch.resize(15); })) == FVV_ISSUE_MESH_PAYLOAD);
  CHECK(look(changed([](Parts &p) { p.patch.pop_back(); })) == FVV_ISSUE_MESH_RAW_SIZE);
  const uint32_t patch_vertices = fvv_get_u32(&Parts(c.patched).patch[4]);
  CHECK(look(changed(
                 [&](Parts &p) { fvv_put_u32(&p.patch[16 + 12 * size_t(patch_vertices)], patch_vertices); }),
             &offset) == FVV_ISSUE_MESH_INDEX);
  CHECK(offset == patch + 16 + 12 * size_t(patch_vertices));
  CHECK(look(changed([&](Parts &p) { fvv_put_u32(&p.patch[16], uint32_t(FVV_LATTICE_MAX) + 1); })) ==
        FVV_ISSUE_MESH_LATTICE);
  // What it has in common with a delta frame. A frame that is missing is found by the number, whatever else
  // does not fit then.
  {
    Sequence decoder(*c.key);
    fvv_diagnostic diagnostic = {};
    CHECK(decoder.decode(changed([](Parts &p) { p.runs[2]--; }), &diagnostic) == FVV_ERROR_INVALID);
    CHECK(diagnostic.issue == FVV_ISSUE_DELTA_NUMBER);
  }
  CHECK(look(changed([](Parts &p) { p.delta[0] = 1; })) == FVV_ISSUE_DELTA_NUMBER);
  CHECK(look(changed([](Parts &p) { p.delta[1]++; })) == FVV_ISSUE_DELTA_LEVELS);
  CHECK(look(changed([](Parts &p) { p.delta.push_back(0); })) == FVV_ISSUE_DELTA_SIZE);
  CHECK(look(changed([](Parts &p) {
          p.header[1] = p.patch[1] = 1;
          p.header[2] = p.patch[2] = 12;
          p.patch.resize(p.patch.size() + 8 * size_t(fvv_get_u32(&p.patch[4])));
        })) == FVV_ISSUE_DELTA_KEY);
  Mesh mesh;
  fvv_diagnostic diagnostic = {};
  CHECK(decode(c.patched, &mesh, &diagnostic) == FVV_ERROR_INVALID);
  CHECK(diagnostic.issue == FVV_ISSUE_MESH_KEY);
}

TEST_CASE("limits hold for key mesh and patch together") {
  const Corpus c = corpus(torus(40, 24));
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_vertices = c.key->vertex_count;
  fvv_mesh_header header;
  fvv_diagnostic diagnostic = {};
  CHECK(fvv_mesh_peek(c.patched.data(), c.patched.size(), &limits, &header, &diagnostic) == FVV_ERROR_LIMIT);
  CHECK(diagnostic.issue == FVV_ISSUE_LIMIT);
  // A patch alone may say too much, of a payload that does not.
  Parts parts(c.patched);
  fvv_put_u32(&parts.patch[4], 0x7fffffff);
  fvv_limits_default(&limits);
  const Payload bad = parts.whole();
  CHECK(fvv_mesh_peek(bad.data(), bad.size(), &limits, &header, &diagnostic) == FVV_ERROR_LIMIT);
}

TEST_CASE("what an encoder of patched frames cannot take leaves the sequence as it was") {
  const auto key = key_of(torus(30, 20));
  const auto textured = key_of(charts(3));
  Sequence encoder(*key), decoder(*key);
  const auto wanted = moved(*key, 1);
  CutOut cut = cut_out(*key, wanted, 10, 20);
  const fvv_mesh mesh = cut.mesh();
  const fvv_mesh_patch good = cut.patch(mesh);
  const auto refused = [&](const fvv_mesh_patch &patch, fvv_status expected, uint32_t issue) {
    Bytes payload;
    fvv_diagnostic diagnostic = {};
    CHECK(fvv_mesh_sequence_encode_patched(encoder.handle, wanted.data(), nullptr, &patch, &payload,
                                           &diagnostic) == expected);
    CHECK(diagnostic.issue == issue);
  };
  fvv_mesh_patch bad = good;
  bad.profile = FVV_MESH_PATCHED;
  refused(bad, FVV_ERROR_ARGUMENT, FVV_ISSUE_PATCHED_MESH);
  bad = good;
  bad.level = 11;
  refused(bad, FVV_ERROR_ARGUMENT, 0);
  bad = good;
  bad.mesh = textured.get();
  refused(bad, FVV_ERROR_INPUT, FVV_ISSUE_PATCHED_MESH);
  bad = good;
  const std::vector<uint8_t> all(key->face_count, 1);
  bad.absent = all.data();
  bad.mesh = nullptr;
  refused(bad, FVV_ERROR_INPUT, FVV_ISSUE_MESH_COUNTS);
  std::vector<uint32_t> border = cut.border;
  border[1] = key->vertex_count;
  bad = good;
  bad.border = border.data();
  refused(bad, FVV_ERROR_INPUT, FVV_ISSUE_MESH_INDEX);
  fvv_mesh broken = mesh;
  std::vector<uint32_t> faces = cut.faces;
  faces[0] = faces[1];
  broken.faces = faces.data();
  bad = good;
  bad.mesh = &broken;
  refused(bad, FVV_ERROR_INPUT, FVV_ISSUE_MESH_INDEX);
  REQUIRE(decoder.decode(encoder.encode(wanted, good, 1)) == FVV_OK);
  CHECK(equal(*fvv_mesh_sequence_mesh(decoder.handle), *fvv_mesh_sequence_mesh(encoder.handle)));
}

TEST_CASE("patched frames without memory are an error and leak nothing") {
  const auto key = key_of(torus(20, 12));
  const fvv_allocator allocator = memory::allocator();
  const auto wanted = moved(*key, 1);
  CutOut cut = cut_out(*key, wanted, 10, 20);
  const fvv_mesh mesh = cut.mesh();
  const fvv_mesh_patch patch = cut.patch(mesh, FVV_MESH_RAW);
  for (const bool decodes : {false, true}) {
    const Payload coded = Sequence(*key).encode(wanted, patch, 1);
    const size_t before = memory::state.live;
    bool done = false;
    for (int64_t n = 0; !done; n++) {
      fvv_mesh_sequence *sequence = nullptr;
      fvv_bytes payload = {};
      payload.allocator = allocator;
      memory::reset(n);
      fvv_status status = fvv_mesh_sequence_open(key.get(), &allocator, &sequence, nullptr);
      if (status == FVV_OK)
        status = decodes ? fvv_mesh_sequence_decode(sequence, coded.data(), coded.size(), nullptr)
                         : fvv_mesh_sequence_encode_patched(sequence, wanted.data(), nullptr, &patch,
                                                            &payload, nullptr);
      memory::reset();
      done = status == FVV_OK;
      if (!done) CHECK(status == FVV_ERROR_MEMORY);
      fvv_bytes_free(&payload);
      fvv_mesh_sequence_close(sequence);
      REQUIRE(memory::state.live == before);
      REQUIRE(n < 1000);
    }
  }
}

TEST_CASE("no prefix of a patched payload decodes, and damage to it is survived", "[slow]") {
  for (const uint8_t profile : {FVV_MESH_RAW, FVV_MESH_DRACO, FVV_MESH_FAST}) {
    const Corpus c = corpus(torus(30, 18), profile);
    const auto decodes = [&](const Payload &payload) {
      Sequence decoder(*c.key);
      REQUIRE(decoder.decode(c.first) == FVV_OK);
      const fvv_status status = decoder.decode(payload);
      if (status != FVV_OK) CHECK(status <= FVV_ERROR_ARGUMENT);
      if (status != FVV_OK) return false;
      const fvv_mesh *mesh = fvv_mesh_sequence_mesh(decoder.handle);
      for (size_t i = 0; i < 3 * size_t(mesh->face_count); i++)
        if (mesh->faces[i] >= mesh->vertex_count) FAIL("a face indexes no vertex");
      return true;
    };
    REQUIRE(decodes(c.patched));
    for (size_t size = 0; size < c.patched.size(); size++)
      if (decodes({c.patched.begin(), c.patched.begin() + long(size)})) FAIL("a prefix decodes");
    std::mt19937 random(profile + 1u);
    int refused = 0;
    for (int i = 0; i < 1000; i++) {
      Payload bad = c.patched;
      for (unsigned changes = 1 + random() % 3; changes; changes--)
        bad[random() % (random() % 2 ? bad.size() : 60)] = uint8_t(random());
      refused += !decodes(bad);
    }
    CHECK(refused > 300);
  }
}
