#include "fvv_render/ray_visibility.h"

#include "fvv_render/normals.h"

namespace fvv::render {

namespace {

Vec3 position(const Mesh &mesh, uint32_t vertex) {
  const float *p = mesh.positions + size_t(3) * vertex;
  return {p[0], p[1], p[2]};
}

// Twice the area long.
Vec3 normal(const Mesh &mesh, const uint32_t *face) {
  const Vec3 a = position(mesh, face[0]);
  return cross(position(mesh, face[1]) - a, position(mesh, face[2]) - a);
}

bool in_picture(const fvv_camera &camera, Vec3 at) {
  const double world[3] = {at.x, at.y, at.z};
  double pixel[2];
  return fvv_camera_project(&camera, world, pixel, nullptr) == 1 && pixel[0] >= 0 &&
         pixel[0] < double(camera.width) && pixel[1] >= 0 && pixel[1] < double(camera.height);
}

Vec3 centre_of(const fvv_camera &camera) {
  double centre[3];
  fvv_camera_centre(&camera, centre);
  return {centre[0], centre[1], centre[2]};
}

} // namespace

std::vector<uint8_t> visible_faces(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays) {
  const Vec3 centre = centre_of(camera);
  std::vector<uint8_t> seen(mesh.face_count);
  for (size_t i = 0; i < mesh.face_count; i++) {
    const uint32_t *face = mesh.faces + 3 * i;
    const Vec3 middle =
        (position(mesh, face[0]) + position(mesh, face[1]) + position(mesh, face[2])) * (1.0 / 3);
    seen[i] = dot(normal(mesh, face), centre - middle) > 0 && in_picture(camera, middle) &&
              !rays.blocked(centre, middle, uint32_t(i));
  }
  return seen;
}

std::vector<uint8_t> visible_vertices(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays) {
  const Vec3 centre = centre_of(camera);
  const std::vector<Vec3> normals = vertex_normals(mesh);
  std::vector<uint8_t> seen(mesh.vertex_count);
  for (size_t i = 0; i < mesh.vertex_count; i++) {
    const Vec3 lifted = position(mesh, uint32_t(i)) + normals[i] * vertex_lift;
    seen[i] =
        dot(normals[i], centre - lifted) > 0 && in_picture(camera, lifted) && !rays.blocked(centre, lifted);
  }
  return seen;
}

} // namespace fvv::render
