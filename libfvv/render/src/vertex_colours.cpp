// Colours of vertices from pictures, and from their neighbours where there are none.
#include "fvv_render/vertex_colours.h"

#include "fvv_render/normals.h"
#include "fvv_render/ray_visibility.h"

#include <algorithm>
#include <cmath>

namespace fvv::render {

namespace {

constexpr double good_cosine = 0.35, least_cosine = 0.1;
constexpr int border = 4;      // pixels from the silhouette, where matting leaves soft edges
constexpr double likely = 24;  // of 255: how much cameras differ that show the same
constexpr int smoothings = 40; // of colours that were taken from neighbours
constexpr uint8_t certain = 255, uncertain = 32;

struct Sample {
  Vec3 colour;
  double weight;
};

// Vertices that share a face, without repetition.
class Neighbours {
public:
  explicit Neighbours(const Mesh &mesh) : first(mesh.vertex_count + 1), around(6 * mesh.face_count) {
    for (size_t i = 0; i < 3 * mesh.face_count; i++) first[mesh.faces[i] + 1] += 2;
    for (size_t v = 0; v < mesh.vertex_count; v++) first[v + 1] += first[v];
    std::vector<size_t> next(first.begin(), first.end() - 1);
    for (size_t f = 0; f < mesh.face_count; f++)
      for (int k = 0; k < 3; k++)
        for (int other = 1; other < 3; other++)
          around[next[mesh.faces[3 * f + size_t(k)]]++] = mesh.faces[3 * f + size_t((k + other) % 3)];
  }
  const uint32_t *begin(size_t v) const { return around.data() + first[v]; }
  const uint32_t *end(size_t v) const { return around.data() + first[v + 1]; }

private:
  std::vector<size_t> first;
  std::vector<uint32_t> around;
};

// What one camera shows.
class ColourSampler {
public:
  ColourSampler(const ColourView &shown, const Mesh &mesh, const Neighbours &neighbours) : view(shown) {
    double place[3];
    fvv_camera_centre(&view.camera, place);
    centre = {place[0], place[1], place[2]};
    if (!view.seen) {
      rays = visible_vertices(view.camera, mesh, RayCaster(mesh));
      for (uint8_t &seen : rays) seen = seen ? 255 : 0;
      view.seen = rays.data();
    }
    inside.resize(mesh.vertex_count);
    for (size_t v = 0; v < mesh.vertex_count; v++)
      inside[v] = view.seen[v] > 127 && std::all_of(neighbours.begin(v), neighbours.end(v),
                                                    [&](uint32_t other) { return view.seen[other] > 127; });
  }

  // Weight 0: it does not show the vertex. good: nothing next to it is mixed into its colour.
  Sample sample(size_t vertex, Vec3 position, Vec3 normal, bool &good) const {
    const double cosine = dot(normal, normalised(centre - position));
    double at[2];
    const double world[3] = {position.x, position.y, position.z};
    good = false;
    if (view.seen[vertex] < 128 || !(cosine > least_cosine)) return {{}, 0};
    if (fvv_camera_project(&view.camera, world, at, nullptr) != 1) return {{}, 0};
    if (!(at[0] >= 0.5 && at[1] >= 0.5 && at[0] <= view.camera.width - 0.5 &&
          at[1] <= view.camera.height - 0.5))
      return {{}, 0};
    if (!in_mask(at[0], at[1])) return {{}, 0};
    good = inside[vertex] && cosine >= good_cosine && away_from_border(at[0], at[1]);
    return {colour(at[0] - 0.5, at[1] - 0.5), cosine * cosine};
  }

private:
  bool in_mask(double u, double v) const {
    if (!view.mask) return true;
    if (!(u >= 0 && v >= 0 && u < view.camera.width && v < view.camera.height)) return false;
    return view.mask[size_t(v) * view.camera.width + size_t(u)] > 127;
  }

  bool away_from_border(double u, double v) const {
    for (int y = -border; y <= border; y += border / 2)
      for (int x = -border; x <= border; x += border / 2)
        if (!in_mask(u + x, v + y)) return false;
    return true;
  }

  Vec3 colour(double x, double y) const {
    const uint32_t left = uint32_t(x), top = uint32_t(y);
    const uint32_t right = std::min(left + 1, view.camera.width - 1),
                   bottom = std::min(top + 1, view.camera.height - 1);
    const auto texel = [&](uint32_t column, uint32_t row) {
      const uint8_t *p = view.pixels + 3 * (size_t(row) * view.camera.width + column);
      return Vec3{double(p[0]), double(p[1]), double(p[2])};
    };
    return mix(mix(texel(left, top), texel(right, top), x - left),
               mix(texel(left, bottom), texel(right, bottom), x - left), y - top);
  }

