// capture/mesh_seams.cpp: from texture coordinates and normals per corner, as modelling programs store them,
// to one of each per vertex, as graphics interfaces and fvv want them.
#include "capture/mesh_check.h"

#include <algorithm>
#include <array>
#include <map>

namespace fvv::capture {

void split_seams(Mesh &mesh, const std::vector<double> &texture, const std::vector<double> &normals,
                 const fvv_limits &limits, const std::string &name) {
  using Values = std::array<double, 5>; // u v, x y z; 0 where there are none
  const auto at_corner = [&](size_t i) {
    Values values = {};
    if (!texture.empty()) std::copy_n(&texture[i * 2], 2, &values[0]);
    if (!normals.empty()) std::copy_n(&normals[i * 3], 3, &values[2]);
    return values;
  };
  if (!texture.empty()) mesh.texture.assign(mesh.vertex_count() * 2, 0);
  if (!normals.empty()) mesh.normals.assign(mesh.vertex_count() * 3, 0);
  std::vector<Values> own(mesh.vertex_count());
  std::vector<bool> taken(mesh.vertex_count());
  // Few vertices lie on seams; a map keeps a file that is all seams from taking quadratic time.
  std::map<std::pair<uint32_t, Values>, uint32_t> copies;
  for (size_t i = 0; i < mesh.faces.size(); i++) {
    const uint32_t vertex = mesh.faces[i];
    const Values values = at_corner(i);
    if (!taken[vertex]) {
      taken[vertex] = true;
      own[vertex] = values;
      if (!texture.empty()) std::copy_n(&values[0], 2, &mesh.texture[vertex * size_t(2)]);
      if (!normals.empty()) std::copy_n(&values[2], 3, &mesh.normals[vertex * size_t(3)]);
    }
    if (own[vertex] == values) continue;
    const uint32_t next = static_cast<uint32_t>(mesh.vertex_count());
    const auto [copy, is_new] = copies.emplace(std::pair(vertex, values), next);
    mesh.faces[i] = copy->second;
    if (!is_new) continue;
    if (next >= limits.max_vertices)
      throw FileError(name + ": more than the allowed " + std::to_string(limits.max_vertices) +
                      " vertices, split where texture coordinates or normals differ");
    for (size_t axis = 0; axis < 3; axis++)
      mesh.positions.push_back(mesh.positions[vertex * size_t(3) + axis]);
    if (!texture.empty()) mesh.texture.insert(mesh.texture.end(), &values[0], &values[2]);
    if (!normals.empty()) mesh.normals.insert(mesh.normals.end(), &values[2], &values[2] + 3);
  }
}

} // namespace fvv::capture
