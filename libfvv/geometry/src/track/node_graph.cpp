#include "geometry/src/track/node_graph.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace fvv::track {

namespace {

using Reached = std::pair<double, uint32_t>; // distance, vertex or node

// Distances along edges.
class Walker {
public:
  explicit Walker(const RunMesh &of) : mesh(of), distance(of.points.size(), INFINITY) {}

  // All vertices within a distance, the nearest first.
  std::vector<Reached> walk(uint32_t from, double furthest) {
    std::vector<Reached> done;
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> open;
    std::vector<uint32_t> touched = {from};
    distance[from] = 0;
    for (open.push({0, from}); !open.empty();) {
      const auto [so_far, v] = open.top();
      open.pop();
      if (so_far > distance[v]) continue;
      done.push_back({so_far, v});
      for (size_t i = mesh.first[v]; i < mesh.first[v + 1]; i++) {
        const uint32_t w = mesh.neighbours[i];
        const double there = so_far + length(mesh.points[w] - mesh.points[v]);
        if (there > furthest || !(there < distance[w])) continue;
        if (std::isinf(distance[w])) touched.push_back(w);
        distance[w] = there;
        open.push({there, w});
      }
    }
    for (const uint32_t v : touched) distance[v] = INFINITY;
    return done;
  }

private:
  const RunMesh &mesh;
  std::vector<double> distance;
};

// The nearest nodes have the weights (1 - distance / that of the next one)^2.
NodeGraph::Influences influences_of(std::vector<Reached> near) {
  NodeGraph::Influences out;
  std::sort(near.begin(), near.end());
  const size_t count = std::min(near.size(), NodeGraph::most);
  if (!count) return out;
  const double limit = near.size() > count ? near[count].first : 1.5 * near[count - 1].first;
  double sum = 0;
  for (size_t k = 0; k < count; k++) {
    const double fraction = limit > 0 ? 1 - near[k].first / limit : 1;
    out.node[k] = near[k].second;
    sum += out.weight[k] = std::max(fraction * fraction, 1e-6);
  }
  for (double &weight : out.weight) weight /= sum;
  return out;
}

} // namespace

NodeGraph::NodeGraph(const RunMesh &mesh, double spacing) {
  constexpr double range = 3; // spacings, within which nodes are looked for
  constexpr size_t most_edges = 8;
  const size_t count = mesh.points.size();
  const double largest = *std::max_element(mesh.piece_areas.begin(), mesh.piece_areas.end());
  const double least = std::min(largest, spacing * spacing);
  const auto has_nodes = [&](uint32_t v) { return mesh.piece_areas[mesh.piece[v]] >= least; };
  Walker walker(mesh);
  std::vector<bool> covered(count);
  for (uint32_t v = 0; v < count; v++) {
    if (covered[v] || !has_nodes(v)) continue;
    vertices.push_back(v);
    for (const Reached &reached : walker.walk(v, spacing)) covered[reached.second] = true;
  }
  std::vector<std::vector<Reached>> near(count);
  std::vector<uint32_t> node_at(count, UINT32_MAX);
  for (uint32_t k = 0; k < vertices.size(); k++) node_at[vertices[k]] = k;
  for (uint32_t k = 0; k < vertices.size(); k++) {
    size_t found = 0;
    for (const auto &[distance, v] : walker.walk(vertices[k], range * spacing)) {
      near[v].push_back({distance, k});
      if (node_at[v] == UINT32_MAX || node_at[v] == k || found++ >= most_edges) continue;
      edges.emplace_back(k, node_at[v]);
      edges.emplace_back(node_at[v], k);
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<Vec3> places;
  for (const uint32_t v : vertices) places.push_back(mesh.points[v]);
  for (uint32_t v = 0; v < count; v++) {
    if (near[v].empty()) // of a small piece
      for (uint32_t k = 0; k < vertices.size(); k++)
        near[v].push_back({length(places[k] - mesh.points[v]), k});
    of_vertex.push_back(influences_of(std::move(near[v])));
  }
}

} // namespace fvv::track
