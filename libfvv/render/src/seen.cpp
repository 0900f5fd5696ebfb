// Bits for players: which faces and vertices a camera sees, where many are not asked for.
#include "fvv_render/normals.h"
#include "fvv_render/occlusion.h"
#include "fvv_render/ray_visibility.h"

namespace fvv::render {

namespace {

// Barycentric coordinates, in ninths, of the middles of the nine equal parts of a triangle.
constexpr int ninths[9][3] = {{7, 1, 1}, {1, 7, 1}, {1, 1, 7}, {4, 4, 1}, {4, 1, 4},
                              {1, 4, 4}, {5, 2, 2}, {2, 5, 2}, {2, 2, 5}};

class Viewer {
public:
  Viewer(const fvv_camera &chosen, const Mesh &seen, const RayCaster &caster)
      : camera(chosen), mesh(seen), rays(caster), shown(seen.vertex_count, unknown) {
    double at[3];
    fvv_camera_centre(&camera, at);
    centre = {at[0], at[1], at[2]};
  }

  Vec3 position(uint32_t vertex) const {
    const float *p = mesh.positions + size_t(3) * vertex;
    return {p[0], p[1], p[2]};
  }

  bool in_picture(Vec3 at) const {
    const double world[3] = {at.x, at.y, at.z};
    double pixel[2];
    return fvv_camera_project(&camera, world, pixel, nullptr) == 1 && pixel[0] >= 0 &&
           pixel[0] < double(camera.width) && pixel[1] >= 0 && pixel[1] < double(camera.height);
  }

  // A corner is shared by six faces or so: it is projected once.
  bool in_picture(uint32_t vertex) {
    if (shown[vertex] == unknown) shown[vertex] = in_picture(position(vertex));
    return shown[vertex] != 0;
  }

  // The middle of a face that is larger than the picture stands in it where no corner does.
  bool face_in_picture(const uint32_t *face) {
    return in_picture(face[0]) || in_picture(face[1]) || in_picture(face[2]) || in_picture(at(face, 3, 3, 3));
  }

  Vec3 at(const uint32_t *face, int a, int b, int c) const {
    return (position(face[0]) * a + position(face[1]) * b + position(face[2]) * c) * (1.0 / (a + b + c));
  }

  bool free(Vec3 place, uint32_t face) const { return !hidden_by_rays(centre, place, face, rays); }
  bool free(Vec3 place) const { return !rays.blocked(centre, place); }

  // Most of the nine places.
  bool mostly_free(const uint32_t *face, uint32_t number) const {
    int count = 0;
    for (const auto &[a, b, c] : ninths) count += free(at(face, a, b, c), number);
    return count > 4;
  }

private:
  static constexpr uint8_t unknown = 2;
  const fvv_camera &camera;
  const Mesh &mesh;
  const RayCaster &rays;
  Vec3 centre;
  std::vector<uint8_t> shown; // each vertex
};

} // namespace

std::vector<uint8_t> seen_faces(const fvv_camera &camera, const Mesh &mesh, const RayCaster &rays,
                                const std::vector<uint8_t> &asked) {
  Viewer viewer(camera, mesh, rays);
  std::vector<uint8_t> seen(mesh.face_count);
  std::vector<uint8_t> around(mesh.vertex_count); // bit 0: a hidden face uses the vertex; bit 1: a seen one
  std::vector<uint32_t> judged;
  for (uint32_t i = 0; i < mesh.face_count; i++) {
    const uint32_t *face = mesh.faces + size_t(3) * i;
    if (!asked[i] || !viewer.face_in_picture(face)) continue;
    seen[i] = viewer.free(viewer.at(face, 3, 3, 3), i);
    for (int k = 0; k < 3; k++) around[face[k]] |= uint8_t(1 << seen[i]);
    judged.push_back(i);
  }
  for (const uint32_t i : judged) {
    const uint32_t *face = mesh.faces + size_t(3) * i;
    if ((around[face[0]] | around[face[1]] | around[face[2]]) == 3) seen[i] = viewer.mostly_free(face, i);
  }
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