  ColourView view;
  Vec3 centre;
  std::vector<uint8_t> rays, inside;
};

// The mean, in which cameras that differ from the others count little.
Vec3 robust_mean(const std::vector<Sample> &samples) {
  Vec3 mean;
  for (int round = 0; round < 4; round++) {
    Vec3 sum;
    double all = 0;
    for (const Sample &sample : samples) {
      const Vec3 off = sample.colour - mean;
      const double weight = round ? sample.weight / (1 + dot(off, off) / (likely * likely)) : sample.weight;
      sum += sample.colour * weight;
      all += weight;
    }
    mean = sum * (1 / all);
  }
  return mean;
}

// Colours of vertices without any, from those around them: ring by ring, then smoothed.
void spread(const Neighbours &neighbours, std::vector<Vec3> &colours, std::vector<uint8_t> &known) {
  std::vector<uint32_t> filled, ring;
  for (size_t v = 0; v < colours.size(); v++) {
    const bool rim = !known[v] && std::any_of(neighbours.begin(v), neighbours.end(v),
                                              [&](uint32_t other) { return known[other] != 0; });
    if (rim) ring.push_back(uint32_t(v));
  }
  const auto mean_around = [&](uint32_t v) {
    Vec3 sum;
    double count = 0;
    for (const uint32_t *other = neighbours.begin(v); other < neighbours.end(v); other++)
      if (known[*other]) {
        sum += colours[*other];
        count++;
      }
    return sum * (1 / count);
  };
  while (!ring.empty()) {
    std::vector<uint32_t> next;
    for (const uint32_t v : ring) colours[v] = mean_around(v);
    for (const uint32_t v : ring) known[v] = 1;
    for (const uint32_t v : ring)
      for (const uint32_t *other = neighbours.begin(v); other < neighbours.end(v); other++)
        if (!known[*other]) next.push_back(*other);
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    filled.insert(filled.end(), ring.begin(), ring.end());
    ring = std::move(next);
  }
  for (int round = 0; round < smoothings; round++)
    for (const uint32_t v : filled) colours[v] = mean_around(v);
}

uint8_t byte_of(double value) {
  return uint8_t(std::clamp(std::floor(value + 0.5), 0.0, 255.0));
}

} // namespace

struct VertexColourGatherer::State {
  // What a camera shows of a vertex.
  struct Found {
    uint32_t vertex;
    bool good; // nothing next to the vertex is mixed into its colour
    Sample sample;
  };
  explicit State(const Mesh &of) : mesh(of), neighbours(of), normals(vertex_normals(of)) {}

  const Mesh &mesh;
  const Neighbours neighbours;
  const std::vector<Vec3> normals;
  std::vector<std::vector<Found>> cameras; // by rising vertex
};

VertexColourGatherer::VertexColourGatherer(const Mesh &mesh) : state(std::make_unique<State>(mesh)) {}
VertexColourGatherer::~VertexColourGatherer() = default;

void VertexColourGatherer::add(const ColourView &view) {
  const Mesh &mesh = state->mesh;
  const ColourSampler sampler(view, mesh, state->neighbours);
  std::vector<State::Found> &found = state->cameras.emplace_back();
  for (size_t v = 0; v < mesh.vertex_count; v++) {
    const float *p = mesh.positions + 3 * v;
    bool good;
    const Sample sample = sampler.sample(v, {p[0], p[1], p[2]}, state->normals[v], good);
    if (sample.weight > 0) found.push_back({uint32_t(v), good, sample});
  }
  found.shrink_to_fit();
}

VertexColours VertexColourGatherer::colours() const {
  const size_t count = state->mesh.vertex_count;
  VertexColours out;
  out.weight.resize(count);
  std::vector<Vec3> colours(count);
  std::vector<uint8_t> known(count);
  std::vector<size_t> next(state->cameras.size());
  std::vector<Sample> good, poor;
  Vec3 sum;
  double shown = 0;
  for (size_t v = 0; v < count; v++) {
    good.clear();
    poor.clear();
    for (size_t i = 0; i < next.size(); i++) {
      const std::vector<State::Found> &found = state->cameras[i];
      if (next[i] == found.size() || found[next[i]].vertex != v) continue;
      const State::Found &one = found[next[i]++];
      (one.good ? good : poor).push_back(one.sample);
    }
    if (good.empty() && poor.empty()) continue;
    colours[v] = robust_mean(good.empty() ? poor : good);
    out.weight[v] = good.empty() ? uncertain : certain;
    known[v] = 1;
    sum += colours[v];
    shown++;
  }
  spread(state->neighbours, colours, known);
  const Vec3 all = shown > 0 ? sum * (1 / shown) : Vec3{128, 128, 128};
  out.rgb.reserve(3 * count);
  for (size_t v = 0; v < count; v++) {
    const Vec3 colour = known[v] ? colours[v] : all;
    for (const double value : {colour.x, colour.y, colour.z}) out.rgb.push_back(byte_of(value));
  }
  return out;
}

} // namespace fvv::render
