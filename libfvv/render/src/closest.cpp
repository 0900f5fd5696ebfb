#include "fvv_render/closest.h"

#include <algorithm>
#include <utility>

namespace fvv::render {

namespace {

// Height over longest edge, squared twice over, below which a triangle's normal says nothing.
constexpr double flat = 1e-20;

TriangleTree::Box box_of(const TriangleTree::Triangle &t) {
  const auto least = [](double a, double b, double c) { return std::min(std::min(a, b), c); };
  const auto most = [](double a, double b, double c) { return std::max(std::max(a, b), c); };
  return {{least(t[0].x, t[1].x, t[2].x), least(t[0].y, t[1].y, t[2].y), least(t[0].z, t[1].z, t[2].z)},
          {most(t[0].x, t[1].x, t[2].x), most(t[0].y, t[1].y, t[2].y), most(t[0].z, t[1].z, t[2].z)}};
}

// A triangle as seen from the point.
struct Candidate {
  Vec3 a, b, c;
  double squared = std::numeric_limits<double>::infinity();
  Vec3 offset = {};
  std::array<double, 3> weights = {};
  TriangleTree::Box box = box_of({a, b, c});

  void offer(Vec3 q, std::array<double, 3> w) {
    q = {std::clamp(q.x, box.low.x, box.high.x), std::clamp(q.y, box.low.y, box.high.y),
         std::clamp(q.z, box.low.z, box.high.z)};
    const double d = dot(q, q);
    if (!(d < squared)) return;
    squared = d;
    offset = q;
    weights = w;
  }

  // How far along an edge its nearest point lies, 0 to 1.
  static double along(Vec3 start, Vec3 edge) {
    const double size = dot(edge, edge), t = -dot(start, edge);
    return t <= 0 || !(size > 0) ? 0 : t >= size ? 1 : t / size;
  }

  void search() {
    const Vec3 ab = b - a, ca = a - c, bc = c - b, normal = cross(ca, ab);
    const double longest = std::max({dot(ab, ab), dot(ca, ca), dot(bc, bc)});
    // On which side of each edge the point lies: below 0 the triangle is on the other.
    double u = -1, v = -1, w = -1;
    if (dot(normal, normal) > flat * longest * longest) {
      u = dot(normal, cross(b, c)), v = dot(normal, cross(c, a)), w = dot(normal, cross(a, b));
      if (u > 0 && v > 0 && w > 0) {
        const double sum = u + v + w;
        u /= sum, v /= sum, w /= sum;
        return offer(a * u + b * v + c * w, {u, v, w});
      }
    }
    // What is nearest to a point beside a convex shape lies on an edge that has the point on its outer side.
    if (!(w > 0)) {
      const double t = along(a, ab);
      offer(a * (1 - t) + b * t, {1 - t, t, 0});
    }
    if (!(u > 0)) {
      const double t = along(b, bc);
      offer(b * (1 - t) + c * t, {0, 1 - t, t});
    }
    if (!(v > 0)) {
      const double t = along(c, ca);
      offer(c * (1 - t) + a * t, {t, 0, 1 - t});
    }
  }
};

// From a point, each coordinate four times, to four boxes, squared. No coordinate of closest_on_triangle()'s
// point comes nearer, because differences are rounded monotonically and it is clamped to the corners: no
// margin is needed. One operation a loop and a function of its own: so GCC computes several at once.
[[gnu::noinline]] void squared_distances(const double from[12], const double low[12], const double high[12],
                                         double squared[4]) {
  double d[12];
  for (int i = 0; i < 12; i++) d[i] = low[i] - from[i];
  for (int i = 0; i < 12; i++) {
    const double above = from[i] - high[i];
    d[i] = d[i] > above ? d[i] : above;
  }
  for (int i = 0; i < 12; i++) d[i] = d[i] > 0 ? d[i] : 0;
  for (int i = 0; i < 4; i++) squared[i] = d[i] * d[i] + d[4 + i] * d[4 + i] + d[8 + i] * d[8 + i];
}

// Nodes of which the boxes have not been looked into yet: three at each level and one more.
constexpr size_t stack_size = 3 * TriangleTree::stack_size + 1;

// In proportion to the surface.
double size_of(const TriangleTree::Box &box) {
  const Vec3 side = box.high - box.low;
  return side.x * side.y + side.y * side.z + side.z * side.x;
}

} // namespace

ClosestPoint closest_on_triangle(Vec3 from, const TriangleTree::Triangle &triangle) {
  Candidate candidate{triangle[0] - from, triangle[1] - from, triangle[2] - from};
  candidate.search();
  return {0, candidate.squared, from + candidate.offset, candidate.weights};
}

ClosestFinder::ClosestFinder(const std::vector<TriangleTree::Triangle> &source, const ClosestFinder *like) {
  if (like && refit(source, *like)) return;
  TriangleTree tree(source);
  nodes.reserve(tree.nodes.size() * 2 / 3 + 1); // leaves, which are half of them, and a third as many above
  if (!tree.nodes.empty()) gather(tree, 0);
  order = std::move(tree.order);
  triangles = std::move(tree.triangles);
  slots.assign(source.size(), UINT32_MAX);
  for (size_t i = 0; i < order.size(); i++) slots[order[i]] = uint32_t(i);
}

bool ClosestFinder::refit(const std::vector<TriangleTree::Triangle> &source, const ClosestFinder &like) {
  const auto finite = [](const TriangleTree::Triangle &t) {
    return std::all_of(t.begin(), t.end(),
                       [](Vec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); });
  };
  if (like.slots.size() != source.size() || like.order.size() != source.size()) return false;
  if (!std::all_of(source.begin(), source.end(), finite)) return false;
  nodes = like.nodes;
  order = like.order;
  slots = like.slots;
  triangles.reserve(order.size());
  for (const uint32_t face : order) triangles.push_back(source[face]);
  // A node stands in front of its children.
  for (size_t i = nodes.size(); i-- > 0;) {
    Node &node = nodes[i];
    const uint32_t count = std::exchange(node.count, 0);
    for (uint32_t k = 0; k < count; k++)
      fill(node, node.leaf ? box_of(triangles[node.child[k]]) : box_around(nodes[node.child[k]]),
           node.child[k]);
  }
  return true;
}

