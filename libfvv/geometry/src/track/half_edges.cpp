#include "geometry/src/track/half_edges.h"

#include <algorithm>
#include <tuple>

namespace fvv::track {

HalfEdges::HalfEdges(const Triangles &of) : faces(of), others(3 * of.size(), none) {
  std::vector<std::tuple<uint32_t, uint32_t, uint32_t>> edges; // lower vertex, higher vertex, half-edge
  edges.reserve(others.size());
  for (uint32_t h = 0; h < others.size(); h++) {
    const uint32_t a = begin(h), b = begin(next(h));
    edges.emplace_back(std::min(a, b), std::max(a, b), h);
  }
  std::sort(edges.begin(), edges.end());
  const auto same = [&](size_t i, size_t j) {
    return j < edges.size() && std::get<0>(edges[i]) == std::get<0>(edges[j]) &&
           std::get<1>(edges[i]) == std::get<1>(edges[j]);
  };
  for (size_t i = 0, end; i < edges.size(); i = end) {
    for (end = i + 1; same(i, end);) end++;
    const uint32_t h = std::get<2>(edges[i]);
    if (end != i + 2) continue;
    const uint32_t g = std::get<2>(edges[i + 1]);
    if (begin(h) == begin(g)) continue;
    others[h] = g;
    others[g] = h;
  }
}

uint32_t HalfEdges::after(uint32_t half_edge, const std::vector<uint8_t> &in) const {
  // Around the end of it, over the faces that are in.
  uint32_t h = next(half_edge);
  while (!is_border(h, in)) {
    if (others[h] == none) return none;
    h = next(others[h]);
  }
  return h;
}

std::vector<Border> HalfEdges::borders(const std::vector<uint8_t> &in) const {
  std::vector<uint32_t> following(others.size(), none);
  std::vector<bool> begun(others.size()), done(others.size()); // by another
  std::vector<uint32_t> starts;
  for (uint32_t h = 0; h < others.size(); h++)
    if (is_border(h, in)) {
      following[h] = after(h, in);
      if (following[h] != none) begun[following[h]] = true;
      starts.push_back(h);
    }
  std::stable_partition(starts.begin(), starts.end(), [&](uint32_t h) { return !begun[h]; });
  std::vector<Border> out;
  for (const uint32_t start : starts) {
    if (done[start]) continue;
    Border border;
    border.closed = begun[start];
    border.face = start / 3;
    uint32_t h = start, last = start;
    for (; h != none && !done[h]; last = h, h = following[h]) {
      done[h] = true;
      border.vertices.push_back(begin(h));
    }
    if (!border.closed) border.vertices.push_back(begin(next(last)));
    out.push_back(std::move(border));
  }
  return out;
}

std::vector<uint32_t> HalfEdges::parts(const std::vector<uint8_t> &in) const {
  std::vector<uint32_t> out(in.size(), none), reached;
  uint32_t count = 0;
  for (uint32_t start = 0; start < in.size(); start++) {
    if (out[start] != none) continue;
    reached.assign(1, start);
    out[start] = count;
    for (size_t i = 0; i < reached.size(); i++)
      for (uint32_t k = 0; k < 3; k++) {
        const uint32_t other = others[3 * reached[i] + k];
        if (other == none || in[other / 3] != in[start] || out[other / 3] != none) continue;
        out[other / 3] = count;
        reached.push_back(other / 3);
      }
    count++;
  }
  return out;
}

void HalfEdges::fill(std::vector<uint8_t> &in, size_t least) const {
  const std::vector<uint32_t> part = parts(in);
  std::vector<size_t> sizes(in.size());
  for (const uint32_t p : part) sizes[p]++;
  for (size_t f = 0; f < in.size(); f++) in[f] |= uint8_t(sizes[part[f]] < least && !in[f]);
}

} // namespace fvv::track
