// The hierarchy of triangles: building it, searching for nearest points, casting rays.
#include "fvv_render/triangle_tree.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace fvv::render {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr size_t leaf_size = 4;
constexpr size_t bin_count = 16;
// Below this depth faces are halved by count, so that no input makes the tree deeper than the stack: 2^32
// faces need 32 levels more.
constexpr int heuristic_depth = TriangleTree::stack_size - 34;

bool finite(Vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

Vec3 lower(Vec3 a, Vec3 b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Vec3 higher(Vec3 a, Vec3 b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

bool finite(const TriangleTree::Triangle &t) {
  return finite(t[0]) && finite(t[1]) && finite(t[2]);
}

constexpr Vec3 lowest{-infinity, -infinity, -infinity}, highest{infinity, infinity, infinity};

} // namespace

// Without corners, so that sorting entries moves less data.
struct TriangleTree::Entry {
  Box box;
  uint32_t face;
  uint32_t bin = 0;                                  // in the split that is being made
  Vec3 centre() const { return box.low + box.high; } // twice
};

// Of some entries: around all of them, and around their centres.
struct TriangleTree::Extent {
  Box box{highest, lowest}, centres{highest, lowest};
  void add(const Entry &entry) {
    const Vec3 centre = entry.centre();
    add({entry.box, {centre, centre}});
  }
  void add(const Extent &other) {
    box = {lower(box.low, other.box.low), higher(box.high, other.box.high)};
    centres = {lower(centres.low, other.centres.low), higher(centres.high, other.centres.high)};
  }
};

TriangleTree::TriangleTree(const std::vector<Triangle> &source) {
  std::vector<Entry> entries;
  entries.reserve(source.size());
  Extent extent;
  for (size_t i = 0; i < source.size(); i++) {
    if (!finite(source[i])) continue;
    const auto &[a, b, c] = source[i];
    entries.push_back({{lower(a, lower(b, c)), higher(a, higher(b, c))}, uint32_t(i)});
    extent.add(entries.back());
  }
  nodes.reserve(entries.size());
  if (!entries.empty()) build(entries, 0, entries.size(), 0, extent);
  order.reserve(entries.size());
  triangles.reserve(entries.size());
  for (const Entry &entry : entries) {
    order.push_back(entry.face);
    triangles.push_back(source[entry.face]);
  }
}

uint32_t TriangleTree::build(std::vector<Entry> &entries, size_t first, size_t end, int depth,
                             const Extent &extent) {
  const uint32_t index = uint32_t(nodes.size());
  nodes.emplace_back();
  nodes[index].box = extent.box;
  if (end - first <= leaf_size) {
    nodes[index].first = uint32_t(first);
    nodes[index].count = uint32_t(end - first);
    return index;
  }
  std::array<Extent, 2> parts;
  const size_t middle = split(entries, first, end, depth, extent.centres, parts);
  build(entries, first, middle, depth + 1, parts[0]);
  const uint32_t second = build(entries, middle, end, depth + 1, parts[1]);
  nodes[index].second = second;
  return index;
}

// Orders the entries so that those before the returned index go into the first child. centres:
// of the entries; parts: of the children.
size_t TriangleTree::split(std::vector<Entry> &entries, size_t first, size_t end, int depth,
                           const Box &centres, std::array<Extent, 2> &parts) {
  const Vec3 extent = centres.high - centres.low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const double start = axis_of(centres.low, axis), scale = double(bin_count) / axis_of(extent, axis);
  const auto begin = entries.begin() + std::ptrdiff_t(first), stop = entries.begin() + std::ptrdiff_t(end);
  if (depth < heuristic_depth && std::isfinite(scale)) {
    struct Bin {
      Extent extent;
      size_t count = 0;
      void add(const Bin &other) {
        extent.add(other.extent);
        count += other.count;
      }
      double cost() const {
        const Vec3 side = extent.box.high - extent.box.low;
        return count ? (side.x * side.y + side.y * side.z + side.z * side.x) * double(count) : 0;
      }
    };
    std::array<Bin, bin_count> bins;
    for (auto entry = begin; entry != stop; ++entry) {
      entry->bin =
          std::min(uint32_t(bin_count - 1), uint32_t((axis_of(entry->centre(), axis) - start) * scale));
      bins[entry->bin].extent.add(*entry);
      bins[entry->bin].count++;
    }
    // An empty bin divides as its neighbour does.
    std::array<double, bin_count> behind = {};
    Bin sum;
    for (size_t i = bin_count - 1; i > 0; i--) {
      if (bins[i].count) sum.add(bins[i]);
      behind[i] = bins[i].count || i + 1 == bin_count ? sum.cost() : behind[i + 1];
    }
    sum = {};
    double least = infinity;
    size_t best = 0;
    for (size_t i = 1; i < bin_count; i++) {
      if (!bins[i - 1].count) continue;
      sum.add(bins[i - 1]);
      if (const double cost = sum.cost() + behind[i]; cost < least && sum.count < end - first) {
        least = cost;
        best = i;
      }
    }
    if (best) {
      for (size_t i = 0; i < bin_count; i++)
        if (bins[i].count) parts[i < best ? 0 : 1].add(bins[i].extent);
      return size_t(std::partition(begin, stop, [&](const Entry &entry) { return entry.bin < best; }) -
                    entries.begin());
    }
  }
  const auto half = begin + (stop - begin) / 2;
  std::nth_element(begin, half, stop, [&](const Entry &a, const Entry &b) {
    const double u = axis_of(a.centre(), axis), v = axis_of(b.centre(), axis);
    return u < v || (u == v && a.face < b.face);
  });
  for (auto entry = begin; entry != stop; ++entry) parts[entry < half ? 0 : 1].add(*entry);
  return size_t(half - entries.begin());
}

namespace {

// Height over longest edge, squared twice, below which a triangle's normal is meaningless.
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

// Nodes that have not been searched yet: three at each level and one more.
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
  if (like.slots.size() != source.size() || like.order.size() != source.size()) return false;
  if (!std::all_of(source.begin(), source.end(), [](const auto &t) { return finite(t); })) return false;
  nodes = like.nodes;
  order = like.order;
  slots = like.slots;
  triangles.reserve(order.size());
  for (const uint32_t face : order) triangles.push_back(source[face]);
  // A node is before its children.
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
// volume hierarchies for fast SIMD ray tracing of incoherent rays" (2008), do. Returns its index.
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
      // The nearest is searched first.
      size_t place = waiting++;
      for (; place > first && stack[place - 1].squared < distance[i]; place--)
        stack[place] = stack[place - 1];
      stack[place] = {node.child[i], distance[i]};
    }
  }
  best.point = from + best.point; // relative up to here
  return best;
}

