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

bool inside_out(const Mesh &mesh) {
  Vec3 middle;
  for (uint32_t i = 0; i < mesh.vertex_count; i++)
    middle += position(mesh, i) * (1.0 / double(mesh.vertex_count));
  double volume = 0, size = 0;
  for (size_t i = 0; i < 3 * mesh.face_count; i += 3) {
    const Vec3 a = position(mesh, mesh.faces[i]) - middle, b = position(mesh, mesh.faces[i + 1]) - middle,
               c = position(mesh, mesh.faces[i + 2]) - middle;
    const double part = dot(a, cross(b, c));
    volume += part;
    size += std::abs(part);
  }
  return volume < -1e-3 * size;
}

} // namespace fvv::render
