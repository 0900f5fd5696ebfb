// What makes a triangle mesh a closed, consistently oriented manifold: counts of what is wrong with it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

struct Closedness {
  size_t edges = 0; // undirected
  size_t unmatched =
      0;              // directed edges that have not one face on either side, running in opposite directions
  size_t pinched = 0; // vertices around which the faces form no single fan
};

inline Closedness closedness(size_t vertices, const std::vector<uint32_t> &faces) {
  Closedness result;
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (size_t i = 0; i < faces.size(); i += 3)
    for (size_t c = 0; c < 3; c++) edges[{faces[i + c], faces[i + (c + 1) % 3]}]++;
  for (const auto &[edge, count] : edges)
    result.unmatched += count != 1 || edges.find({edge.second, edge.first}) == edges.end();
  result.edges = edges.size() / 2;
  if (result.unmatched) return result;
  std::vector<std::map<uint32_t, uint32_t>> around(vertices);
  for (size_t i = 0; i < faces.size(); i += 3)
    for (size_t c = 0; c < 3; c++) around[faces[i + c]][faces[i + (c + 1) % 3]] = faces[i + (c + 2) % 3];
  for (const auto &circle : around) {
    size_t length = 0;
    if (!circle.empty()) {
      uint32_t at = circle.begin()->first;
      do {
        at = circle.at(at);
        length++;
      } while (at != circle.begin()->first);
    }
    result.pinched += circle.empty() || length != circle.size();
  }
  return result;
}