TriangleTree::Box ClosestFinder::box_around(const Node &node) {
  const auto least = [&](size_t axis) {
    return *std::min_element(&node.low[4 * axis], &node.low[4 * axis] + node.count);
  };
  const auto most = [&](size_t axis) {
    return *std::max_element(&node.high[4 * axis], &node.high[4 * axis] + node.count);
  };
  return {{least(0), least(1), least(2)}, {most(0), most(1), most(2)}};
}

void ClosestFinder::fill(Node &node, const TriangleTree::Box &box, uint32_t child) {
  for (int axis = 0; axis < 3; axis++) {
    node.low[4 * axis + int(node.count)] = axis_of(box.low, axis);
    node.high[4 * axis + int(node.count)] = axis_of(box.high, axis);
  }
  node.child[node.count++] = child;
}

// Makes one node of four out of several of two, the largest first, as Dammertz et al., "Shallow bounding
// volume hierarchies for fast SIMD ray tracing of incoherent rays" (2008), do. Answers its index.
uint32_t ClosestFinder::gather(const TriangleTree &tree, uint32_t top) {
  Node node = {};
  const TriangleTree::Node &root = tree.nodes[top];
  const uint32_t index = uint32_t(nodes.size());
  nodes.emplace_back();
  if ((node.leaf = root.count > 0)) {
    for (uint32_t i = root.first; i < root.first + root.count; i++) fill(node, box_of(tree.triangles[i]), i);
    nodes[index] = node;
    return index;
  }
  std::array<uint32_t, 4> parts = {top + 1, root.second};
  size_t count = 2;
  while (count < parts.size()) {
    size_t widest = count;
    for (size_t i = 0; i < count; i++) {
      const TriangleTree::Node &part = tree.nodes[parts[i]];
      if (!part.count && (widest == count || size_of(part.box) > size_of(tree.nodes[parts[widest]].box)))
        widest = i;
    }
    if (widest == count) break;
    const uint32_t part = parts[widest];
    parts[widest] = part + 1;
    parts[count++] = tree.nodes[part].second;
  }
  for (size_t i = 0; i < count; i++) fill(node, tree.nodes[parts[i]].box, gather(tree, parts[i]));
  nodes[index] = node;
  return index;
}

ClosestPoint ClosestFinder::nearest(Vec3 from, uint32_t guess, double enough) const {
  ClosestPoint best;
  if (nodes.empty() || !std::isfinite(dot(from, from))) return best;
  const auto look_at = [&](uint32_t slot) {
    const TriangleTree::Triangle &t = triangles[slot];
    Candidate candidate{t[0] - from, t[1] - from, t[2] - from};
    candidate.search();
    if (candidate.squared > best.squared) return;
    if (candidate.squared == best.squared && order[slot] >= best.face) return;
    best = {order[slot], candidate.squared, candidate.offset, candidate.weights};
  };
  if (guess < slots.size() && slots[guess] != UINT32_MAX) look_at(slots[guess]);
  struct Waiting {
    uint32_t node;
    double squared;
  };
  const Vec3 f = from;
  const double at[12] = {f.x, f.x, f.x, f.x, f.y, f.y, f.y, f.y, f.z, f.z, f.z, f.z};
  std::array<Waiting, stack_size> stack;
  size_t waiting = 0;
  stack[waiting++] = {0, 0};
  while (waiting && !(best.squared <= enough)) {
    const auto [index, squared] = stack[--waiting];
    if (squared > best.squared) continue;
    const Node &node = nodes[index];
    double distance[4];
    squared_distances(at, node.low, node.high, distance);
    if (node.leaf) {
      for (size_t i = 0; i < node.count; i++)
        if (!(distance[i] > best.squared)) look_at(node.child[i]);
      continue;
    }
    const size_t first = waiting;
    for (size_t i = 0; i < node.count; i++) {
      if (distance[i] > best.squared) continue;
      // The nearest is looked into first.
      size_t place = waiting++;
      for (; place > first && stack[place - 1].squared < distance[i]; place--)
        stack[place] = stack[place - 1];
      stack[place] = {node.child[i], distance[i]};
    }
  }
  best.point = from + best.point; // relative up to here
  return best;
}

} // namespace fvv::render
