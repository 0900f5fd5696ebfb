// Delta frames: levels and weights against arithmetic in floating point, what comes back, and how large it
// is.
#include "fvv_catch.h"
#include "memory.h"
#include "mesh_of.h"
#include "shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <random>
#include <set>

extern "C" {
#include "mesh/delta.h"
}

namespace {

struct Hierarchy : fvv_delta_hierarchy {
  explicit Hierarchy(const fvv_mesh &mesh) : fvv_delta_hierarchy() {
    REQUIRE(fvv_delta_hierarchy_build(&mesh, &mesh.allocator, this) == FVV_OK);
  }
  Hierarchy(const Hierarchy &) = delete;
  ~Hierarchy() { fvv_delta_hierarchy_free(this); }
  uint32_t begin(uint32_t level) const { return level ? level_end[level - 1] : 0; }
};

// Weights by least squares in floating point, from the definition in clause 8.8; corrections end at +-4.
std::vector<double> expected(const std::vector<std::array<double, 3>> &offsets) {
  std::vector<double> share(offsets.size());
  double sum = 0, mean[3] = {}, s[3][3] = {};
  for (size_t i = 0; i < offsets.size(); i++) {
    share[i] = 1;
    for (const double c : offsets[i]) share[i] += c * c;
    share[i] = 1 / share[i];
    sum += share[i];
  }
  for (size_t i = 0; i < offsets.size(); i++) {
    share[i] /= sum;
    for (size_t a = 0; a < 3; a++) mean[a] += share[i] * offsets[i][a];
  }
  for (size_t i = 0; i < offsets.size(); i++)
    for (size_t a = 0; a < 3; a++)
      for (size_t b = 0; b < 3; b++)
        s[a][b] += share[i] * (offsets[i][a] - mean[a]) * (offsets[i][b] - mean[b]);
  const double trace = s[0][0] + s[1][1] + s[2][2];
  for (size_t a = 0; a < 3; a++) s[a][a] += trace / 32;
  // Gauss without pivots: the matrix is positive definite.
  double x[3] = {-mean[0], -mean[1], -mean[2]};
  for (size_t a = 0; a < 3; a++)
    for (size_t r = a + 1; r < 3; r++) {
      const double f = s[r][a] / s[a][a];
      for (size_t b = a; b < 3; b++) s[r][b] -= f * s[a][b];
      x[r] -= f * x[a];
    }
  for (size_t a = 3; a-- > 0;) {
    for (size_t b = a + 1; b < 3; b++) x[a] -= s[a][b] * x[b];
    x[a] /= s[a][a];
  }
  std::vector<double> weights;
  for (size_t i = 0; i < offsets.size(); i++) {
    double c = 0;
    for (size_t a = 0; a < 3; a++) c += (offsets[i][a] - mean[a]) * x[a];
    weights.push_back(share[i] * (1 + std::clamp(c, -4.0, 4.0)));
  }
  // What rounding and clamping leave goes to the nearest.
  weights[0] += 1 - std::accumulate(weights.begin(), weights.end(), 0.0);
  return weights;
}

} // namespace

TEST_CASE("weights are those of moving least squares with a ridge") {
  std::mt19937 random(11);
  double worst = 0;
  for (int round = 0; round < 3000; round++) {
    const uint32_t count = 1 + random() % FVV_DELTA_NEIGHBOURS;
    const int32_t range = 8 << random() % 7;
    int32_t offsets[FVV_DELTA_NEIGHBOURS][3], weights[FVV_DELTA_NEIGHBOURS];
    std::vector<std::array<double, 3>> real(count);
    for (uint32_t i = 0; i < count; i++)
      for (size_t a = 0; a < 3; a++) {
        offsets[i][a] = int32_t(random() % uint32_t(2 * range + 1)) - range;
        real[i][a] = offsets[i][a];
      }
    fvv_delta_weights(offsets, count, weights);
    int64_t sum = 0;
    const auto wanted = expected(real);
    for (uint32_t i = 0; i < count; i++) {
      sum += weights[i];
      CHECK(std::abs(weights[i]) < 1 << 21);
      worst = std::max(worst, std::abs(weights[i] / 65536.0 - wanted[i]));
    }
    CHECK(sum == 65536);
  }
  INFO(worst);
  CHECK(worst < 0.01);
}

