// Patched frames: what comes back, what is refused, and what it costs (clause 8.14).
#include "fvv_catch.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <random>
#include <set>
#include <string>

#include "base/bytes.h"
#include "base/memory.h"
#include "memory.h"
#include "mesh/mesh.h"
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
  out.last = encoder.encode(moved(*fvv_mesh_sequence_mesh(encoder.handle), 1), 1);
  return out;
}

// Edges, by the positions of their ends, that an odd number of faces has: where the surface is open.
size_t open_edges(const fvv_mesh &mesh) {
  using Point = std::array<int32_t, 3>;
  std::map<std::array<Point, 2>, size_t> edges;
  const auto point = [&](size_t corner) {
    const int32_t *p = mesh.lattice + 3 * size_t(mesh.faces[corner]);
    return Point{p[0], p[1], p[2]};
  };
  for (size_t i = 0; i < 3 * size_t(mesh.face_count); i++) {
    const Point a = point(i), b = point(i % 3 == 2 ? i - 2 : i + 1);
    edges[{std::min(a, b), std::max(a, b)}]++;
  }
  return size_t(std::count_if(edges.begin(), edges.end(), [](const auto &e) { return e.second % 2; }));
}

// What the sequence says that the frame keeps of former.
void check_kept(const fvv_mesh_sequence *sequence, const fvv_mesh &former,
                const std::vector<uint8_t> &absent) {
  const fvv_mesh &mesh = *fvv_mesh_sequence_mesh(sequence);
  const fvv_mesh *patch = fvv_mesh_sequence_patch(sequence);
  uint32_t count = 0;
  const uint32_t *kept = fvv_mesh_sequence_kept(sequence, &count);
  REQUIRE(kept);
  std::set<uint32_t> used;
  std::vector<uint32_t> faces; // as they were
  for (size_t i = 0; i < 3 * size_t(former.face_count); i++)
    if (!absent[i / 3]) {
      used.insert(former.faces[i]);
      faces.push_back(former.faces[i]);
    }
  CHECK(std::vector<uint32_t>(used.begin(), used.end()) == std::vector<uint32_t>(kept, kept + count));
  CHECK(mesh.vertex_count == count + (patch ? patch->vertex_count : 0));
  REQUIRE(mesh.face_count == faces.size() / 3 + (patch ? patch->face_count : 0));
  bool same = true;
  for (size_t i = 0; i < faces.size(); i++) same &= kept[mesh.faces[i]] == faces[i];
  for (size_t i = faces.size(); i < 3 * size_t(mesh.face_count); i++)
    same &= mesh.faces[i] == count + patch->faces[i - faces.size()];
  for (size_t i = 0; former.texture && i < 2 * size_t(count); i++)
    same &= mesh.texture[i] == former.texture[2 * size_t(kept[i / 2]) + i % 2];
  for (size_t i = 0; patch && i < 3 * size_t(patch->vertex_count); i++)
    same &= mesh.lattice[3 * size_t(count) + i] == patch->lattice[i];
  for (size_t i = 0; patch && mesh.normals && i < 2 * size_t(patch->vertex_count); i++)
    same &= mesh.normals[2 * size_t(count) + i] == patch->normals[i];
  CHECK(same);
}

} // namespace

