#include "geometry/src/fit.h"
#include "fvv_geometry/pieces.h"

#include <algorithm>

namespace fvv::decimate {

namespace {

using render::Vec3;

// Every third vertex of the source: several for each vertex that is left, at a third of the time.
constexpr size_t stride = 3;

std::vector<bool> on_border(const geometry::Mesh &mesh, const std::vector<uint32_t> &place) {
  std::vector<uint64_t> edges;
  for (size_t i = 0; i < mesh.faces.size(); i++) {
    const uint32_t a = place[mesh.faces[i]], b = place[mesh.faces[i % 3 == 2 ? i - 2 : i + 1]];
    edges.push_back(uint64_t(std::min(a, b)) << 32 | std::max(a, b));
  }
  std::sort(edges.begin(), edges.end());
  std::vector<bool> border(mesh.vertex_count());
  for (size_t i = 0; i < edges.size(); i++) {
    if ((i && edges[i] == edges[i - 1]) || (i + 1 < edges.size() && edges[i] == edges[i + 1])) continue;
    border[edges[i] >> 32] = border[uint32_t(edges[i])] = true;
  }
  return border;
}

} // namespace

void fit(geometry::Mesh &mesh, const compare::Faces &surface, const geometry::Mesh &source,
         const std::vector<bool> &fixed, double furthest) {
  const std::vector<uint32_t> place = first_alike(mesh, false);
  std::vector<Vec3> sums(mesh.vertex_count());
  std::vector<double> weights(mesh.vertex_count());
  render::ClosestPoint hit; // the search begins with that of the vertex before
  for (size_t v = 0; v < source.vertex_count(); v += stride) {
    const double *p = &source.positions[3 * v];
    hit = surface.nearest({p[0], p[1], p[2]}, hit.face);
    for (size_t k = 0; k < 3; k++) {
      const uint32_t corner = place[mesh.faces[3 * size_t(hit.face) + k]];
      sums[corner] += (Vec3{p[0], p[1], p[2]} - hit.point) * hit.barycentric[k];
      weights[corner] += hit.barycentric[k];
    }
  }
  std::vector<bool> stays = on_border(mesh, place);
  for (size_t v = 0; v < fixed.size(); v++)
    if (fixed[v]) stays[place[v]] = true;
  for (size_t v = 0; v < mesh.vertex_count(); v++) {
    const uint32_t corner = place[v];
    if (!(weights[corner] > 0) || stays[corner]) continue;
    Vec3 move = sums[corner] * (1 / weights[corner]);
    const double size = length(move);
    if (size > furthest) move = move * (furthest / size);
    mesh.positions[3 * v] += move.x;
    mesh.positions[3 * v + 1] += move.y;
    mesh.positions[3 * v + 2] += move.z;
  }
}

} // namespace fvv::decimate