TEST_CASE("weights of points that lie together are shares") {
  int32_t offsets[FVV_DELTA_NEIGHBOURS][3] = {}, weights[FVV_DELTA_NEIGHBOURS];
  fvv_delta_weights(offsets, 4, weights);
  for (int i = 0; i < 4; i++) CHECK(weights[i] == 16384);
  for (auto &offset : offsets) offset[0] = 511;
  fvv_delta_weights(offsets, 1, weights);
  CHECK(weights[0] == 65536);
  fvv_delta_weights(offsets, 6, weights);
  int64_t sum = 0;
  for (const int32_t w : weights) sum += w;
  CHECK(sum == 65536);
}

TEST_CASE("weights stay bounded for offsets at the ends of their range") {
  std::mt19937 random(4);
  for (int round = 0; round < 200000; round++) {
    int32_t offsets[FVV_DELTA_NEIGHBOURS][3], weights[FVV_DELTA_NEIGHBOURS];
    const int32_t choices[] = {-512, -511, -1, 0, 1, 2, 511, 512};
    for (auto &offset : offsets)
      for (int32_t &c : offset) c = choices[random() % 8];
    fvv_delta_weights(offsets, 1 + random() % 6, weights);
    for (uint32_t i = 0; i < 1; i++) REQUIRE(std::abs(weights[i]) < 1 << 21);
  }
}

namespace {

// Levels and stencils' nodes from the words of clause 8.8, with sets.
struct Plain {
  std::vector<std::vector<uint32_t>> levels, stencils;
  const fvv_mesh &mesh;
  std::vector<std::set<uint32_t>> neighbours;

  explicit Plain(const fvv_mesh &key) : stencils(key.vertex_count), mesh(key), neighbours(key.vertex_count) {
    std::map<std::array<int32_t, 3>, uint32_t> points;
    std::vector<uint32_t> lowest, twins;
    std::set<uint32_t> left;
    for (uint32_t v = 0; v < key.vertex_count; v++) {
      const int32_t *p = key.lattice + 3 * size_t(v);
      lowest.push_back(points.insert({{{p[0], p[1], p[2]}}, v}).first->second);
      if (lowest[v] == v)
        left.insert(v);
      else
        twins.push_back(v);
    }
    for (const uint32_t v : twins) stencils[v] = {lowest[v]};
    for (size_t i = 0; i < 3 * size_t(key.face_count); i++)
      join(lowest[key.faces[i]], lowest[key.faces[i % 3 == 2 ? i - 2 : i + 1]]);
    std::vector<std::vector<uint32_t>> passes;
    for (;;) {
      const std::vector<uint32_t> taken = take(left);
      if (taken.empty()) break;
      passes.push_back(taken);
    }
    levels.emplace_back(left.begin(), left.end());
    for (size_t i = 1; i < levels[0].size(); i++) stencils[levels[0][i]] = {levels[0][i - 1]};
    for (size_t p = passes.size(); p-- > 0;) {
      if (p % 3 == 2) levels.emplace_back();
      levels.back().insert(levels.back().end(), passes[p].begin(), passes[p].end());
    }
    if (!twins.empty()) levels.push_back(twins);
  }

  void join(uint32_t v, uint32_t w) {
    if (v == w) return;
    neighbours[v].insert(w);
    neighbours[w].insert(v);
  }
  std::vector<uint32_t> nearest(uint32_t v) const {
    std::vector<uint32_t> out(neighbours[v].begin(), neighbours[v].end());
    std::stable_sort(out.begin(), out.end(),
                     [&](uint32_t a, uint32_t b) { return squared(v, a) < squared(v, b); });
    return out;
  }
  int64_t squared(uint32_t v, uint32_t w) const {
    int64_t sum = 0;
    for (size_t a = 0; a < 3; a++) {
      const int64_t u = int64_t(mesh.lattice[3 * size_t(v) + a]) - mesh.lattice[3 * size_t(w) + a];
      sum += u * u;
    }
    return sum;
  }
  std::vector<uint32_t> take(std::set<uint32_t> &left) {
    size_t with = 0;
    std::set<uint32_t> taken;
    for (const uint32_t v : left) {
      const auto &around = neighbours[v];
      with += !around.empty();
      if (around.empty() || around.size() > 8) continue;
      if (std::none_of(around.begin(), around.end(), [&](uint32_t w) { return taken.count(w); }))
        taken.insert(v);
    }
    if (with <= 24 || taken.size() < with / 6) return {};
    for (const uint32_t v : taken) {
      stencils[v] = nearest(v);
      const uint32_t into = stencils[v][0];
      for (const uint32_t w : stencils[v]) {
        neighbours[w].erase(v);
        join(into, w);
      }
      if (stencils[v].size() > 6) stencils[v].resize(6);
      left.erase(v);
    }
    return {taken.begin(), taken.end()};
  }
};

void same_as_plain(const fvv_mesh &mesh) {
  const Hierarchy h(mesh);
  const Plain plain(mesh);
  REQUIRE(h.level_count == plain.levels.size());
  for (uint32_t level = 0; level < h.level_count; level++) {
    REQUIRE(h.level_end[level] - h.begin(level) == plain.levels[level].size());
    for (uint32_t i = h.begin(level); i < h.level_end[level]; i++) {
      const uint32_t v = h.order[i];
      REQUIRE(v == plain.levels[level][i - h.begin(level)]);
      const fvv_delta_stencil &s = h.stencils[i];
      int64_t sum = 0;
      for (size_t n = 0; n < FVV_DELTA_NEIGHBOURS; n++) {
        sum += s.weight[n];
        if (!s.weight[n]) continue;
        REQUIRE(n < plain.stencils[v].size());
        REQUIRE(s.node[n] < i);
        REQUIRE(h.order[s.node[n]] == plain.stencils[v][n]);
      }
      REQUIRE(sum == (i ? 65536 : 0));
    }
  }
  CHECK(h.level_end[h.level_count - 1] == mesh.vertex_count);
}

} // namespace

