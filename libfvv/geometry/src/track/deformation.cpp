#include "geometry/src/track/deformation.h"

#include <algorithm>
#include <cmath>

namespace fvv::track {

namespace {

// Of the 6 unknowns of a node, turn and move, what they change of a point: weight * (-[arm]x, 1), where arm
// is from the node to the point.
struct Part {
  uint32_t node;
  Vec3 arm;
  double weight;
};

// Point to plane, with a little point to point: without it a surface slides along itself.
constexpr double to_point = 0.03;

Mat3 turned(Vec3 by) { // Rodrigues
  const double angle = length(by);
  const Vec3 axis = angle > 0 ? by * (1 / angle) : Vec3{1, 0, 0};
  const double s = std::sin(angle), c = std::cos(angle);
  const auto column = [&](Vec3 v) { return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1 - c)); };
  return {column({1, 0, 0}), column({0, 1, 0}), column({0, 0, 1})};
}

// Gram and Schmidt: near to a rotation there is little to choose.
Mat3 orthogonal(const Mat3 &m) {
  const Vec3 x = normalised(m.x), y = normalised(m.y - x * dot(x, m.y));
  return {x, y, cross(x, y)};
}

struct Block {
  double at[3][6]; // derivative of a point by a node's unknowns
};

Block block_of(const Part &p) {
  const Vec3 a = p.arm * p.weight;
  const double w = p.weight;
  return {{{0, a.z, -a.y, w, 0, 0}, {-a.z, 0, a.x, 0, w, 0}, {a.y, -a.x, 0, 0, 0, w}}};
}

// Adds residual and derivative of one vector equation. metric: symmetric, by which its square is taken.
void add_equation(SparseSystem &system, const Part *parts, size_t count, Vec3 residual, const Mat3 &metric) {
  constexpr size_t most = 8;
  Block blocks[most], weighted[most];
  const Vec3 pull = metric * residual;
  const double m[3][3] = {{metric.x.x, metric.y.x, metric.z.x},
                          {metric.x.y, metric.y.y, metric.z.y},
                          {metric.x.z, metric.y.z, metric.z.z}};
  std::vector<double> &right = system.right();
  for (size_t i = 0; i < count; i++) {
    blocks[i] = block_of(parts[i]);
    double *to = &right[6 * size_t(parts[i].node)];
    for (size_t c = 0; c < 6; c++) {
      const double *b = &blocks[i].at[0][c];
      to[c] -= b[0] * pull.x + b[6] * pull.y + b[12] * pull.z;
      for (size_t r = 0; r < 3; r++) weighted[i].at[r][c] = m[r][0] * b[0] + m[r][1] * b[6] + m[r][2] * b[12];
    }
  }
  for (size_t i = 0; i < count; i++)
    for (size_t j = 0; j < count; j++) {
      if (parts[i].node < parts[j].node) continue; // the lower half
      double *to = system.at(parts[i].node, parts[j].node);
      for (size_t c = 0; c < 6; c++)
        for (size_t r = 0; r < 6; r++)
          to[6 * c + r] += blocks[i].at[0][r] * weighted[j].at[0][c] +
                           blocks[i].at[1][r] * weighted[j].at[1][c] +
                           blocks[i].at[2][r] * weighted[j].at[2][c];
    }
}

} // namespace

Deformation::Deformation(const NodeGraph &of, std::vector<Vec3> resting)
    : graph(of), rest(std::move(resting)) {}

std::vector<std::pair<uint32_t, uint32_t>> Deformation::pairs(const NodeGraph &graph) {
  std::vector<std::pair<uint32_t, uint32_t>> out = graph.edges;
  for (const NodeGraph::Influences &of : graph.of_vertex)
    for (size_t i = 0; i < NodeGraph::most; i++)
      for (size_t j = 0; j < i; j++)
        if (of.weight[i] > 0 && of.weight[j] > 0)
          out.emplace_back(std::min(of.node[i], of.node[j]), std::max(of.node[i], of.node[j]));
  return out;
}

Pose Deformation::still() const {
  Pose pose;
  pose.rotations.resize(graph.vertices.size());
  for (const uint32_t v : graph.vertices) pose.places.push_back(rest[v]);
  return pose;
}

Vec3 Deformation::apply(const Pose &pose, uint32_t vertex) const {
  const NodeGraph::Influences &of = graph.of_vertex[vertex];
  Vec3 out;
  for (size_t k = 0; k < NodeGraph::most; k++)
    if (of.weight[k] > 0)
      out +=
          (pose.rotations[of.node[k]] * (rest[vertex] - rest_of_node(of.node[k])) + pose.places[of.node[k]]) *
          of.weight[k];
  return out;
}

std::vector<Vec3> Deformation::apply(const Pose &pose) const {
  std::vector<Vec3> out(rest.size());
  for (uint32_t v = 0; v < out.size(); v++) out[v] = apply(pose, v);
  return out;
}

