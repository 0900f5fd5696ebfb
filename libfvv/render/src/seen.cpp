// Bits for players: which faces and vertices a camera sees, where many are not asked for.
#include "face_places.h"
#include "fvv_render/normals.h"
#include "fvv_render/ray_visibility.h"

#include <bitset>

namespace fvv::render {

std::vector<uint8_t> seen_faces(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays,
                                const std::vector<uint8_t> &asked) {
  Viewer viewer(camera, mesh, rays);
  const FacePlaces places(viewer, mesh, asked);
  std::vector<uint8_t> seen(mesh.face_count);
  for (size_t i = 0; i < seen.size(); i++)
    seen[i] = std::bitset<16>(places.free[i]).count() > place_count / 2;
  return seen;
}

std::vector<uint8_t> seen_vertices(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays,
                                   const std::vector<uint8_t> &asked) {
  Viewer viewer(camera, mesh, rays);
  const std::vector<Vec3> normals = vertex_normals(mesh);
  std::vector<uint8_t> seen(mesh.vertex_count);
  for (uint32_t i = 0; i < mesh.vertex_count; i++)
    seen[i] = asked[i] && viewer.in_picture(i) && viewer.free(viewer.position(i) + normals[i] * vertex_lift);
  return seen;
}

} // namespace fvv::render