namespace {

// 1 + 2 gamma(3) of Ize: what three roundings can take from the far end of an interval.
constexpr double margin = 1 + 8 * std::numeric_limits<double>::epsilon();

std::vector<TriangleTree::Triangle> triangles_of(const Mesh &mesh) {
  std::vector<TriangleTree::Triangle> out(mesh.face_count);
  for (size_t i = 0; i < 3 * mesh.face_count; i++) {
    const float *p = mesh.positions + size_t(3) * mesh.faces[i];
    out[i / 3][i % 3] = {p[0], p[1], p[2]};
  }
  return out;
}

} // namespace

RayCaster::RayCaster(const Mesh &mesh) : tree(triangles_of(mesh)) {}

struct RayCaster::Ray {
  Vec3 origin, inverse;
  bool backwards[3];
  int x, y, z; // z: the axis along which the ray is longest
  double shear_x, shear_y, scale;

  Ray(Vec3 from, Vec3 direction) : origin(from) {
    inverse = {1 / direction.x, 1 / direction.y, 1 / direction.z};
    const double size[3] = {std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)};
    z = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
    x = (z + 1) % 3;
    y = (x + 1) % 3;
    for (int axis = 0; axis < 3; axis++) backwards[axis] = std::signbit(axis_of(direction, axis));
    scale = 1 / axis_of(direction, z);
    shear_x = axis_of(direction, x) * scale;
    shear_y = axis_of(direction, y) * scale;
  }

  bool meets(const TriangleTree::Box &box, double least, double most) const {
    for (int axis = 0; axis < 3; axis++) {
      const double from = axis_of(origin, axis), by = axis_of(inverse, axis);
      const double low = (axis_of(box.low, axis) - from) * by, high = (axis_of(box.high, axis) - from) * by;
      const double enter = backwards[axis] ? high : low, leave = (backwards[axis] ? low : high) * margin;
      // NaN (a ray within the plane of a side) does not change the interval.
      if (enter > least) least = enter;
      if (leave < most) most = leave;
    }
    return least <= most;
  }

  // Distance and weights, or false.
  bool meets(const TriangleTree::Triangle &triangle, RayHit &hit) const {
    double px[3], py[3], pz[3];
    for (size_t i = 0; i < 3; i++) {
      const Vec3 p = triangle[i] - origin;
      pz[i] = axis_of(p, z);
      px[i] = axis_of(p, x) - shear_x * pz[i];
      py[i] = axis_of(p, y) - shear_y * pz[i];
    }
    // The faces on both sides of an edge get the same products with opposite signs. 0 is inside.
    const double u = px[2] * py[1] - py[2] * px[1], v = px[0] * py[2] - py[0] * px[2],
                 w = px[1] * py[0] - py[1] * px[0];
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const double sum = u + v + w;
    if (!(sum != 0)) return false;
    hit.distance = (u * pz[0] + v * pz[1] + w * pz[2]) * scale / sum;
    hit.barycentric = {u / sum, v / sum, w / sum};
    return true;
  }
};

