#include "fvvdemux/decoded_mesh.h"

#include <cmath>

namespace fvv::demux {

capture::Lattice lattice_of(const double origin[3], double step) {
  return {{origin[0], origin[1], origin[2]}, step};
}

capture::Mesh in_metres(const fvv_mesh &mesh, const capture::Lattice &lattice) {
  capture::Mesh out;
  out.positions.resize(size_t(mesh.vertex_count) * 3);
  for (size_t v = 0; v < mesh.vertex_count; v++)
    fvv_lattice_to_metres(lattice.origin, lattice.step, mesh.positions + 3 * v, &out.positions[3 * v]);
  const double step = mesh.texture ? std::ldexp(1.0, -int(mesh.texture_bits)) : 0;
  for (size_t i = 0; mesh.texture && i < size_t(mesh.vertex_count) * 2; i++)
    out.texture.push_back(mesh.texture[i] * step);
  if (mesh.normals) {
    std::vector<float> normals(out.positions.size());
    fvv_normals_to_floats(mesh.normal_bits, mesh.normals, mesh.vertex_count, normals.data());
    out.normals.assign(normals.begin(), normals.end());
  }
  out.faces.assign(mesh.faces, mesh.faces + size_t(mesh.face_count) * 3);
  return out;
}

} // namespace fvv::demux
