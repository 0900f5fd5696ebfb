// Hostile MESH payloads of at most 4 KiB: with any content they cost at most 64 MiB and little time, and what
// decodes is a mesh.
#include "fvv_catch.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <random>
#include <string>

#include "draco_direct.h"
#include "fast_plain.h"
#include "memory.h"
#include "shapes.h"

extern "C" {
#include "base/bytes.h"
#include "mesh/draco_check.h"
}

namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr int mutations = 6000, symbol_strings = 100, stride = 7;
#else
constexpr int mutations = 300000, symbol_strings = 3000, stride = 1;
#endif

using Payload = std::vector<uint8_t>;

// Runs every case and keeps the worst.
struct Judge {
  size_t peak = 0;
  double seconds = 0;
  int accepted = 0, refused = 0, wrong = 0;
  const char *worst = "none";

  void look(const Payload &payload, const char *name) {
    const fvv_allocator allocator = memory::allocator();
    fvv_mesh mesh = {};
    fvv_diagnostic diagnostic = {};
    memory::reset();
    const size_t before = memory::state.live;
    const clock_t begin = clock();
    const fvv_status status = decode(payload, &mesh, &diagnostic, &allocator);
    const double spent = double(clock() - begin) / CLOCKS_PER_SEC;
    peak = std::max(peak, memory::state.peak - before);
    if (spent > seconds) worst = name;
    seconds = std::max(seconds, spent);
    if (status == FVV_OK) {
      accepted++;
      wrong += !sound(mesh);
    } else {
      refused++;
      const bool known =
          status == FVV_ERROR_INVALID || status == FVV_ERROR_UNSUPPORTED || status == FVV_ERROR_LIMIT;
      wrong += !known || !diagnostic.issue || mesh.lattice || mesh.faces || mesh.texture || mesh.normals;
    }
    fvv_mesh_free(&mesh);
    wrong += memory::state.live != before;
  }

  static bool sound(const fvv_mesh &mesh) {
    std::vector<bool> used(mesh.vertex_count);
    for (uint32_t i = 0; i < 3 * mesh.face_count; i++) {
      if (mesh.faces[i] >= mesh.vertex_count) return false;
      used[mesh.faces[i]] = true;
    }
    for (uint32_t i = 0; i < 3 * mesh.vertex_count; i++)
      if (mesh.lattice[i] > FVV_LATTICE_MAX || mesh.lattice[i] < -FVV_LATTICE_MAX) return false;
    if (!mesh.texture != !mesh.texture_bits || mesh.texture_bits > 16) return false;
    for (uint32_t i = 0; mesh.texture && i < 2 * mesh.vertex_count; i++)
      if (mesh.texture[i] > uint32_t(1) << mesh.texture_bits) return false;
    if (!mesh.normals != !mesh.normal_bits || mesh.normal_bits > 12) return false;
    for (uint32_t i = 0; mesh.normals && i < 2 * mesh.vertex_count; i++)
      if (mesh.normals[i] > (uint32_t(1) << mesh.normal_bits) - 2) return false;
    return mesh.vertex_count >= 3 && std::find(used.begin(), used.end(), false) == used.end();
  }

  void report(const char *what) const {
    std::printf("%s: %d accepted, %d refused, peak %.2f MiB, slowest %.1f ms (%s)\n", what, accepted, refused,
                double(peak) / (1 << 20), 1000 * seconds, worst);
    CHECK(wrong == 0);
    CHECK(peak <= size_t(64) << 20);
    // The aim is 50 ms; machines that do other things at the same time get more.
    CHECK(seconds < 1);
  }
};

struct Case {
  const char *name;
  Payload payload;
};

