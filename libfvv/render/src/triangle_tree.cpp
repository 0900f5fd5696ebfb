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
    const auto &[a, b, c] = source[i];
    if (!finite(a) || !finite(b) || !finite(c)) continue;
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

// Orders the entries so that those in front of the index that is answered go into the first child. centres:
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
    // An empty bin divides nothing that its neighbour does not.
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

} // namespace fvv::render
