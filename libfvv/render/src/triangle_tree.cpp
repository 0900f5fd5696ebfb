// Building the hierarchy.
#include "fvv_render/triangle_tree.h"

#include <algorithm>
#include <limits>

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

constexpr Vec3 lowest{-infinity, -infinity, -infinity}, highest{infinity, infinity, infinity};

} // namespace

// Without corners, or to put entries in order would be to move these about.
struct TriangleTree::Entry {
  Box box;
  uint32_t face;
  Vec3 centre() const { return box.low + box.high; } // twice
};

TriangleTree::TriangleTree(const std::vector<Triangle> &source) {
  std::vector<Entry> entries;
  entries.reserve(source.size());
  for (size_t i = 0; i < source.size(); i++) {
    const auto &[a, b, c] = source[i];
    if (!finite(a) || !finite(b) || !finite(c)) continue;
    entries.push_back({{lower(a, lower(b, c)), higher(a, higher(b, c))}, uint32_t(i)});
  }
  nodes.reserve(entries.size());
  if (!entries.empty()) build(entries, 0, entries.size(), 0);
  order.reserve(entries.size());
  triangles.reserve(entries.size());
  for (const Entry &entry : entries) {
    order.push_back(entry.face);
    triangles.push_back(source[entry.face]);
  }
}

uint32_t TriangleTree::build(std::vector<Entry> &entries, size_t first, size_t end, int depth) {
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
size_t TriangleTree::split(std::vector<Entry> &entries, size_t first, size_t end, int depth) {
  Vec3 low = highest, high = lowest;
  for (size_t i = first; i < end; i++) {
    low = lower(low, entries[i].centre());
    high = higher(high, entries[i].centre());
  }
  const Vec3 extent = high - low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const double start = axis_of(low, axis), scale = double(bin_count) / axis_of(extent, axis);
  const auto begin = entries.begin() + std::ptrdiff_t(first), stop = entries.begin() + std::ptrdiff_t(end);
  if (depth < heuristic_depth && std::isfinite(scale)) {
    const auto bin = [&](const Entry &entry) {
      return std::min(bin_count - 1, size_t((axis_of(entry.centre(), axis) - start) * scale));
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
    const double u = axis_of(a.centre(), axis), v = axis_of(b.centre(), axis);
    return u < v || (u == v && a.face < b.face);
  });
  return size_t(half - entries.begin());
}

} // namespace fvv::render