std::vector<Case> corpus() {
  Shape far = tetrahedron(2.0 * FVV_LATTICE_MAX);
  for (double &x : far.positions) x -= FVV_LATTICE_MAX;
  DracoOptions sequential;
  sequential.sequential = true;
  std::vector<Case> all = {
      {"raw", encoded(*canonical(tetrahedron()), FVV_MESH_RAW, 0)},
      {"tetrahedron", encoded(*canonical(tetrahedron()), FVV_MESH_DRACO, 0)},
      {"fin", encoded(*canonical(fin()), FVV_MESH_DRACO, 5)},
      {"bow-tie", encoded(*canonical(bow_tie()), FVV_MESH_DRACO, 10)},
      {"far", encoded(*canonical(far, 1), FVV_MESH_DRACO, 7)},
      {"sphere", encoded(*canonical(sphere(12, 8)), FVV_MESH_DRACO, 7)},
      {"ragged", encoded(*canonical(ragged(20, 10, 5)), FVV_MESH_DRACO, 5)},
      {"torus, valence", encoded(*canonical(torus(30, 18), 0.005), FVV_MESH_DRACO, 7)},
      {"torus, creases", encoded(*canonical(torus(30, 18), 0.005), FVV_MESH_DRACO, 10)},
      {"sequential", draco_payload(*canonical(grid(8), 0.001), sequential)},
      {"torus, fast", encoded(*canonical(torus(20, 15)), FVV_MESH_FAST, 0)},
      {"charts, fast", encoded(*canonical(charts(4)), FVV_MESH_FAST, 0)},
      {"tetrahedron, fast", FastPlain(*canonical(tetrahedron())).payload()},
      {"charts, raw", encoded(*canonical(charts(2)), FVV_MESH_RAW, 0)},
      {"charts, difference", encoded(*canonical(charts(4)), FVV_MESH_DRACO, 0)},
      {"charts, parallelogram", encoded(*canonical(charts(4)), FVV_MESH_DRACO, 7)},
      {"charts, creases", encoded(*canonical(charts(12)), FVV_MESH_DRACO, 10)},
      {"normals, raw", encoded(*canonical(hard_cube(2), 0.001, nullptr, 8), FVV_MESH_RAW, 0)},
      {"normals, Draco", encoded(*canonical(hard_cube(4), 0.001, nullptr, 12), FVV_MESH_DRACO, 7)},
      {"charts, sequential", draco_payload(*canonical(charts(4)), sequential)},
  };
  for (const Case &c : all) {
    INFO(c.name);
    REQUIRE(c.payload.size() <= 4096);
    Mesh mesh;
    fvv_diagnostic diagnostic = {};
    REQUIRE(decode(c.payload, &mesh, &diagnostic) == FVV_OK);
  }
  return all;
}

void put_varint(Payload &out, uint64_t value) {
  uint8_t bytes[10];
  const size_t size = fvv_put_uleb(bytes, value);
  for (size_t i = 0; i < size; i++) out.push_back(bytes[i]);
}

void put_bytes(Payload &out, std::initializer_list<int> bytes) {
  for (const int b : bytes) out.push_back(uint8_t(b));
}

void declare(Payload &payload, fvv_draco_counts counts) {
  fvv_put_u32(&payload[4], counts.vertices);
  fvv_put_u32(&payload[8], counts.faces);
}

// As an attacker would do: the MESH header agrees with the damaged Draco header.
void repair(Payload &payload) {
  fvv_draco_counts counts;
  fvv_diagnostic diagnostic = {};
  if (payload.size() > 28 &&
      fvv_draco_read_counts(payload.data() + 16, payload.size() - 16, &counts, &diagnostic) == FVV_OK)
    declare(payload, counts);
}

