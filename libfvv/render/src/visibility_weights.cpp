#include "visibility_weights.h"

namespace fvv::render {

namespace {

constexpr int probes = 3; // the corners' parts; the middle is known by then

constexpr int state_count = 7;
constexpr int weights[state_count] = {127, 0, 255, 85, 170, 113, 142}; // of states, as fvv_visibility_weights
// The number of decisions, with the initial odds of a context, that statistics begin with.
constexpr double prior_sides = 4, prior_levels = 6;

int class_of(uint32_t count) {
  return count < 4 ? int(count) : count < 7 ? 4 : count < 10 ? 5 : 6;
}

// -log2, by multiplication alone: the same on every machine.
double bits_of(double probability) {
  double bits = 0;
  for (; probability < 1; probability *= 2) bits++;
  // Now from 1 to 2.
  for (double digit = 0.5; digit > 1e-4; digit /= 2) {
    probability *= probability;
    if (probability < 2) continue;
    probability /= 2;
    bits -= digit;
  }
  return bits;
}

} // namespace

WeightPlaces::WeightPlaces(Viewer &viewer, const Mesh &mesh, const std::vector<uint8_t> &selected,
                           const std::vector<uint32_t> &first, const std::vector<uint32_t> &around)
    : judged(mesh.face_count), free(mesh.face_count), mixed(mesh.vertex_count) {
  const auto look = [&](uint32_t f, int from, int to) {
    for (int p = from; p < to; p++) {
      const auto &[a, b, c] = twelfths[p];
      const bool seen = viewer.free(viewer.at(mesh.faces + size_t(3) * f, a, b, c), f);
      free[f] = uint16_t((free[f] & ~(1u << p)) | unsigned(seen) << p);
    }
  };
  std::vector<uint8_t> sides(mesh.vertex_count); // bit 0: of a hidden place around it; bit 1: of a seen one
  const auto side_of = [&](uint32_t f) {
    return uint8_t(free[f] == all_weight_places ? 2 : free[f] ? 3 : 1);
  };
  std::vector<uint32_t> queue; // vertices that an outline passes by
  const auto note = [&](uint32_t f) {
    for (int k = 0; k < 3; k++) {
      const uint32_t v = mesh.faces[size_t(3) * f + size_t(k)];
      const uint8_t before = sides[v];
      sides[v] |= side_of(f);
      if (before != 3 && sides[v] == 3) queue.push_back(v);
    }
  };
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    const uint32_t *face = mesh.faces + size_t(3) * f;
    if (!selected[f] || !viewer.face_in_picture(face)) continue;
    judged[f] = 1;
    free[f] = viewer.free(viewer.at(face, 4, 4, 4), f) ? all_weight_places : 0;
    note(f);
  }
  // Outlines are followed from face to face; queue grows meanwhile.
  std::vector<uint8_t> looked(mesh.face_count);
  for (size_t i = 0; i < queue.size(); i++)
    for (uint32_t k = first[queue[i]]; k < first[queue[i] + 1]; k++) {
      const uint32_t f = around[k];
      if (!judged[f] || looked[f]) continue;
      looked[f] = 1;
      look(f, 0, probes);
      if (side_of(f) != 3) continue;
      look(f, probes + 1, weight_place_count);
      note(f);
    }
  for (const uint32_t v : queue) mixed[v] = 1;
}

WeightNeighbours::WeightNeighbours(const Mesh &mesh, const std::vector<uint32_t> &starts,
                                   const std::vector<uint32_t> &around)
    : first(mesh.vertex_count + 1), rank(mesh.vertex_count) {
  beside.reserve(2 * around.size());
  std::vector<uint32_t> order; // breadth first
  order.reserve(mesh.vertex_count);
  std::vector<uint8_t> met(mesh.vertex_count);
  for (uint32_t v = 0; v < mesh.vertex_count; v++) {
    for (uint32_t k = starts[v]; k < starts[v + 1]; k++)
      for (int c = 0; c < 3; c++)
        if (const uint32_t w = mesh.faces[size_t(3) * around[k] + size_t(c)]; w != v) beside.push_back(w);
    first[v + 1] = uint32_t(beside.size());
  }
  for (uint32_t seed = 0; seed < mesh.vertex_count; seed++) {
    size_t i = order.size();
    const auto meet = [&](uint32_t v) {
      if (met[v]) return;
      met[v] = 1;
      rank[v] = uint32_t(order.size());
      order.push_back(v);
    };
    for (meet(seed); i < order.size(); i++)
      for (uint32_t k = starts[order[i]]; k < starts[order[i] + 1]; k++)
        for (int c = 0; c < 3; c++) meet(mesh.faces[size_t(3) * around[k] + size_t(c)]);
  }
}