TEST_CASE("levels and nodes of stencils are those of the plain words") {
  for (const auto &shape :
       {torus(120, 80), torus(40, 30, 0.3), sphere(40, 30), grid(40), charts(8), sponge(6, 0.5, 3),
        ragged(40, 30, 7), two_components(), fin(), bow_tie(), tetrahedron(), holed_hubs(60)})
    same_as_plain(*key_of(shape));
}

TEST_CASE("a stencil keeps to its piece of the surface, however near another one is") {
  // Two sheets of 30 x 30 vertices, one step of the lattice apart.
  std::vector<int32_t> positions;
  std::vector<uint32_t> faces;
  const int32_t side = 30;
  for (int32_t v = 0; v < 2 * side * side; v++)
    for (const int32_t x : {10 * (v % side), 10 * (v / side % side), v / (side * side)})
      positions.push_back(x);
  for (uint32_t sheet = 0; sheet < 2; sheet++)
    for (uint32_t y = 0; y + 1 < 30; y++)
      for (uint32_t x = 0; x + 1 < 30; x++) {
        const uint32_t a = sheet * 900 + y * 30 + x;
        for (const uint32_t i : {a, a + 1, a + 30, a + 1, a + 31, a + 30}) faces.push_back(i);
      }
  const auto scratch = key_of(tetrahedron());
  fvv_mesh mesh = mesh_of(positions, faces);
  mesh.allocator = scratch->allocator;
  const Hierarchy h(mesh);
  size_t looked = 0;
  const uint32_t survivors = h.level_end[0];
  for (uint32_t i = survivors; i < h.vertex_count; i++)
    for (size_t n = 0; n < FVV_DELTA_NEIGHBOURS; n++)
      if (h.stencils[i].weight[n]) {
        CHECK(h.order[h.stencils[i].node[n]] / 900 == h.order[i] / 900);
        looked++;
      }
  CHECK(looked > 5000);
}

TEST_CASE("degenerate meshes still form levels") {
  for (const int kind : {0, 1, 2, 3, 4, 5}) {
    std::vector<int32_t> p;
    std::vector<uint32_t> faces;
    const uint32_t count = 3000;
    const int32_t far = FVV_LATTICE_MAX;
    for (int32_t v = 0; v < int32_t(count); v++) {
      if (kind == 0) p.insert(p.end(), {5, 5, 5});                                    // one point
      if (kind == 1) p.insert(p.end(), {v, 0, 0});                                    // a line
      if (kind == 2) p.insert(p.end(), {v % 2 ? far : -far, v, v % 5 ? 0 : far});     // ends of the lattice
      if (kind == 3) p.insert(p.end(), {1 << (v % 28), 1 << (v / 28 % 28), v / 784}); // shells
      if (kind >= 4) p.insert(p.end(), {v * 7919 % 4096, v * 104729 % 4096, v});
    }
    for (uint32_t v = 0; v + 2 < count; v++) {
      // 4: a fan about one edge. 5: pieces of one triangle.
      const uint32_t a = kind == 4   ? 0
                         : kind == 5 ? v / 3 * 3
                                     : v,
                     b = kind == 4 ? 1 : a + 1, c = kind == 5 ? a + 2 : v + 2;
      for (const uint32_t i : {a, b, c}) faces.push_back(i);
    }
    const auto scratch = key_of(tetrahedron());
    fvv_mesh mesh = mesh_of(p, faces);
    mesh.allocator = scratch->allocator;
    same_as_plain(mesh);
    const Hierarchy h(mesh);
    const std::set<uint32_t> seen(h.order, h.order + count);
    CHECK(seen.size() == count);
  }
}

