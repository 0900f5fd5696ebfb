// Levels and weights of delta frames, held against arithmetic in floating point.
#include "fvv_catch.h"

#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

#include "delta_shapes.h"

extern "C" {
#include "mesh/delta_hierarchy.h"
}

namespace {

using Cell = std::tuple<int32_t, int32_t, int32_t>;

struct Hierarchy : fvv_delta_hierarchy {
  explicit Hierarchy(const fvv_mesh &mesh) : fvv_delta_hierarchy() {
    REQUIRE(fvv_delta_hierarchy_build(mesh.positions, mesh.vertex_count, &mesh.allocator, this) == FVV_OK);
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
  for (size_t a = 0; a < 3; a++) s[a][a] += trace / 8;
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

TEST_CASE("a level has one vertex for each occupied cell, nearest to the centre") {
  const auto key = key_of(torus(120, 80), 0.0005);
  const Hierarchy h(*key);
  REQUIRE(h.level_count >= 4);
  CHECK(!h.has_twins);
  int32_t least[3], extent = 0;
  for (size_t a = 0; a < 3; a++) {
    int32_t most = least[a] = key->positions[a];
    for (size_t v = 0; v < key->vertex_count; v++) {
      least[a] = std::min(least[a], key->positions[3 * v + a]);
      most = std::max(most, key->positions[3 * v + a]);
    }
    extent |= most - least[a];
  }
  int top = 0;
  while (extent >> top) top++;
  const auto cell = [&](uint32_t v, int shift) {
    const int32_t *p = key->positions + 3 * size_t(v);
    return Cell((p[0] - least[0]) >> shift, (p[1] - least[1]) >> shift, (p[2] - least[2]) >> shift);
  };
  uint32_t level = 0, placed = 0;
  for (int shift = top - 3; shift > 0; shift--) {
    std::set<Cell> occupied, held;
    for (uint32_t v = 0; v < key->vertex_count; v++) occupied.insert(cell(v, shift));
    if (3 * occupied.size() > key->vertex_count) break;
    if (occupied.size() < (placed ? 2 * placed : 64)) continue;
    REQUIRE(h.level_end[level] == occupied.size());
    for (uint32_t i = 0; i < h.level_end[level]; i++) {
      CHECK(held.insert(cell(h.order[i], shift)).second);
      if (i > h.begin(level)) CHECK(h.order[i] > h.order[i - 1]);
    }
    // Half of the side away from the nearest corner, or as near as any other vertex comes.
    std::map<Cell, double> nearest;
    const auto off = [&](uint32_t v) {
      double sum = 0;
      for (size_t a = 0; a < 3; a++) {
        const double side = std::ldexp(1, shift), x = key->positions[3 * size_t(v) + a] - least[a];
        const double d = x - (std::floor(x / side) + 0.5) * side;
        sum += d * d;
      }
      return sum;
    };
    for (uint32_t v = 0; v < key->vertex_count; v++) {
      const auto found = nearest.insert({cell(v, shift), off(v)});
      found.first->second = std::min(found.first->second, off(v));
    }
    for (uint32_t i = h.begin(level); i < h.level_end[level]; i++)
      CHECK(off(h.order[i]) == nearest[cell(h.order[i], shift)]);
    placed = h.level_end[level++];
  }
  CHECK(level + 1 == h.level_count);
  CHECK(h.level_end[level] == key->vertex_count);
}

TEST_CASE("a stencil has the nearest vertices of earlier levels around") {
  const auto key = key_of(torus(120, 80), 0.0005);
  const Hierarchy h(*key);
  size_t nearest_found = 0, looked = 0;
  for (uint32_t level = 1; level < h.level_count; level++)
    for (uint32_t i = h.begin(level); i < h.level_end[level]; i += 7) {
      const fvv_delta_stencil &s = h.stencils[i];
      const int32_t *x = key->positions + 3 * size_t(h.order[i]);
      const auto squared = [&](uint32_t place) {
        const int32_t *y = key->positions + 3 * size_t(h.order[place]);
        double sum = 0;
        for (int a = 0; a < 3; a++) sum += double(y[a] - x[a]) * (y[a] - x[a]);
        return sum;
      };
      double former = 0, best = 1e18;
      int64_t sum = 0;
      for (uint32_t n = 0; n < FVV_DELTA_NEIGHBOURS && s.weight[n]; n++) {
        CHECK(s.node[n] < h.begin(level));
        CHECK(squared(s.node[n]) >= former);
        former = squared(s.node[n]);
      }
      for (const int32_t w : s.weight) sum += w;
      CHECK(sum == 65536);
      for (uint32_t n = 0; n < h.begin(level); n++) best = std::min(best, squared(n));
      nearest_found += squared(s.node[0]) == best;
      looked++;
    }
  // A cell of 27 holds the nearest one nearly always.
  CHECK(nearest_found > looked * 99 / 100);
}

TEST_CASE("degenerate layouts of points still form levels") {
  for (const int kind : {0, 1, 2, 3}) {
    std::vector<int32_t> p;
    for (int32_t v = 0; v < 3000; v++) {
      const int32_t far = FVV_LATTICE_MAX;
      if (kind == 0) p.insert(p.end(), {5, 5, 5});                                    // one point
      if (kind == 1) p.insert(p.end(), {v, 0, 0});                                    // a line
      if (kind == 2) p.insert(p.end(), {v % 2 ? far : -far, v, v % 5 ? 0 : far});     // ends of the lattice
      if (kind == 3) p.insert(p.end(), {1 << (v % 28), 1 << (v / 28 % 28), v / 784}); // shells
    }
    fvv_delta_hierarchy h;
    const fvv_allocator allocator = {[](void *, void *q, size_t, size_t size) -> void * {
                                       if (size) return realloc(q, size);
                                       free(q);
                                       return nullptr;
                                     },
                                     nullptr};
    REQUIRE(fvv_delta_hierarchy_build(p.data(), 3000, &allocator, &h) == FVV_OK);
    CHECK(h.level_end[h.level_count - 1] == 3000);
    std::set<uint32_t> seen(h.order, h.order + 3000);
    CHECK(seen.size() == 3000);
    CHECK(h.has_twins == (kind == 0));
    fvv_delta_hierarchy_free(&h);
  }
}