template <bool any> RayHit RayCaster::cast(const Ray &ray, double least, double most, uint32_t except) const {
  RayHit best;
  if (tree.nodes.empty() || !std::isfinite(ray.scale) || !finite(ray.origin)) return best;
  std::array<uint32_t, TriangleTree::stack_size> stack;
  size_t waiting = 0;
  stack[waiting++] = 0;
  while (waiting) {
    const uint32_t index = stack[--waiting];
    const TriangleTree::Node &node = tree.nodes[index];
    if (!ray.meets(node.box, least, most)) continue;
    if (!node.count) {
      stack[waiting++] = node.second;
      stack[waiting++] = index + 1;
      continue;
    }
    for (size_t i = node.first; i < size_t(node.first) + node.count; i++) {
      RayHit hit;
      if (tree.order[i] == except || !ray.meets(tree.triangles[i], hit)) continue;
      if (!(hit.distance > least && hit.distance <= most)) continue;
      // most is the caller's until a face is found, then that face's distance.
      if (best.face == no_face ? hit.distance == most : hit.distance == most && tree.order[i] > best.face)
        continue;
      hit.face = tree.order[i];
      best = hit;
      most = hit.distance;
      if (any) return best;
    }
  }
  return best;
}

RayHit RayCaster::nearest(Vec3 origin, Vec3 direction, double least, double most, uint32_t except) const {
  return cast<false>(Ray(origin, direction), least, most, except);
}

bool RayCaster::blocked(Vec3 from, Vec3 to, uint32_t except) const {
  return cast<true>(Ray(from, to - from), 0, 1, except).face != no_face;
}

namespace {

// Of a face's place in the plane, far more than rounding can be off.
constexpr double fan_margin = 1e-6;
constexpr double fan_widest = 20; // x / z: an angle of 87 degrees
constexpr uint32_t most_fan_cells = 1024;
constexpr double most_cells_of_face = 16; // on average

} // namespace

RayFan::RayFan(Vec3 from, const Mesh &mesh, const RayCaster &caster) : centre(from), rays(caster) {
  sort(mesh);
}

Vec3 RayFan::project(Vec3 point) const {
  const Vec3 way = point - centre;
  const double z = dot(way, along);
  return {dot(way, across) / z, dot(way, down) / z, z};
}

