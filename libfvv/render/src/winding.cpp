#include "fvv_render/winding.h"

namespace fvv::render {

bool inside_out(const Mesh &mesh) {
  const auto at = [&](size_t vertex) {
    const float *p = mesh.positions + 3 * vertex;
    return Vec3{p[0], p[1], p[2]};
  };
  Vec3 middle;
  for (size_t i = 0; i < mesh.vertex_count; i++) middle += at(i) * (1.0 / double(mesh.vertex_count));
  double volume = 0, size = 0;
  for (size_t i = 0; i < 3 * mesh.face_count; i += 3) {
    const Vec3 a = at(mesh.faces[i]) - middle, b = at(mesh.faces[i + 1]) - middle,
               c = at(mesh.faces[i + 2]) - middle;
    const double part = dot(a, cross(b, c));
    volume += part;
    size += std::abs(part);
  }
  return volume < -1e-3 * size;
}

} // namespace fvv::render
