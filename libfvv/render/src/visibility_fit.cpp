#include "fvv_render/visibility_fit.h"

#include "fvv_render/normals.h"
#include "viewer.h"
#include "visibility_weights.h"

namespace fvv::render {

VisibilityFit::VisibilityFit(const Mesh &seen, const RayCaster &caster, const FitSettings &chosen)
    : mesh(seen), rays(caster), settings(chosen), normals(vertex_normals(seen)), area(seen.face_count),
      first(seen.vertex_count + 1), around(3 * seen.face_count) {
  double sum = 0;
  for (size_t f = 0; f < mesh.face_count; f++) {
    Vec3 corner[3];
    for (size_t k = 0; k < 3; k++) {
      const float *p = mesh.positions + size_t(3) * mesh.faces[3 * f + k];
      corner[k] = {p[0], p[1], p[2]};
      first[mesh.faces[3 * f + k] + 1]++;
    }
    area[f] = length(cross(corner[1] - corner[0], corner[2] - corner[0]));
    sum += area[f];
  }
  for (double &one : area) one *= sum > 0 ? double(mesh.face_count) / sum : 0;
  for (size_t v = 0; v < mesh.vertex_count; v++) first[v + 1] += first[v];
  std::vector<uint32_t> next(first.begin(), first.end() - 1);
  for (size_t i = 0; i < around.size(); i++) around[next[mesh.faces[i]]++] = uint32_t(i / 3);
  neighbours = std::make_unique<const WeightNeighbours>(mesh, first, around);
}

VisibilityFit::~VisibilityFit() = default;

std::vector<uint8_t> VisibilityFit::faces_to_judge(const Viewer &viewer) const {
  std::vector<uint8_t> out(mesh.face_count);
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    const uint32_t *face = mesh.faces + 3 * size_t(f);
    const Vec3 a = viewer.position(face[0]), way = viewer.way_from(viewer.at(face, 3, 3, 3));
    if (!(dot(cross(viewer.position(face[1]) - a, viewer.position(face[2]) - a), way) > 0)) continue;
    const double enough = settings.cosine * length(way);
    out[f] = dot(normals[face[0]], way) >= enough || dot(normals[face[1]], way) >= enough ||
             dot(normals[face[2]], way) >= enough;
  }
  return out;
}

uint16_t VisibilityFit::places_that_weigh(Viewer &viewer, uint32_t f) const {
  const uint32_t *face = mesh.faces + 3 * size_t(f);
  const bool whole = viewer.in_picture(face[0]) && viewer.in_picture(face[1]) && viewer.in_picture(face[2]);
  const Vec3 corner = viewer.position(face[0]);
  const Vec3 normal = cross(viewer.position(face[1]) - corner, viewer.position(face[2]) - corner);
  uint16_t out = 0;
  for (int p = 0; p < weight_place_count; p++) {
    const auto &[a, b, c] = twelfths[p];
    const Vec3 at = viewer.at(face, a, b, c), way = viewer.way_from(at),
               mean = normals[face[0]] * a + normals[face[1]] * b + normals[face[2]] * c;
    const bool counts = dot(normal, way) > 0 &&
                        dot(mean, way) >= settings.cosine * length(mean) * length(way) &&
                        (whole || viewer.in_picture(at));
    out |= uint16_t(counts << p);
  }
  return out;
}

std::vector<uint8_t> VisibilityFit::states(const fvv_camera &camera, const std::vector<uint8_t> &selected,
                                           const uint8_t *former) const {
  Viewer viewer(camera, mesh, rays);
  const WeightPlaces places(viewer, mesh, faces_to_judge(viewer), first, around);
  // Without an outline nearby nothing changes, and nothing has to be counted.
  std::vector<uint8_t> near(mesh.vertex_count);
  std::vector<uint16_t> weighs(mesh.face_count);
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    const uint32_t *face = mesh.faces + 3 * size_t(f);
    if (places.judged[f] && (places.mixed[face[0]] || places.mixed[face[1]] || places.mixed[face[2]]))
      for (size_t k = 0; k < 3; k++) near[face[k]] = 1;
  }
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    const uint32_t *face = mesh.faces + 3 * size_t(f);
    if (places.judged[f] && (near[face[0]] || near[face[1]] || near[face[2]]))
      weighs[f] = places_that_weigh(viewer, f);
  }
  return WeightSearch(mesh, *neighbours, first, around, area, places, weighs, selected, former, settings)
      .run();
}

} // namespace fvv::render
