#include "hull_mesh.h"
#include "fvv_cxx/parallel.h"
#include "octree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fvv::hull {

namespace {

// Vertices that faces connect have one root.
class Union {
public:
  explicit Union(size_t count) : parent(count) { std::iota(parent.begin(), parent.end(), 0u); }
  uint32_t root(uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  }
  void join(uint32_t a, uint32_t b) { parent[root(a)] = root(b); }

private:
  std::vector<uint32_t> parent;
};

// A bit for every point of a grid.
class Bits {
public:
  explicit Bits(std::vector<uint8_t> &of) : bytes(of) {}
  bool get(size_t i) const { return bytes[i / 8] >> i % 8 & 1; }
  void flip(size_t i) { bytes[i / 8] ^= uint8_t(1u << i % 8); }

private:
  std::vector<uint8_t> &bytes;
};

// Flips the points that are connected along the axes with one and have its value.
void flood(const Grid &grid, Bits bits, size_t from) {
  const bool value = bits.get(from);
  std::vector<size_t> stack{from};
  bits.flip(from);
  while (!stack.empty()) {
    const size_t point = stack.back();
    stack.pop_back();
    const std::array<size_t, 3> p = grid.place(point);
    for (int axis = 0; axis < 3; axis++) {
      const size_t stride = grid.stride(axis), at = p[size_t(axis)];
      for (const size_t next :
           {at > 0 ? point - stride : point, at + 1 < grid.count[size_t(axis)] ? point + stride : point})
        if (next != point && bits.get(next) == value) {
          bits.flip(next);
          stack.push_back(next);
        }
    }
  }
}

// Without the faces and vertices of pieces that are dropped.
void compact(Surface &surface, const std::vector<bool> &dropped_vertex) {
  std::vector<uint32_t> place(surface.vertices.size());
  uint32_t count = 0;
  for (size_t v = 0; v < place.size(); v++) {
    if (dropped_vertex[v]) continue;
    surface.vertices[count] = surface.vertices[v];
    surface.crossings[count] = surface.crossings[v];
    place[v] = count++;
  }
  surface.vertices.resize(count);
  surface.crossings.resize(count);
  size_t faces = 0;
  for (size_t i = 0; i < surface.faces.size(); i += 3) {
    if (dropped_vertex[surface.faces[i]]) continue;
    for (size_t c = 0; c < 3; c++) surface.faces[faces + c] = place[surface.faces[i + c]];
    faces += 3;
  }
  surface.faces.resize(faces);
}

} // namespace

void drop_components(Hull &hull, double min_share) {
  Surface &surface = hull.surface;
  Union joined(surface.vertices.size());
  for (size_t i = 0; i < surface.faces.size(); i += 3)
    for (size_t c = 1; c < 3; c++) joined.join(surface.faces[i], surface.faces[i + c]);
  std::vector<double> volume(surface.vertices.size()); // of roots
  for (size_t i = 0; i < surface.faces.size(); i += 3) {
    const auto corner = [&](size_t c) { return surface.vertices[surface.faces[i + c]] - hull.grid.origin; };
    volume[joined.root(surface.faces[i])] += dot(corner(0), cross(corner(1), corner(2))) / 6;
  }
  const double largest = volume.empty() ? 0 : *std::max_element(volume.begin(), volume.end());
  std::vector<uint32_t> outer, cavities; // roots of those that are dropped
  for (uint32_t v = 0; v < surface.vertices.size(); v++) {
    if (joined.root(v) != v) continue;
    if (std::abs(volume[v]) < min_share * largest)
      (volume[v] < 0 ? cavities : outer).push_back(v);
    else
      hull.components += volume[v] > 0;
  }
  hull.dropped = outer.size() + cavities.size();
  if (hull.dropped == 0) return;
  // Cavities first: a component that surrounds some is flooded with them.
  for (const std::vector<uint32_t> *roots : {&cavities, &outer})
    for (const uint32_t root : *roots) {
      const uint64_t edge = surface.crossings[root].edge;
      const size_t from = size_t(edge / 3), to = from + hull.grid.stride(int(edge % 3));
      const Bits bits(hull.occupancy);
      const bool inside = roots == &outer;
      for (const size_t end : {from, to})
        if (bits.get(end) == inside && bits.get(from) != bits.get(to)) {
          flood(hull.grid, bits, end);
          break;
        }
    }
  std::vector<bool> dropped(surface.vertices.size());
  for (const uint32_t root : outer) dropped[root] = true;
  for (const uint32_t root : cavities) dropped[root] = true;
  for (uint32_t v = 0; v < dropped.size(); v++) dropped[v] = dropped[joined.root(v)];
  compact(surface, dropped);
}

namespace {

class Smoothing {
public:
  Smoothing(Hull &of, const std::vector<Silhouette> &views, const Options &how)
      : hull(of), silhouettes(views), options(how), vertices(of.surface.vertices), start(vertices),
        known(vertices.size()) {
    find_neighbours();
    in_pieces([&](size_t v, std::vector<double> &pixels) { begin(v, pixels); });
  }