TEST_CASE("patched frames come back, equal in encoder and decoder") {
  const fvv_allocator allocator = fvv_allocator_or_default(nullptr);
  for (const uint8_t profile : {FVV_MESH_RAW, FVV_MESH_DRACO, FVV_MESH_FAST})
    for (const Shape &shape : {torus(40, 24), charts(6), hard_cube(6)}) {
      const auto key = key_of(shape, 0.002);
      Sequence encoder(*key), decoder(*key);
      const size_t open = open_edges(*key);
      // Parts of the surface, of former patches too, are replaced; between them it only moves.
      const uint32_t ranges[][2] = {{10, 30}, {10, 50}, {0, 0}, {30, 40}, {0, key->face_count},
                                    {0, 0},   {5, 1}};
      uint32_t error = 0;
      for (const auto &range : ranges) {
        Mesh former;
        REQUIRE(fvv_mesh_copy(fvv_mesh_sequence_mesh(decoder.handle), &allocator, &former) == FVV_OK);
        const auto wanted = moved(former, 1);
        error = (error + 1) % 3;
        if (!range[1]) {
          REQUIRE(decoder.decode(encoder.encode(wanted, error)) == FVV_OK);
          uint32_t count = 0;
          CHECK(!fvv_mesh_sequence_patch(decoder.handle));
          CHECK(!fvv_mesh_sequence_kept(decoder.handle, &count));
          CHECK(count == former.vertex_count);
          CHECK(distance(decoder.positions(), wanted) <= int32_t(error));
        } else {
          CutOut cut = cut_out(former, wanted, range[0], range[1]);
          const fvv_mesh mesh = cut.mesh();
          std::vector<uint32_t> vertices(3 * size_t(mesh.face_count));
          fvv_mesh_patch described = cut.patch(mesh, profile);
          described.vertices = vertices.data();
          REQUIRE(decoder.decode(encoder.encode(wanted, described, error)) == FVV_OK);
          check_kept(decoder.handle, former, cut.absent);
          const fvv_mesh &patch = *fvv_mesh_sequence_patch(decoder.handle);
          vertices.resize(patch.vertex_count);
          int32_t off = 0;
          for (size_t i = 0; i < 3 * vertices.size(); i++)
            off =
                std::max(off, std::abs(patch.lattice[i] - mesh.lattice[3 * size_t(vertices[i / 3]) + i % 3]));
          CHECK(off <= int32_t(error));
          uint32_t count = 0;
          const uint32_t *kept = fvv_mesh_sequence_kept(decoder.handle, &count);
          std::vector<int32_t> positions = wanted;
          for (size_t i = 0; i < 3 * size_t(count); i++)
            positions[3 * size_t(kept[i / 3]) + i % 3] = fvv_mesh_sequence_mesh(decoder.handle)->lattice[i];
          CHECK(distance(positions, wanted) <= int32_t(error));
        }
        const fvv_mesh &got = *fvv_mesh_sequence_mesh(decoder.handle);
        CHECK(equal(got, *fvv_mesh_sequence_mesh(encoder.handle)));
        CHECK(got.face_count == key->face_count);
        CHECK(open_edges(got) == open);
      }
    }
}

