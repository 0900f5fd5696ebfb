#include "geometry/src/simplify.h"

#include <algorithm>
#include <array>
#include <meshoptimizer.h>
#include <utility>

namespace fvv::decimate {

Simplifier::Simplifier(const geometry::Mesh &mesh, const std::vector<uint32_t> &alike) {
  for (const uint32_t v : mesh.faces) faces.push_back(alike[v]);
  double low[3], high[3];
  std::copy_n(mesh.positions.data(), 3, low);
  std::copy_n(mesh.positions.data(), 3, high);
  for (size_t i = 0; i < mesh.positions.size(); i++) {
    low[i % 3] = std::min(low[i % 3], mesh.positions[i]);
    high[i % 3] = std::max(high[i % 3], mesh.positions[i]);
  }
  for (size_t i = 0; i < mesh.positions.size(); i++)
    positions.push_back(float(mesh.positions[i] - (low[i % 3] / 2 + high[i % 3] / 2)));
  scale = meshopt_simplifyScale(positions.data(), positions.size() / 3, 3 * sizeof(float));
}

namespace {

// A face by its corners in rising order, which way round it runs, and its place in the list.
struct Wound {
  std::array<uint32_t, 3> corners;
  bool forth;
  size_t at;

  bool operator<(const Wound &other) const {
    return corners != other.corners ? corners < other.corners : at < other.at;
  }
};

std::vector<Wound> sorted(const std::vector<uint32_t> &faces) {
  std::vector<Wound> out;
  for (size_t i = 0; i < faces.size(); i += 3) {
    std::array<uint32_t, 3> c = {faces[i], faces[i + 1], faces[i + 2]};
    std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
    const bool forth = c[1] < c[2];
    std::sort(c.begin(), c.end());
    out.push_back({c, forth, i});
  }
  std::sort(out.begin(), out.end());
  return out;
}

} // namespace

// Where the simplifier brought two sheets together there are faces back to back. Both are dropped where the
// surface goes on at each of their corners; one is kept at a tip or of a plate, of which nothing would be
// left otherwise. Of two alike one is kept, and of those that the source has already, as the canonicaliser
// does.
std::vector<uint32_t> Simplifier::without_folds(std::vector<uint32_t> simplified) const {
  const std::vector<Wound> all = sorted(simplified);
  std::vector<std::pair<size_t, size_t>> pairs; // of all
  for (size_t i = 0; i + 1 < all.size(); i++)
    if (all[i].corners == all[i + 1].corners) pairs.emplace_back(i, i + 1);
  if (pairs.empty()) return simplified;
  std::vector<uint8_t> in_pair(all.size()), goes_on(positions.size() / 3);
  for (const auto &[a, b] : pairs) in_pair[a] = in_pair[b] = 1;
  for (size_t i = 0; i < all.size(); i++)
    for (const uint32_t v : all[i].corners) goes_on[v] |= !in_pair[i];
  const std::vector<Wound> before = sorted(faces);
  const auto less = [](const Wound &a, const Wound &b) { return a.corners < b.corners; };
  std::vector<uint8_t> dropped(simplified.size() / 3);
  for (const auto &[a, b] : pairs) {
    const auto same = std::equal_range(before.begin(), before.end(), all[a], less);
    const std::array<uint32_t, 3> &c = all[a].corners;
    const bool fold = all[a].forth != all[b].forth && !dropped[all[a].at / 3] &&
                      same.second - same.first < 2 && goes_on[c[0]] && goes_on[c[1]] && goes_on[c[2]];
    dropped[all[b].at / 3] = 1;
    if (fold) dropped[all[a].at / 3] = 1;
  }
  std::vector<uint32_t> out;
  for (size_t i = 0; i < simplified.size(); i++)
    if (!dropped[i / 3]) out.push_back(simplified[i]);
  return out;
}

std::vector<uint32_t> Simplifier::simplify(const SimplifyTarget &target,
                                           const std::vector<bool> &locked) const {
  std::vector<uint32_t> loose, kept;
  for (size_t i = 0; i < faces.size(); i++)
    (!locked.empty() && locked[i / 3] ? kept : loose).push_back(faces[i]);
  if (loose.empty() || !(scale > 0)) return faces;
  const size_t count = 3 * target.faces > kept.size() ? 3 * target.faces - kept.size() : 0;
  const float error = target.faces ? 1 : float(std::min(target.error / double(scale), 1.0));
  std::vector<uint32_t> out(loose.size());
  // Next to locked faces the others have an open border, which does not move either.
  out.resize(meshopt_simplify(out.data(), loose.data(), loose.size(), positions.data(), positions.size() / 3,
                              3 * sizeof(float), std::min(count, loose.size()), error,
                              meshopt_SimplifyLockBorder, nullptr));
  out.insert(out.end(), kept.begin(), kept.end());
  return without_folds(std::move(out));
}

} // namespace fvv::decimate
