// Building the hierarchy, and sending rays through it.
#include "fvv_render/ray.h"

#include <algorithm>
#include <limits>

namespace fvv::render {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr size_t leaf_size = 4;
constexpr size_t bin_count = 16;
// Below this depth faces are halved by count, so that no input makes the tree deeper than the stack: 2^32
// faces need 32 levels more.
constexpr int heuristic_depth = 24;
constexpr size_t stack_size = heuristic_depth + 34;
// 1 + 2 gamma(3) of Ize: what three roundings can take from the far end of an interval.
constexpr double margin = 1 + 8 * std::numeric_limits<double>::epsilon();

double at(Vec3 v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

bool finite(Vec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

Vec3 lower(Vec3 a, Vec3 b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Vec3 higher(Vec3 a, Vec3 b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

constexpr Vec3 lowest{-infinity, -infinity, -infinity}, highest{infinity, infinity, infinity};

} // namespace

struct RayCaster::Entry {
  uint32_t face;
  std::array<Vec3, 3> corner;
  Box box;
  Vec3 centre; // of the box, twice
};

RayCaster::RayCaster(const Mesh &mesh) {
  std::vector<Entry> entries;
  entries.reserve(mesh.face_count);
  for (size_t i = 0; i < mesh.face_count; i++) {
    Entry entry;
    entry.face = uint32_t(i);
    for (size_t c = 0; c < 3; c++) {
      const float *p = mesh.positions + size_t(3) * mesh.faces[3 * i + c];
      entry.corner[c] = {p[0], p[1], p[2]};
    }
    const auto &[a, b, c] = entry.corner;
    if (!finite(a) || !finite(b) || !finite(c)) continue;
    entry.box = {lower(a, lower(b, c)), higher(a, higher(b, c))};
    entry.centre = entry.box.low + entry.box.high;
    entries.push_back(entry);
  }
  if (!entries.empty()) build(entries, 0, entries.size(), 0);
  order.reserve(entries.size());
  triangles.reserve(entries.size());
  for (const Entry &entry : entries) {
    order.push_back(entry.face);
    triangles.push_back(entry.corner);
  }
}

uint32_t RayCaster::build(std::vector<Entry> &entries, size_t first, size_t end, int depth) {
  const uint32_t index = uint32_t(nodes.size());
  nodes.emplace_back();
  Box box{highest, lowest};
  for (size_t i = first; i < end; i++)
    box = {lower(box.low, entries[i].box.low), higher(box.high, entries[i].box.high)};
  nodes[index].box = box;
  if (end - first <= leaf_size) {
    nodes[index].first = uint32_t(first);
    nodes[index].count = uint32_t(end - first);
    return index;
  }
  const size_t middle = split(entries, first, end, depth);
  build(entries, first, middle, depth + 1);
  const uint32_t second = build(entries, middle, end, depth + 1);
  nodes[index].second = second;
  return index;
}

// Orders the entries so that those in front of the index that is answered go into the first child.
size_t RayCaster::split(std::vector<Entry> &entries, size_t first, size_t end, int depth) {
  Vec3 low = highest, high = lowest;
  for (size_t i = first; i < end; i++) {
    low = lower(low, entries[i].centre);
    high = higher(high, entries[i].centre);
  }
  const Vec3 extent = high - low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const double start = at(low, axis), scale = double(bin_count) / at(extent, axis);
  const auto begin = entries.begin() + std::ptrdiff_t(first), stop = entries.begin() + std::ptrdiff_t(end);
  if (depth < heuristic_depth && std::isfinite(scale)) {
    const auto bin = [&](const Entry &entry) {
      return std::min(bin_count - 1, size_t((at(entry.centre, axis) - start) * scale));
    };
    struct Bin {
      Box box{highest, lowest};
      size_t count = 0;
      void add(const Box &other, size_t n) {
        box = {lower(box.low, other.low), higher(box.high, other.high)};
        count += n;
      }
      double cost() const {
        const Vec3 side = box.high - box.low;
        return count ? (side.x * side.y + side.y * side.z + side.z * side.x) * double(count) : 0;
      }
    };
    std::array<Bin, bin_count> bins;
    for (auto entry = begin; entry != stop; ++entry) bins[bin(*entry)].add(entry->box, 1);
    std::array<double, bin_count> behind = {};
    Bin sum;
    for (size_t i = bin_count - 1; i > 0; i--) {
      sum.add(bins[i].box, bins[i].count);
      behind[i] = sum.cost();
    }
    sum = {};
    double least = infinity;
    size_t best = 0;
    for (size_t i = 1; i < bin_count; i++) {
      sum.add(bins[i - 1].box, bins[i - 1].count);
      if (const double cost = sum.cost() + behind[i]; cost < least && sum.count && sum.count < end - first) {
        least = cost;
        best = i;
      }
    }
    if (best)
      return size_t(std::partition(begin, stop, [&](const Entry &entry) { return bin(entry) < best; }) -
                    entries.begin());
  }
  const auto half = begin + (stop - begin) / 2;
  std::nth_element(begin, half, stop, [&](const Entry &a, const Entry &b) {
    const double u = at(a.centre, axis), v = at(b.centre, axis);
    return u < v || (u == v && a.face < b.face);
  });
  return size_t(half - entries.begin());
}

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
    for (int axis = 0; axis < 3; axis++) backwards[axis] = std::signbit(at(direction, axis));
    scale = 1 / at(direction, z);
    shear_x = at(direction, x) * scale;
    shear_y = at(direction, y) * scale;
  }

  bool meets(const Box &box, double least, double most) const {
    for (int axis = 0; axis < 3; axis++) {
      const double from = at(origin, axis), by = at(inverse, axis);
      const double low = (at(box.low, axis) - from) * by, high = (at(box.high, axis) - from) * by;
      const double enter = backwards[axis] ? high : low, leave = (backwards[axis] ? low : high) * margin;
      // NaN (a ray within the plane of a side) keeps what there is.
      if (enter > least) least = enter;
      if (leave < most) most = leave;
    }
    return least <= most;
  }

  // Distance and weights, or false.
  bool meets(const std::array<Vec3, 3> &triangle, RayHit &hit) const {
    double px[3], py[3], pz[3];
    for (size_t i = 0; i < 3; i++) {
      const Vec3 p = triangle[i] - origin;
      pz[i] = at(p, z);
      px[i] = at(p, x) - shear_x * pz[i];
      py[i] = at(p, y) - shear_y * pz[i];
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
  if (nodes.empty() || !std::isfinite(ray.scale) || !finite(ray.origin)) return best;
  std::array<uint32_t, stack_size> stack;
  size_t waiting = 0;
  stack[waiting++] = 0;
  while (waiting) {
    const uint32_t index = stack[--waiting];
    const Node &node = nodes[index];
    if (!ray.meets(node.box, least, most)) continue;
    if (!node.count) {
      stack[waiting++] = node.second;
      stack[waiting++] = index + 1;
      continue;
    }
    for (size_t i = node.first; i < size_t(node.first) + node.count; i++) {
      RayHit hit;
      if (order[i] == except || !ray.meets(triangles[i], hit)) continue;
      if (!(hit.distance > least && hit.distance <= most)) continue;
      // most is the caller's until a face is found, then that face's distance.
      if (best.face == no_face ? hit.distance == most : hit.distance == most && order[i] > best.face)
        continue;
      hit.face = order[i];
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

} // namespace fvv::render