TEST_CASE("a patch may have other vertices and faces than those that it replaces, or be none") {
  const auto key = key_of(torus(40, 24), 0.002);
  const auto hat = canonical(tetrahedron(0.3), 0.002);
  Sequence encoder(*key), decoder(*key);
  const auto current = [&]() -> const fvv_mesh & { return *fvv_mesh_sequence_mesh(decoder.handle); };
  std::vector<uint8_t> absent(key->face_count);
  std::fill(absent.begin() + 100, absent.begin() + 110, uint8_t(1));
  const fvv_mesh_patch two = {sizeof two, absent.data(), hat.get(), nullptr, FVV_MESH_RAW, 0, nullptr};
  REQUIRE(decoder.decode(encoder.encode(moved(*key, 1), two, 1)) == FVV_OK);
  check_kept(decoder.handle, *key, absent);
  CHECK(current().face_count == key->face_count - 10 + 4);
  const uint32_t vertices = current().vertex_count;
  // The patch moves with the rest, and is left out again. NULL: nothing is left out.
  REQUIRE(decoder.decode(encoder.encode(moved(current(), 1), 1)) == FVV_OK);
  absent.assign(current().face_count, 0);
  std::fill(absent.end() - 4, absent.end(), uint8_t(1));
  const fvv_mesh_patch hole = {sizeof hole, absent.data(), nullptr, nullptr, 0, 0, nullptr};
  REQUIRE(decoder.decode(encoder.encode(moved(current(), 1), hole, 1)) == FVV_OK);
  CHECK(current().face_count == key->face_count - 10);
  CHECK(current().vertex_count == vertices - 4);
  CHECK(!fvv_mesh_sequence_patch(decoder.handle));
  const fvv_mesh_patch added = {sizeof added, nullptr, hat.get(), nullptr, FVV_MESH_FAST, 0, nullptr};
  REQUIRE(decoder.decode(encoder.encode(moved(current(), 1), added, 1)) == FVV_OK);
  CHECK(current().face_count == key->face_count - 10 + 4);
  // Only the hat remains.
  absent.assign(current().face_count, 1);
  std::fill(absent.end() - 4, absent.end(), uint8_t(0));
  const fvv_mesh_patch rest = {sizeof rest, absent.data(), nullptr, nullptr, 0, 0, nullptr};
  REQUIRE(decoder.decode(encoder.encode(moved(current(), 1), rest, 1)) == FVV_OK);
  CHECK(current().face_count == 4);
  CHECK(current().vertex_count == 4);
  // And then something else alone.
  absent.assign(4, 1);
  const fvv_mesh_patch all = {sizeof all, absent.data(), key.get(), nullptr, FVV_MESH_FAST, 0, nullptr};
  REQUIRE(decoder.decode(encoder.encode(moved(current(), 1), all, 1)) == FVV_OK);
  uint32_t count = 1;
  CHECK(fvv_mesh_sequence_kept(decoder.handle, &count));
  CHECK(count == 0);
  CHECK(current().vertex_count == key->vertex_count);
  REQUIRE(decoder.decode(encoder.encode(moved(current(), 1), 1)) == FVV_OK);
  CHECK(equal(current(), *fvv_mesh_sequence_mesh(encoder.handle)));
}

TEST_CASE("vertices that a patched frame drops cost nothing") {
  const auto key = key_of(torus(40, 24), 0.002);
  const auto wanted = moved(*key, 1);
  std::vector<int32_t> wild = wanted;
  std::vector<uint8_t> absent(key->face_count), used(key->vertex_count);
  std::fill(absent.begin() + 200, absent.begin() + 300, uint8_t(1));
  for (size_t i = 0; i < 3 * size_t(key->face_count); i++)
    if (!absent[i / 3]) used[key->faces[i]] = 1;
  size_t dropped = 0;
  for (size_t v = 0; v < key->vertex_count; v++) {
    dropped += !used[v];
    for (size_t a = 0; a < 3 && !used[v]; a++) wild[3 * v + a] += int32_t(1000 * v % 777) - 388;
  }
  CHECK(dropped > 20);
  const fvv_mesh_patch hole = {sizeof hole, absent.data(), nullptr, nullptr, 0, 0, nullptr};
  CHECK(Sequence(*key).encode(wild, hole, 1) == Sequence(*key).encode(wanted, hole, 1));
}

TEST_CASE("a patch that does nothing costs its header, and frames after it as many bytes as before") {
  const auto key = key_of(torus(40, 24), 0.002);
  Sequence plain(*key), patched(*key);
  const fvv_mesh_patch nothing = {sizeof nothing, nullptr, nullptr, nullptr, 0, 0, nullptr};
  size_t bytes = 0, expected = 0;
  for (int t = 1; t <= 6; t++) {
    const auto wanted = moved(*key, t, 2);
    expected += plain.encode(wanted, 1).size();
    bytes += (t == 3 ? patched.encode(wanted, nothing, 1) : patched.encode(wanted, 1)).size();
  }
  CHECK(bytes <= expected + expected / 50);
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
  // The first run may be empty; here less remains then.
  CHECK(look(changed([](Parts &p) { p.runs = {0, 100, p.runs[2]}; })) == FVV_ISSUE_PATCHED_COUNTS);
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
