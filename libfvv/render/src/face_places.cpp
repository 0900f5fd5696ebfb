#include "face_places.h"

#include "fvv_render/occlusion.h"

namespace fvv::render {

Viewer::Viewer(const fvv_camera &chosen, const Mesh &seen, const RayCaster &caster)
    : camera(chosen), mesh(seen), rays(caster), shown(seen.vertex_count, unknown) {
  double at[3];
  fvv_camera_centre(&camera, at);
  centre = {at[0], at[1], at[2]};
}

Vec3 Viewer::position(uint32_t vertex) const {
  const float *p = mesh.positions + size_t(3) * vertex;
  return {p[0], p[1], p[2]};
}

Vec3 Viewer::at(const uint32_t *face, int a, int b, int c) const {
  return (position(face[0]) * a + position(face[1]) * b + position(face[2]) * c) * (1.0 / (a + b + c));
}

bool Viewer::in_picture(Vec3 at) const {
  const double world[3] = {at.x, at.y, at.z};
  double pixel[2];
  return fvv_camera_project(&camera, world, pixel, nullptr) == 1 && pixel[0] >= 0 &&
         pixel[0] < double(camera.width) && pixel[1] >= 0 && pixel[1] < double(camera.height);
}

// A corner is shared by six faces or so.
bool Viewer::in_picture(uint32_t vertex) {
  if (shown[vertex] == unknown) shown[vertex] = in_picture(position(vertex));
  return shown[vertex] != 0;
}

// The middle of a face that is larger than the picture stands in it where no corner does.
bool Viewer::face_in_picture(const uint32_t *face) {
  return in_picture(face[0]) || in_picture(face[1]) || in_picture(face[2]) || in_picture(at(face, 3, 3, 3));
}

bool Viewer::free(Vec3 place, uint32_t face) const {
  return !hidden_by_rays(centre, place, face, rays);
}

FacePlaces::FacePlaces(Viewer &viewer, const Mesh &mesh, const std::vector<uint8_t> &asked)
    : judged(mesh.face_count), free(mesh.face_count), mixed(mesh.vertex_count) {
  std::vector<uint8_t> around(mesh.vertex_count); // bit 0: a hidden face uses the vertex; bit 1: a seen one
  for (uint32_t i = 0; i < mesh.face_count; i++) {
    const uint32_t *face = mesh.faces + size_t(3) * i;
    if (!asked[i] || !viewer.face_in_picture(face)) continue;
    judged[i] = 1;
    const bool seen = viewer.free(viewer.at(face, 3, 3, 3), i);
    free[i] = seen ? all_places : 0;
    for (int k = 0; k < 3; k++) around[face[k]] |= uint8_t(1 << seen);
  }
  for (size_t v = 0; v < around.size(); v++) mixed[v] = around[v] == 3;
  for (uint32_t i = 0; i < mesh.face_count; i++) {
    const uint32_t *face = mesh.faces + size_t(3) * i;
    if (!judged[i] || !touches_mixed(face)) continue;
    free[i] = 0;
    for (int p = 0; p < place_count; p++) {
      const auto &[a, b, c] = ninths[p];
      free[i] |= uint16_t(viewer.free(viewer.at(face, a, b, c), i) << p);
    }
  }
}

} // namespace fvv::render