// A well-formed payload around edgebreaker symbols of one's choice. All positions are one and the same value,
// and with texture all texture indices are; alphabet is the coding of what comes last: number of bits, number
// of values, probabilities.
Payload of_symbols(const std::string &symbols, const Payload &alphabet = {1, 1, 1, 64},
                   bool texture = false) {
  const auto count = [&](char c) { return uint32_t(std::count(symbols.begin(), symbols.end(), c)); };
  Payload bits((symbols.size() + 2 * (symbols.size() - count('C')) + 7) / 8);
  size_t at = 0;
  const auto put = [&](unsigned value, unsigned width) {
    for (unsigned i = 0; i < width; i++, at++)
      bits[at / 8] = uint8_t(bits[at / 8] | (value >> i & 1) << at % 8);
  };
  for (const char c : symbols) {
    if (c == 'C') put(0, 1);
    if (c != 'C') put(c == 'S' ? 1 : c == 'L' ? 3 : c == 'R' ? 5 : 7, 3);
  }
  const uint32_t faces = uint32_t(symbols.size());
  const uint32_t vertices = 3 * count('E') + count('L') + count('R') - count('S');
  Payload p(16);
  p[0] = FVV_MESH_DRACO;
  put_bytes(p, {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0, 0});
  put_varint(p, vertices);
  put_varint(p, faces);
  p.push_back(0);
  put_varint(p, faces); // symbols: no face without
  put_varint(p, count('S'));
  p.push_back(0);
  put_varint(p, bits.size());
  p.insert(p.end(), bits.begin(), bits.end());
  put_bytes(p, {255, 1, 63});                                   // start faces: the first bits are not set
  put_bytes(p, {1, 255, 0, 0, texture ? 2 : 1, 0, 5, 3, 0, 0}); // positions
  if (texture) put_bytes(p, {3, 5, 2, 0, 1, 1});
  p.push_back(1);
  for (int left = texture ? 2 : 1; left; left--) {
    put_bytes(p, {1, 1, 1, 1}); // parallelogram; compressed, raw
    const Payload &chosen = left == 1 ? alphabet : Payload{1, 1, 1, 64};
    p.insert(p.end(), chosen.begin(), chosen.end());
    put_bytes(p, {1, 0});
    put_bytes(p, {0, 0, 0, 0, 0, 0, 0, 0}); // all values lie between 0 and 0
  }
  p[1] = texture;
  p[2] = texture ? 12 : 0;
  declare(p, {vertices, faces});
  return p;
}

std::string repeat(const std::string &text, size_t count) {
  std::string all;
  for (size_t i = 0; i < count; i++) all += text;
  return all;
}

} // namespace

TEST_CASE("no prefix of a payload decodes") {
  Judge judge;
  for (const Case &c : corpus())
    for (size_t size = 0; size < c.payload.size(); size++)
      judge.look({c.payload.begin(), c.payload.begin() + ptrdiff_t(size)}, c.name);
  judge.report("prefixes");
  CHECK(judge.accepted == 0);
}

TEST_CASE("single damaged bytes are survived", "[slow]") {
  Judge judge;
  for (const Case &c : corpus())
    for (size_t at = 0; at < c.payload.size(); at += stride)
      for (const uint8_t value : {0x00, 0x7f, 0x80, 0xff})
        for (const bool repaired : {false, true}) {
          Payload bad = c.payload;
          bad[at] = value;
          if (repaired) repair(bad);
          judge.look(bad, c.name);
        }
  judge.report("single bytes");
}

TEST_CASE("random damage is survived", "[slow]") {
  Judge judge;
  const auto cases = corpus();
  std::mt19937 random(1);
  for (int i = 0; i < mutations; i++) {
    const Case &c = cases[random() % cases.size()];
    Payload bad = c.payload;
    for (unsigned changes = 1 + random() % 3; changes; changes--) {
      // Half of them hit the headers, which decide on memory.
      const size_t at = random() % (random() % 2 ? bad.size() : std::min<size_t>(bad.size(), 70));
      switch (random() % 4) {
      case 0:
        bad.insert(bad.begin() + ptrdiff_t(at), uint8_t(random()));
        break;
      case 1:
        if (bad.size() > 20) bad.erase(bad.begin() + ptrdiff_t(at));
        break;
      default:
        bad[at] = uint8_t(random());
      }
    }
    if (random() % 4) repair(bad);
    judge.look(bad, c.name);
  }
  judge.report("random damage");
}

