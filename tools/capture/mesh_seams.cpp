// capture/mesh_seams.cpp: from texture coordinates per corner, as modelling programs store them, to one pair
// per vertex, as graphics interfaces and fvv want them.
#include "capture/mesh_check.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace fvv::capture {

void split_seams(Mesh &mesh, const std::vector<double> &corners, const fvv_limits &limits,
                 const std::string &name) {
  mesh.texture.assign(mesh.vertex_count() * 2, 0);
  std::vector<bool> taken(mesh.vertex_count());
  // Few vertices lie on seams; a map keeps a file that is all seams from taking quadratic time.
  std::map<std::tuple<uint32_t, double, double>, uint32_t> copies;
  for (size_t i = 0; i < mesh.faces.size(); i++) {
    const uint32_t vertex = mesh.faces[i];
    const double *pair = &corners[i * 2];
    double *own = &mesh.texture[vertex * size_t(2)];
    if (!taken[vertex]) {
      taken[vertex] = true;
      std::copy_n(pair, 2, own);
    }
    if (std::equal(own, own + 2, pair)) continue;
    const uint32_t next = static_cast<uint32_t>(mesh.vertex_count());
    const auto [copy, is_new] = copies.emplace(std::tuple(vertex, pair[0], pair[1]), next);
    mesh.faces[i] = copy->second;
    if (!is_new) continue;
    if (next >= limits.max_vertices)
      throw FileError(name + ": more than the allowed " + std::to_string(limits.max_vertices) +
                      " vertices, split where texture coordinates differ");
    for (size_t axis = 0; axis < 3; axis++)
      mesh.positions.push_back(mesh.positions[vertex * size_t(3) + axis]);
    mesh.texture.insert(mesh.texture.end(), pair, pair + 2);
  }
}

} // namespace fvv::capture