WeightSearch::WeightSearch(const Mesh &seen, const WeightNeighbours &shared,
                           const std::vector<uint32_t> &starts, const std::vector<uint32_t> &of_vertices,
                           const std::vector<double> &areas, const WeightPlaces &looked,
                           const std::vector<uint16_t> &counting, const std::vector<uint8_t> &selected,
                           const uint8_t *last, const FitSettings &chosen)
    : mesh(seen), neighbours(shared), first(starts), around(of_vertices), area(areas), places(looked),
      weighs(counting), facing(selected), former(last), settings(chosen), shown(shown_by_states()),
      states(seen.vertex_count), rim(seen.vertex_count), all(seen.vertex_count), before(seen.vertex_count) {
  begin();
}

// Which places clause 17.4 shows, for each three states.
std::vector<uint16_t> WeightSearch::shown_by_states() {
  std::vector<uint16_t> out;
  for (const int a : weights)
    for (const int b : weights)
      for (const int c : weights) {
        unsigned places = 0;
        for (int p = 0; p < weight_place_count; p++) {
          const auto &[i, j, k] = twelfths[p];
          places |= unsigned(2 * (i * a + j * b + k * c) >= 12 * 255) << p;
        }
        out.push_back(uint16_t(places));
      }
  return out;
}

template <class Body> void WeightSearch::each_beside(uint32_t v, Body body) const {
  for (uint32_t i = neighbours.first[v]; i < neighbours.first[v + 1]; i++)
    if (states[neighbours.beside[i]]) body(neighbours.beside[i]);
}

// All or nothing, as most of what is around each vertex.
void WeightSearch::begin() {
  for (uint32_t v = 0; v < states.size(); v++) {
    if (!facing[v]) continue;
    int seen = 0, count = 0;
    bool near = false;
    for (uint32_t k = first[v]; k < first[v + 1]; k++) {
      const uint32_t f = around[k];
      if (!places.judged[f]) continue;
      for (int c = 0; c < 3; c++) near |= places.mixed[mesh.faces[size_t(3) * f + size_t(c)]] != 0;
      const unsigned counting = weighs[f] ? weighs[f] : all_weight_places;
      seen += count_of(places.free[f] & counting);
      count += count_of(counting);
    }
    states[v] = count && 2 * seen >= count ? FVV_VERTEX_SEEN : FVV_VERTEX_HIDDEN;
    if (near) doubtful.push_back(v);
  }
  for (uint32_t v = 0; v < states.size(); v++) {
    if (!facing[v]) continue;
    for (uint32_t i = neighbours.first[v]; i < neighbours.first[v + 1]; i++) {
      const uint32_t w = neighbours.beside[i];
      if (!states[w]) {
        rim[v] = 1;
        continue;
      }
      all[v][size_t(side_of(states[w]))]++;
      if (neighbours.rank[w] < neighbours.rank[v]) before[v][size_t(side_of(states[w]))]++;
    }
  }
}

uint32_t WeightSearch::others(uint32_t v) const {
  return uint32_t(class_of(all[v][size_t(!side_of(states[v]))]));
}

// The cost of decisions, by their current frequency in each context.
void WeightSearch::learn() {
  constexpr double least[classes] = {0, 1, 2, 3, 4, 7, 10};
  double sides[2][classes][classes][2], of_levels[classes][levels];
  for (auto &at : sides)
    for (int s = 0; s < classes; s++)
      for (int h = 0; h < classes; h++) {
        const double a = 8 * least[s] + 1, b = 8 * least[h] + 1;
        at[s][h][1] = prior_sides * a / (a + b);
        at[s][h][0] = prior_sides * b / (a + b);
      }
  for (auto &row : of_levels) row[0] = prior_levels * 0.75, row[1] = row[2] = prior_levels * 0.125;
  for (uint32_t v = 0; v < states.size(); v++) {
    if (!states[v]) continue;
    sides[rim[v]][class_of(before[v][1])][class_of(before[v][0])][side_of(states[v])]++;
    of_levels[others(v)][(states[v] - 1) / 2]++;
  }
  for (int z = 0; z < 2; z++)
    for (int s = 0; s < classes; s++)
      for (int h = 0; h < classes; h++)
        for (int side = 0; side < 2; side++)
          bits_of_side[z][s][h][side] =
              bits_of(sides[z][s][h][side] / (sides[z][s][h][0] + sides[z][s][h][1]));
  for (int c = 1; c < classes; c++)
    for (int l = 0; l < levels; l++)
      bits_of_level[c][l] = bits_of(of_levels[c][l] / (of_levels[c][0] + of_levels[c][1] + of_levels[c][2]));
}