// ---- Delta frames: what comes back, and how large it is.

TEST_CASE("delta frames come back within the error, equal in encoder and decoder") {
  for (const uint32_t error : {0u, 1u, 2u, 7u}) {
    const auto key = key_of(torus(60, 40));
    Sequence encoder(*key), decoder(*key);
    for (int t = 1; t <= 12; t++) {
      const auto wanted = moved(*key, t, 2);
      const auto payload = encoder.encode(wanted, error);
      REQUIRE(decoder.decode(payload) == FVV_OK);
      REQUIRE(decoder.positions() == encoder.positions());
      CHECK(distance(decoder.positions(), wanted) <= int32_t(error));
      CHECK(header_of(payload).number == uint64_t(t));
    }
    const fvv_mesh *mesh = fvv_mesh_sequence_mesh(decoder.handle);
    CHECK(!memcmp(mesh->faces, key->faces, 12 * size_t(key->face_count)));
    CHECK(mesh->texture == nullptr);
  }
}

TEST_CASE("smooth motion takes a small part of a key frame") {
  // 0.5 mm steps, error 2: a quantiser of 2 mm.
  const auto key = key_of(torus(120, 80), 0.0005);
  Sequence encoder(*key);
  size_t bytes = 0;
  for (int t = 1; t <= 10; t++) bytes += encoder.encode(moved(*key, t), 2).size();
  const double bits = 8.0 * double(bytes) / 10 / key->vertex_count;
  const double of_key =
      8.0 * double(encoded(*canonical(torus(120, 80), 0.0005), FVV_MESH_DRACO, 7).size()) / key->vertex_count;
  INFO(bits << " bits a vertex, key " << of_key);
  CHECK(bits < 2.6);
  CHECK(bits < of_key / 5);
}

TEST_CASE("a mesh that does not move takes a header only") {
  const auto key = key_of(sphere(60, 40));
  Sequence encoder(*key), decoder(*key);
  const std::vector<int32_t> still(key->lattice, key->lattice + 3 * size_t(key->vertex_count));
  for (int t = 1; t <= 3; t++) {
    const auto payload = encoder.encode(still, 0);
    CHECK(payload.size() == 16 + 2 + 2 * header_of(payload).levels.size());
    REQUIRE(decoder.decode(payload) == FVV_OK);
    CHECK(decoder.positions() == still);
  }
  // Skipped levels teach the model nothing on either side.
  const auto payload = encoder.encode(moved(*key, 1, 3), 1);
  REQUIRE(decoder.decode(payload) == FVV_OK);
  CHECK(decoder.positions() == encoder.positions());
}

TEST_CASE("500 frames do not drift") {
  const auto key = key_of(torus(30, 20));
  Sequence encoder(*key), decoder(*key);
  int32_t worst = 0;
  for (int t = 1; t <= 500; t++) {
    const auto wanted = moved(*key, t % 90, 1);
    REQUIRE(decoder.decode(encoder.encode(wanted, 2)) == FVV_OK);
    worst = std::max(worst, distance(decoder.positions(), wanted));
  }
  CHECK(worst == 2);
}

TEST_CASE("vertices of a seam move together and cost nothing") {
  const auto key = key_of(charts(24), 0.0005);
  REQUIRE(key->texture);
  Sequence encoder(*key), decoder(*key);
  // A cube of n squares a side has 6 n^2 + 2 points; the rest are twins.
  const Hierarchy hierarchy(*key);
  const uint32_t last = hierarchy.level_count - 1;
  CHECK(hierarchy.level_end[last] - hierarchy.begin(last) == key->vertex_count - (6 * 24 * 24 + 2));
  for (int t = 1; t <= 5; t++) {
    const auto wanted = moved(*key, t);
    const auto payload = encoder.encode(wanted, 0);
    CHECK(header_of(payload).levels.back()[1] == 0);
    REQUIRE(decoder.decode(payload) == FVV_OK);
    CHECK(decoder.positions() == wanted);
  }
  const fvv_mesh *mesh = fvv_mesh_sequence_mesh(decoder.handle);
  CHECK(mesh->texture_bits == key->texture_bits);
  CHECK(!memcmp(mesh->texture, key->texture, 8 * size_t(key->vertex_count)));
}