Mat3 Deformation::rotation(const Pose &pose, uint32_t vertex) const {
  const NodeGraph::Influences &of = graph.of_vertex[vertex];
  Mat3 sum = {{}, {}, {}};
  for (size_t k = 0; k < NodeGraph::most; k++) {
    const Mat3 &r = pose.rotations[of.node[k]];
    sum.x += r.x * of.weight[k];
    sum.y += r.y * of.weight[k];
    sum.z += r.z * of.weight[k];
  }
  return orthogonal(sum);
}

void Deformation::add(SparseSystem &system, const Correspondence &c, double weight, const Pose &pose) const {
  // The nodes of three vertices are mostly the same few.
  std::array<Part, 3 * NodeGraph::most> all;
  size_t count = 0;
  for (size_t corner = 0; corner < 3; corner++) {
    if (!(c.barycentric[corner] > 0)) continue;
    const NodeGraph::Influences &of = graph.of_vertex[c.vertices[corner]];
    for (size_t k = 0; k < NodeGraph::most; k++) {
      const double part = of.weight[k] * c.barycentric[corner];
      if (!(part > 0)) continue;
      size_t at = 0;
      while (at < count && all[at].node != of.node[k]) at++;
      if (at == count) all[count++] = {of.node[k], {}, 0};
      all[at].weight += part;
    }
  }
  const auto more = [](const Part &a, const Part &b) {
    return a.weight != b.weight ? a.weight > b.weight : a.node < b.node;
  };
  std::sort(all.begin(), all.begin() + std::ptrdiff_t(count), more);
  // Pairs of nodes of different vertices are not all in the pattern; those of the heaviest vertex are.
  size_t heaviest = 0;
  for (size_t k = 1; k < 3; k++)
    if (c.barycentric[k] > c.barycentric[heaviest]) heaviest = k;
  const NodeGraph::Influences &of = graph.of_vertex[c.vertices[heaviest]];
  std::array<Part, NodeGraph::most> parts;
  size_t used = 0;
  double sum = 0;
  for (size_t i = 0; i < count; i++)
    for (size_t k = 0; k < NodeGraph::most; k++)
      if (of.weight[k] > 0 && of.node[k] == all[i].node && used < parts.size()) {
        parts[used] = {all[i].node, c.point - pose.places[all[i].node], all[i].weight};
        sum += parts[used++].weight;
      }
  for (size_t i = 0; i < used; i++) parts[i].weight /= sum;
  const Vec3 n = c.normal * weight;
  const double p = weight * to_point;
  const Mat3 metric = {n * c.normal.x + Vec3{p, 0, 0}, n * c.normal.y + Vec3{0, p, 0},
                       n * c.normal.z + Vec3{0, 0, p}};
  add_equation(system, parts.data(), used, c.point - c.target, metric);
}

void Deformation::add_edge(SparseSystem &system, uint32_t from, uint32_t to, double weight,
                           const Pose &pose) const {
  const Vec3 arm = pose.rotations[from] * (rest_of_node(to) - rest_of_node(from));
  // The place of the other node as this one has it, less where that is.
  const Part parts[2] = {{from, arm, 1}, {to, {}, -1}};
  add_equation(system, parts, 2, pose.places[from] + arm - pose.places[to],
               {{weight, 0, 0}, {0, weight, 0}, {0, 0, weight}});
}

bool Deformation::step(SparseSystem &system, const std::vector<Correspondence> &correspondences,
                       double rigidity, Pose &pose) const {
  constexpr double damping = 1e-4;
  system.clear();
  const size_t count = graph.vertices.size();
  double sum = 0, edge = 0;
  for (const Correspondence &c : correspondences) sum += c.weight;
  if (!(sum > 0)) return false;
  for (const Correspondence &c : correspondences)
    if (c.weight > 0) add(system, c, c.weight * double(count) / sum, pose);
  const double each = graph.edges.empty() ? 0 : rigidity * double(count) / double(graph.edges.size());
  for (const auto &[from, to] : graph.edges) {
    add_edge(system, from, to, each, pose);
    edge += length(rest_of_node(to) - rest_of_node(from)) / double(graph.edges.size());
  }
  for (uint32_t k = 0; k < count; k++)
    for (size_t c = 0; c < 6; c++)
      system.at(k, k)[7 * c] += damping * (c < 3 ? std::max(edge * edge, 1e-300) : 1);
  const std::vector<double> found = system.solve();
  if (found.empty() || !std::all_of(found.begin(), found.end(), [](double x) { return std::isfinite(x); }))
    return false;
  for (size_t k = 0; k < count; k++) {
    const double *x = &found[6 * k];
    pose.rotations[k] = orthogonal(turned({x[0], x[1], x[2]}) * pose.rotations[k]);
    pose.places[k] += {x[3], x[4], x[5]};
  }
  return true;
}

} // namespace fvv::track