void RayFan::sort(const Mesh &mesh) {
  if (!mesh.vertex_count || !mesh.face_count) return;
  Vec3 least = highest, most = lowest;
  const auto position = [&](size_t v) {
    return Vec3{mesh.positions[3 * v], mesh.positions[3 * v + 1], mesh.positions[3 * v + 2]};
  };
  for (size_t v = 0; v < mesh.vertex_count; v++) {
    least = lower(least, position(v));
    most = higher(most, position(v));
  }
  along = normalised((least + most) * 0.5 - centre);
  if (!finite(along)) return;
  across = normalised(cross(along, std::abs(along.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{1, 0, 0}));
  down = cross(along, across);
  std::vector<Vec3> seen;
  seen.reserve(mesh.vertex_count);
  double high[2] = {-infinity, -infinity};
  low[0] = low[1] = infinity;
  for (size_t v = 0; v < mesh.vertex_count; v++) {
    seen.push_back(project(position(v)));
    const Vec3 at = seen.back();
    if (!(at.z > 0 && std::abs(at.x) < fan_widest && std::abs(at.y) < fan_widest)) return;
    low[0] = std::min(low[0], at.x);
    low[1] = std::min(low[1], at.y);
    high[0] = std::max(high[0], at.x);
    high[1] = std::max(high[1], at.y);
  }
  std::vector<Entry> all;
  all.reserve(mesh.face_count);
  double sides = 0;
  for (size_t slot = 0; slot < rays.tree.order.size(); slot++) {
    const uint32_t *face = mesh.faces + size_t(3) * rays.tree.order[slot];
    const Vec3 a = seen[face[0]], b = seen[face[1]], c = seen[face[2]];
    const Vec3 from = lower(a, lower(b, c)), to = higher(a, higher(b, c));
    const double room = fan_margin * fan_widest;
    all.push_back({float(from.x - room), float(to.x + room), float(from.y - room), float(to.y + room),
                   float(from.z * (1 - fan_margin)), uint32_t(slot)});
    sides += (to.x - from.x) + (to.y - from.y);
  }
  // Cells about as large as faces; larger ones, where a few faces are so large that they would be in most.
  const double extent = std::max(high[0] - low[0], high[1] - low[1]);
  const auto entries_at = [&](double side) {
    double sum = 0;
    for (const Entry &entry : all)
      sum += (double(entry.right - entry.left) / side + 1) * (double(entry.bottom - entry.top) / side + 1);
    return sum;
  };
  double side = std::max(sides / (2 * double(mesh.face_count)), extent / most_fan_cells);
  while (side > 0 && side < extent && entries_at(side) > most_cells_of_face * double(mesh.face_count))
    side *= 2;
  scale = side > 0 ? 1 / side : 0;
  const auto count = [&](int axis) {
    return std::clamp(uint32_t((high[axis] - low[axis]) * scale) + 1, 1u, most_fan_cells);
  };
  columns = count(0);
  rows = count(1);
  const auto each_cell = [&](const Entry &entry, const auto &body) {
    const uint32_t left = column(double(entry.left)), right = column(double(entry.right));
    const uint32_t bottom = row(double(entry.bottom));
    for (uint32_t y = row(double(entry.top)); y <= bottom; y++)
      for (uint32_t x = left; x <= right; x++) body(size_t(y) * columns + x);
  };
  first.resize(size_t(columns) * rows + 1);
  for (const Entry &entry : all) each_cell(entry, [&](size_t at) { first[at + 1]++; });
  for (size_t i = 1; i < first.size(); i++) first[i] += first[i - 1];
  entries.resize(first.back());
  std::vector<uint32_t> next(first.begin(), first.end() - 1);
  for (const Entry &entry : all) each_cell(entry, [&](size_t at) { entries[next[at]++] = entry; });
}

bool RayFan::blocked(Vec3 to, uint32_t except) const {
  if (first.empty()) return rays.blocked(centre, to, except);
  const RayCaster::Ray ray(centre, to - centre);
  if (!std::isfinite(ray.scale)) return false;
  const Vec3 at = project(to);
  // Beside all faces, unless it is not a number or behind the place.
  if (!(at.z > 0)) return rays.blocked(centre, to, except);
  const float x = float(at.x), y = float(at.y);
  const float z = float(at.z * (1 + fan_margin));
  const size_t index = size_t(row(at.y)) * columns + column(at.x);
  for (uint32_t i = first[index]; i < first[index + 1]; i++) {
    const Entry &entry = entries[i];
    if (x < entry.left || x > entry.right || y < entry.top || y > entry.bottom || entry.nearest > z) continue;
    RayHit hit;
    if (rays.tree.order[entry.slot] != except && ray.meets(rays.tree.triangles[entry.slot], hit) &&
        hit.distance > 0 && hit.distance < 1)
      return true;
  }
  return false;
}

} // namespace fvv::render