TEST_CASE("levels partition the vertices, each larger than all before it") {
  for (const auto &key : {key_of(torus(120, 80)), key_of(sphere(40, 30)), key_of(tetrahedron()),
                          key_of(grid(40)), key_of(charts(8))}) {
    const Hierarchy hierarchy(*key);
    uint32_t sum = 0;
    for (uint32_t k = 0; k < hierarchy.level_count; k++) {
      const uint32_t size = hierarchy.level_end[k] - hierarchy.begin(k);
      CHECK(size > 0);
      if (k && !key->texture) CHECK(size > sum);
      sum += size;
    }
    CHECK(sum == key->vertex_count);
    // What no pass took, and two passes at most.
    if (!key->texture) CHECK(hierarchy.level_end[0] < 80);
  }
}

TEST_CASE("motion to the edge of the lattice and back is exact") {
  Shape far = torus(30, 20);
  const auto key = key_of(far, 0.001);
  Sequence encoder(*key), decoder(*key);
  for (const int32_t shift : {FVV_LATTICE_MAX - 3000, -(FVV_LATTICE_MAX - 3000), 0}) {
    std::vector<int32_t> wanted(key->lattice, key->lattice + 3 * size_t(key->vertex_count));
    for (int32_t &x : wanted) x += shift;
    for (size_t i = 0; i < 300; i++) wanted[i] = i % 2 ? FVV_LATTICE_MAX : -FVV_LATTICE_MAX;
    REQUIRE(decoder.decode(encoder.encode(wanted, 0)) == FVV_OK);
    CHECK(decoder.positions() == wanted);
    REQUIRE(decoder.decode(encoder.encode(wanted, 1000)) == FVV_OK);
    CHECK(decoder.positions() == encoder.positions());
  }
}

TEST_CASE("what an encoder cannot take leaves the sequence as it was") {
  const auto key = key_of(torus(30, 20));
  Sequence encoder(*key), decoder(*key);
  auto outside = moved(*key, 1);
  outside[7] = FVV_LATTICE_MAX + 1;
  fvv_bytes payload = {};
  fvv_diagnostic diagnostic = {};
  CHECK(fvv_mesh_sequence_encode(encoder.handle, outside.data(), nullptr, &payload, &diagnostic) ==
        FVV_ERROR_INPUT);
  CHECK(std::string(diagnostic.message) == "vertex 2: y index 268435457 is outside +-2^28");
  fvv_mesh_delta_options options;
  fvv_mesh_delta_options_default(&options);
  options.max_error = 32768;
  CHECK(fvv_mesh_sequence_encode(encoder.handle, outside.data(), &options, &payload, &diagnostic) ==
        FVV_ERROR_ARGUMENT);
  fvv_bytes_free(&payload);
  REQUIRE(decoder.decode(encoder.encode(moved(*key, 1), 1)) == FVV_OK);
  CHECK(decoder.positions() == encoder.positions());
}

TEST_CASE("a sequence without memory is an error and leaks nothing") {
  const auto key = key_of(torus(20, 12));
  const fvv_allocator allocator = memory::allocator();
  const auto wanted = moved(*key, 1);
  const size_t before = memory::state.live;
  bool done = false;
  for (int64_t n = 0; !done; n++) {
    fvv_mesh_sequence *sequence = nullptr;
    fvv_bytes payload = {};
    fvv_diagnostic diagnostic = {};
    payload.allocator = allocator;
    memory::reset(n);
    fvv_status status = fvv_mesh_sequence_open(key.get(), &allocator, &sequence, &diagnostic);
    CHECK((status == FVV_OK) == (sequence != nullptr));
    if (status == FVV_OK)
      status = fvv_mesh_sequence_encode(sequence, wanted.data(), nullptr, &payload, &diagnostic);
    memory::reset();
    done = status == FVV_OK;
    if (!done) CHECK(status == FVV_ERROR_MEMORY);
    fvv_bytes_free(&payload);
    fvv_mesh_sequence_close(sequence);
    REQUIRE(memory::state.live == before);
    REQUIRE(n < 1000);
  }
}

TEST_CASE("delta payloads are the same bytes on every machine") {
  // Positions without floating point; the CRCs were taken when the format was made.
  const auto key = key_of(grid(24, 0), 0.001);
  Sequence encoder(*key);
  uint32_t crc = 0;
  for (int t = 1; t <= 4; t++) {
    std::vector<int32_t> wanted;
    for (uint32_t v = 0; v < key->vertex_count; v++) {
      const int32_t *p = key->lattice + 3 * size_t(v);
      wanted.push_back(p[0] + t * (p[1] / 16));
      wanted.push_back(p[1] - t * (p[0] / 16));
      wanted.push_back(p[2] + (p[0] * p[1] / 500 * t) % 23);
    }
    const auto payload = encoder.encode(wanted, 1);
    crc = fvv_crc32c(crc, payload.data(), payload.size());
  }
  CHECK(crc == 0x4959e8d8u);
}
