// What targets of meshes share.
#pragma once

#include "../fuzz.h"

#include "fvv/mesh.h"

namespace fuzz {

// A decoded mesh, or none.
struct Mesh {
  fvv_mesh mesh = {};
  bool there = false;
  Mesh() = default;
  explicit Mesh(const Bytes &payload) {
    const fvv_status status =
        fvv_mesh_decode(payload.data(), payload.size(), nullptr, nullptr, &mesh, nullptr);
    expect_status(status);
    there = status == FVV_OK;
    expect(there || (!mesh.lattice && !mesh.faces), "on error the mesh is empty");
  }
  Mesh(const Mesh &) = delete;
  ~Mesh() {
    if (there) fvv_mesh_free(&mesh);
  }
};

inline void expect_valid(const fvv_mesh &mesh) {
  for (size_t i = 0; i < 3 * size_t(mesh.face_count); i++)
    expect(mesh.faces[i] < mesh.vertex_count, "faces index vertices");
  for (size_t i = 0; i < 3 * size_t(mesh.vertex_count); i++)
    expect(mesh.lattice[i] >= -FVV_LATTICE_MAX && mesh.lattice[i] <= FVV_LATTICE_MAX,
           "vertices are on the lattice");
  for (size_t i = 0; mesh.texture && i < 2 * size_t(mesh.vertex_count); i++)
    expect(mesh.texture[i] <= 1u << mesh.texture_bits, "texture indices are in their range");
  for (size_t i = 0; mesh.normals && i < 2 * size_t(mesh.vertex_count); i++)
    expect(mesh.normals[i] <= (1u << mesh.normal_bits) - 2, "normal indices are in their range");
}

inline bool equal(const fvv_mesh &a, const fvv_mesh &b) {
  if (a.vertex_count != b.vertex_count || a.face_count != b.face_count || !a.texture != !b.texture ||
      !a.normals != !b.normals)
    return false;
  const size_t vertices = a.vertex_count, faces = a.face_count;
  return !std::memcmp(a.lattice, b.lattice, 12 * vertices) && !std::memcmp(a.faces, b.faces, 12 * faces) &&
         (!a.texture || !std::memcmp(a.texture, b.texture, 8 * vertices)) &&
         (!a.normals || !std::memcmp(a.normals, b.normals, 8 * vertices));
}

} // namespace fuzz
