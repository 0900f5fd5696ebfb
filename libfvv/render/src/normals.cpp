#include "fvv_render/normals.h"

namespace fvv::render {

namespace {

Vec3 position(const Mesh &mesh, uint32_t vertex) {
  const float *p = mesh.positions + size_t(3) * vertex;
  return {p[0], p[1], p[2]};
}

} // namespace

std::vector<Vec3> vertex_normals(const Mesh &mesh) {
  std::vector<Vec3> normals(mesh.vertex_count);
  for (size_t i = 0; i < mesh.face_count; i++) {
    const uint32_t *face = mesh.faces + 3 * i;
    const Vec3 a = position(mesh, face[0]);
    const Vec3 weighted = cross(position(mesh, face[1]) - a, position(mesh, face[2]) - a);
    for (size_t c = 0; c < 3; c++) normals[face[c]] += weighted;
  }
  for (Vec3 &normal : normals) normal = normalised(normal);
  return normals;
}

} // namespace fvv::render
