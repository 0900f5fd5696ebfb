// Visibility of faces, of vertices and of places, by casting rays.
#include "fvv_render/ray_visibility.h"

#include "fvv_render/normals.h"
#include "fvv_render/occlusion.h"
#include "fvv_render/scene_lengths.h"
#include "viewer.h"

namespace fvv::render {

namespace {

Vec3 position_of(const Mesh &mesh, uint32_t vertex) {
  const float *p = mesh.positions + size_t(3) * vertex;
  return {p[0], p[1], p[2]};
}

// Twice the area long.
Vec3 normal(const Mesh &mesh, const uint32_t *face) {
  const Vec3 a = position_of(mesh, face[0]);
  return cross(position_of(mesh, face[1]) - a, position_of(mesh, face[2]) - a);
}

bool projects_into(const fvv_camera &camera, Vec3 at) {
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

Viewer::Viewer(const fvv_camera &chosen, const Mesh &seen, const RayCaster &caster)
    : camera(chosen), mesh(seen), centre(centre_of(chosen)), rays(centre, seen, caster),
      shown(seen.vertex_count, unknown) {}

Vec3 Viewer::position(uint32_t vertex) const {
  return position_of(mesh, vertex);
}

Vec3 Viewer::at(const uint32_t *face, int a, int b, int c) const {
  return (position(face[0]) * a + position(face[1]) * b + position(face[2]) * c) * (1.0 / (a + b + c));
}

bool Viewer::in_picture(Vec3 at) const {
  return projects_into(camera, at);
}

// A corner is used by six faces or so.
bool Viewer::in_picture(uint32_t vertex) {
  if (shown[vertex] == unknown) shown[vertex] = in_picture(position(vertex));
  return shown[vertex] != 0;
}

// The middle of a face that is larger than the picture is in it where no corner is.
bool Viewer::face_in_picture(const uint32_t *face) {
  return in_picture(face[0]) || in_picture(face[1]) || in_picture(face[2]) || in_picture(at(face, 3, 3, 3));
}

bool Viewer::free(Vec3 place, uint32_t face) const {
  return !rays.blocked(before(centre, place), face);
}

std::vector<uint8_t> visible_faces(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays) {
  const Vec3 centre = centre_of(camera);
  std::vector<uint8_t> seen(mesh.face_count);
  for (size_t i = 0; i < mesh.face_count; i++) {
    const uint32_t *face = mesh.faces + 3 * i;
    const Vec3 middle =
        (position_of(mesh, face[0]) + position_of(mesh, face[1]) + position_of(mesh, face[2])) * (1.0 / 3);
    seen[i] = dot(normal(mesh, face), centre - middle) > 0 && projects_into(camera, middle) &&
              !rays.blocked(centre, middle, uint32_t(i));
  }
  return seen;
}

std::vector<uint8_t> visible_vertices(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays) {
  const Vec3 centre = centre_of(camera);
  const std::vector<Vec3> normals = vertex_normals(mesh);
  const double lift = vertex_lift(mesh);
  std::vector<uint8_t> seen(mesh.vertex_count);
  for (size_t i = 0; i < mesh.vertex_count; i++) {
    const Vec3 lifted = position_of(mesh, uint32_t(i)) + normals[i] * lift;
    seen[i] = dot(normals[i], centre - lifted) > 0 && projects_into(camera, lifted) &&
              !rays.blocked(centre, lifted);
  }
  return seen;
}

} // namespace fvv::render