TEST_CASE("hostile connectivity is survived", "[slow]") {
  Judge judge;
  const size_t bits = 8 * (4096 - 100);
  const std::string chosen[] = {
      "E", "ER", repeat("E", bits / 3), "E" + repeat("R", bits / 3 - 1), "E" + repeat("L", bits / 3 - 1),
      "E" + repeat("RC", bits / 4 - 1), "E" + repeat("LR", bits / 6 - 1),
      repeat("E", bits / 6) + repeat("S", bits / 6 - 1),
      // A vertex of a third of all faces is walked around for each S.
      repeat("E", bits / 16) + "E" + repeat("R", bits / 6 - 8) + repeat("SCC", bits / 16),
      repeat("E", bits / 16) + "E" + repeat("L", bits / 6 - 8) + repeat("SCC", bits / 16),
      repeat("E", bits / 12) + "E" + repeat("R", bits / 6 - 8) + repeat("S", bits / 12),
      repeat("E", bits / 18) + "E" + repeat("R", bits / 6 - 8) + repeat("SR", bits / 18)};
  for (const bool texture : {false, true})
    for (const std::string &symbols : chosen) {
      const Payload payload = of_symbols(symbols, {1, 1, 1, 64}, texture);
      REQUIRE(payload.size() <= 4096);
      judge.look(payload, texture ? "chosen symbols, texture" : "chosen symbols");
    }
  CHECK(judge.accepted >= 16);
  // The widest table that 4 KiB can hold: 64 values without a probability for each byte, precision 20 bits.
  Payload widest = {18};
  put_varint(widest, 64 * 3900 + 1);
  widest.insert(widest.end(), 3900, 0xff);
  put_bytes(widest, {2, 0, 64});
  judge.look(of_symbols("E", widest), "widest table");
  judge.look(of_symbols("E", widest, true), "widest table, texture");
  std::mt19937 random(2);
  for (int i = 0; i < symbol_strings; i++) {
    // Whether a symbol is allowed depends on the boundary; most that keep the stack filled go far.
    std::string symbols = "E";
    double weights[5];
    for (double &weight : weights) weight = double(random() % 8);
    weights[3]++;
    std::discrete_distribution<int> pick(weights, weights + 5);
    int stack = 1;
    for (size_t used = 3; used + 3 < bits;) {
      char c = "CSLRE"[pick(random)];
      if (c == 'S' && stack < 2) c = 'R';
      stack += c == 'E' ? 1 : c == 'S' ? -1 : 0;
      used += c == 'C' ? 1 : 3;
      symbols += c;
    }
    judge.look(of_symbols(symbols, {1, 1, 1, 64}, i % 2), "random symbols");
  }
  judge.report("connectivity");
}

TEST_CASE("counts at the bound of the density are refused or stay within it") {
  Judge judge;
  for (const Case &c : corpus()) {
    if (c.payload[0] != FVV_MESH_DRACO) continue;
    const uint32_t most = uint32_t(FVV_DRACO_DENSITY * (c.payload.size() - 16));
    for (const uint32_t faces : {most, most / 2, most - 1}) {
      // Draco's own numbers are put in: vertices, faces and, for edgebreaker, symbols and splits.
      const bool edgebreaker = c.payload[24] == 1;
      fvv_cursor cursor = {c.payload.data(), c.payload.size(), edgebreaker ? 28u : 27u, 0};
      fvv_cursor_uleb(&cursor);
      fvv_cursor_uleb(&cursor);
      Payload bad(c.payload.begin(), c.payload.begin() + (edgebreaker ? 28 : 27));
      put_varint(bad, most);
      put_varint(bad, edgebreaker ? faces : most);
      if (edgebreaker) {
        fvv_cursor_take(&cursor, 1);
        fvv_cursor_uleb(&cursor);
        fvv_cursor_uleb(&cursor);
        bad.push_back(0);
        put_varint(bad, faces);
        put_varint(bad, faces / 3);
      }
      bad.insert(bad.end(), c.payload.begin() + ptrdiff_t(cursor.position), c.payload.end());
      repair(bad);
      judge.look(bad, c.name);
    }
  }
  judge.report("inflated counts");
  CHECK(judge.accepted == 0);
}
