#include "geometry/src/simplify.h"

#include <algorithm>
#include <meshoptimizer.h>

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
  return out;
}

} // namespace fvv::decimate
