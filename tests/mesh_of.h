// A mesh of positions and faces that somebody else holds, as tests make them by hand.
#pragma once

#include "fvv/mesh.h"

#include <vector>

// x y z and three vertices each; without texture coordinates and normals. Both are borrowed: never freed.
inline fvv_mesh mesh_of(std::vector<int32_t> &positions, std::vector<uint32_t> &faces) {
  fvv_mesh mesh = {};
  mesh.lattice = positions.data();
  mesh.faces = faces.data();
  mesh.vertex_count = uint32_t(positions.size() / 3);
  mesh.face_count = uint32_t(faces.size() / 3);
  return mesh;
}