  // One step of Taubin's two: each vertex towards the mean of its neighbours, or away for a negative weight.
  void step(double weight) {
    const std::vector<Vec3> before = vertices;
    in_pieces([&](size_t v, std::vector<double> &pixels) {
      if (known[v].cameras.empty()) return;
      Vec3 mean;
      for (size_t n = first[v]; n < first[v + 1]; n++) mean += before[neighbours[n]];
      Vec3 move = (mean * (1.0 / double(first[v + 1] - first[v])) - before[v]) * weight;
      for (int attempt = 0; attempt < 3; attempt++, move = move * 0.5) {
        const Vec3 to = before[v] + move;
        if (length(to - start[v]) > 0.5 * hull.grid.cell || depth_below(options.floor, to) > 0) continue;
        if (!may_move(known[v], to, pixels)) continue;
        vertices[v] = to;
        return;
      }
    });
  }

private:
  struct Vertex {
    double allowed = 0;            // pixels from the outline that decides whether it is inside
    std::vector<uint32_t> cameras; // whose outlines are near; none: the vertex stays
    size_t inside = 0;             // number of the others that have it far inside
    size_t wanted = 0;             // of the distances in rising order, the one that decides
  };

  // How far a vertex may be from the outlines, and which cameras can decide that: those whose outlines are
  // farther away than the vertex can move keep their side.
  void begin(size_t v, std::vector<double> &pixels) {
    const double world[3] = {start[v].x, start[v].y, start[v].z};
    std::vector<Silhouette::View> views(silhouettes.size());
    pixels.clear();
    for (size_t camera = 0; camera < silhouettes.size(); camera++) {
      views[camera] = silhouettes[camera].view(world);
      if (views[camera].seen) pixels.push_back(views[camera].pixels);
    }
    const bool on_floor = std::abs(depth_below(options.floor, start[v])) < 1e-3 * hull.grid.cell;
    if (on_floor || pixels.size() < options.least_views) return;
    size_t wanted = pixels.size() > options.missed ? pixels.size() - 1 - options.missed : 0;
    wanted = std::max(wanted, options.least_views - 1);
    std::nth_element(pixels.begin(), pixels.begin() + std::ptrdiff_t(wanted), pixels.end());
    Vertex &vertex = known[v];
    vertex.allowed = std::max(options.tolerance, std::abs(pixels[wanted]));
    for (uint32_t camera = 0; camera < silhouettes.size(); camera++) {
      const Silhouette::View &view = views[camera];
      if (!view.seen) continue;
      const double reach = vertex.allowed + 2 * hull.grid.cell * view.per_metre + 1;
      if (std::abs(view.pixels) < reach)
        vertex.cameras.push_back(camera);
      else
        vertex.inside += view.pixels < 0;
    }
    vertex.wanted = wanted;
  }

  // Whether a vertex may move to a place.
  bool may_move(const Vertex &vertex, Vec3 to, std::vector<double> &pixels) const {
    const double world[3] = {to.x, to.y, to.z};
    pixels.clear();
    for (const uint32_t camera : vertex.cameras) {
      const Silhouette::View view = silhouettes[camera].view(world);
      if (!view.seen) return false;
      pixels.push_back(view.pixels);
    }
    if (vertex.wanted < vertex.inside || vertex.wanted >= vertex.inside + pixels.size()) return false;
    const auto at = pixels.begin() + std::ptrdiff_t(vertex.wanted - vertex.inside);
    std::nth_element(pixels.begin(), at, pixels.end());
    return std::abs(*at) <= vertex.allowed;
  }

  void find_neighbours() {
    const std::vector<uint32_t> &faces = hull.surface.faces;
    first.assign(vertices.size() + 1, 0);
    for (const uint32_t v : faces) first[v + 1]++;
    std::partial_sum(first.begin(), first.end(), first.begin());
    neighbours.resize(faces.size());
    std::vector<size_t> at(first.begin(), first.end() - 1);
    // Each edge has two faces that run along it in opposite directions: each vertex takes the next one of
    // each of its faces.
    for (size_t i = 0; i < faces.size(); i++) neighbours[at[faces[i]]++] = faces[i % 3 == 2 ? i - 2 : i + 1];
  }

  template <class Work> void in_pieces(const Work &work) {
    constexpr size_t together = 256;
    fvv::parallel(options.threads, (vertices.size() + together - 1) / together, [&](size_t piece) {
      std::vector<double> pixels;
      for (size_t v = piece * together; v < std::min(vertices.size(), (piece + 1) * together); v++)
        work(v, pixels);
    });
  }

  const Hull &hull;
  const std::vector<Silhouette> &silhouettes;
  const Options &options;
  std::vector<Vec3> &vertices;
  const std::vector<Vec3> start;
  std::vector<Vertex> known;
  std::vector<size_t> first; // of each vertex in neighbours, and one more
  std::vector<uint32_t> neighbours;
};

} // namespace

void smooth(Hull &hull, const std::vector<Silhouette> &silhouettes, const Options &options) {
  Smoothing smoothing(hull, silhouettes, options);
  for (size_t round = 0; round < options.smoothing; round++) {
    smoothing.step(0.5);
    smoothing.step(-0.53);
  }
}

} // namespace fvv::hull