double WeightSearch::side_bits(uint32_t v) const {
  return bits_of_side[rim[v]][class_of(before[v][1])][class_of(before[v][0])][side_of(states[v])];
}

double WeightSearch::level_bits(uint32_t v) const {
  return bits_of_level[others(v)][(states[v] - 1) / 2];
}

// A vertex of two common faces is twice in the list of neighbours.
double WeightSearch::price(uint32_t v, bool of_side) const {
  double bits = level_bits(v), change = 0;
  if (of_side) {
    bits += side_bits(v);
    each_beside(v, [&](uint32_t w) {
      bits += 0.5 * level_bits(w);
      if (neighbours.rank[w] > neighbours.rank[v]) bits += 0.5 * side_bits(w);
    });
  }
  if (former && former[v] && former[v] != states[v])
    change = side_of(former[v]) != side_of(states[v]) ? settings.change : settings.change / 4;
  return settings.bit * bits + change;
}

double WeightSearch::wrong(uint32_t f) const {
  const uint32_t *face = mesh.faces + size_t(3) * f;
  const size_t says = size_t(states[face[0]]) * state_count * state_count +
                      size_t(states[face[1]]) * state_count + states[face[2]];
  return area[f] * count_of(unsigned(shown[says] ^ places.free[f]) & weighs[f]) / weight_place_count;
}

double WeightSearch::wrong_around(uint32_t v) const {
  double sum = 0;
  for (uint32_t k = first[v]; k < first[v + 1]; k++) sum += wrong(around[k]);
  return sum;
}

void WeightSearch::set(uint32_t v, uint8_t state) {
  const auto was = size_t(side_of(states[v])), is = size_t(side_of(state));
  states[v] = state;
  if (was == is) return;
  each_beside(v, [&](uint32_t w) {
    all[w][was]--;
    all[w][is]++;
    if (neighbours.rank[v] > neighbours.rank[w]) return;
    before[w][was]--;
    before[w][is]++;
  });
}

bool WeightSearch::attempt(uint32_t v, uint8_t state, double worse) {
  const uint8_t old = states[v];
  const bool of_side = side_of(old) != side_of(state);
  const double most = wrong_around(v) + price(v, of_side) + worse;
  // Most are worse by the error alone, whatever they cost.
  states[v] = state;
  const double error = wrong_around(v);
  states[v] = old;
  if (!(error < most)) return false;
  set(v, state);
  if (error + price(v, of_side) < most) return true;
  set(v, old);
  return false;
}

// worse: by how much the sum may grow with one weight. Returns whether any was changed.
bool WeightSearch::improve(double worse) {
  bool changed = false;
  for (const uint32_t v : doubtful) {
    if (!others(v) && wrong_around(v) == 0) continue;
    changed |= attempt(v, uint8_t(states[v] + (side_of(states[v]) ? -1 : 1)), worse);
    // A change of the sum by 0 is accepted too: the commonest and cheapest states are tried last.
    for (int level = levels - 1; level >= 0 && others(v); level--)
      if (const int state = FVV_VERTEX_HIDDEN + side_of(states[v]) + 2 * level; state != states[v])
        changed |= attempt(v, uint8_t(state), worse);
  }
  return changed;
}

std::vector<uint8_t> WeightSearch::run() {
  accept_by_threshold(settings.tolerance, [&](double worse) {
    // In the end prices are fixed, so that the sum only falls.
    if (worse > 0) learn();
    return improve(worse);
  });
  for (uint32_t v = 0; v < states.size(); v++)
    if (states[v] && !others(v)) states[v] = uint8_t(FVV_VERTEX_HIDDEN + side_of(states[v]));
  return states;
}

} // namespace fvv::render
