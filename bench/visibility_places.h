// Places spread over the surface of a frame, and their visibility by weights and by rays: shared by the
// measurements of visibility.
#pragma once

#include "fvvbench.h"

#include "fvv_render/normals.h"
#include "fvv_render/occlusion.h"

#include <cmath>
#include <optional>

namespace visibility_bench {

using namespace fvv::render;

constexpr double weight_threshold = 0.25; // of view-dependent texturing

struct Surface {
  fvv_mesh mesh = {};
  std::vector<float> metres;
  std::vector<Vec3> normals;
  Surface(fvv_stream *stream, size_t frame, const fvv_scene &scene) {
    fvv_diagnostic d{};
    require(fvv_stream_mesh(stream, frame, 1, &mesh, &d), d);
    metres.resize(3 * size_t(mesh.vertex_count));
    fvv_lattice_to_floats(scene.lattice_origin, scene.lattice_step, mesh.lattice, mesh.vertex_count,
                          metres.data());
    normals = vertex_normals(view());
  }
  Surface(const Surface &) = delete;
  ~Surface() { fvv_mesh_free(&mesh); }
  Mesh view() const { return {metres.data(), mesh.vertex_count, mesh.faces, mesh.face_count}; }
  Vec3 corner(uint32_t face, int i) const {
    const float *p = &metres[3 * size_t(mesh.faces[3 * size_t(face) + size_t(i)])];
    return {p[0], p[1], p[2]};
  }
  Vec3 face_normal(uint32_t f) const { // twice the area long
    return cross(corner(f, 1) - corner(f, 0), corner(f, 2) - corner(f, 0));
  }
};

struct Place {
  uint32_t face;
  double weight[3]; // barycentric
};

// As many places as faces, spread evenly over the area: every part of the surface counts by its size.
inline std::vector<Place> places_on(const Surface &surface) {
  const uint32_t count = surface.mesh.face_count;
  double area = 0, passed = 0;
  for (uint32_t f = 0; f < count; f++) area += length(surface.face_normal(f));
  const double step = area / count;
  std::vector<Place> out;
  for (uint32_t f = 0; f < count; f++) {
    passed += length(surface.face_normal(f));
    while ((double(out.size()) + 0.5) * step < passed) {
      const auto n = double(out.size());
      double u = std::fmod(0.5 + 0.7548776662466927 * n, 1.0),
             v = std::fmod(0.5 + 0.5698402909980532 * n, 1.0);
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      out.push_back({f, {1 - u - v, u, v}});
    }
  }
  return out;
}

inline Vec3 mixed(const Place &place, Vec3 a, Vec3 b, Vec3 c) {
  return a * place.weight[0] + b * place.weight[1] + c * place.weight[2];
}

// By fvv.md, clause 17.4, as players do.
inline bool says(const std::vector<uint8_t> &weights, const Surface &surface, const Place &place) {
  double seen = 0;
  for (size_t i = 0; i < 3; i++)
    seen += weights[surface.mesh.faces[3 * size_t(place.face) + i]] * place.weight[i];
  return seen >= 127.5;
}

// The visibility of a surface from one camera.
struct View {
  fvv_camera camera;
  Vec3 centre;
  std::vector<uint8_t> weights;

  View(const fvv_camera &chosen, const Surface &surface, const uint8_t *states)
      : camera(chosen), weights(surface.mesh.vertex_count) {
    double at[3];
    fvv_camera_centre(&camera, at);
    centre = {at[0], at[1], at[2]};
    fvv_visibility_weights(states, weights.size(), weights.data());
  }

  struct Judgement {
    Vec3 where;
    double weight;
    bool front, given, truth; // truth: the front, and a ray to the place itself
  };

  // None unless the weight, by the interpolated normal, reaches the threshold and the place lies in the
  // picture.
  std::optional<Judgement> judge(const Surface &surface, const RayCaster &rays, const Place &place) const {
    const uint32_t *face = surface.mesh.faces + 3 * size_t(place.face);
    const Vec3 where = mixed(place, surface.corner(place.face, 0), surface.corner(place.face, 1),
                             surface.corner(place.face, 2));
    const Vec3 normal = normalised(
        mixed(place, surface.normals[face[0]], surface.normals[face[1]], surface.normals[face[2]]));
    const double weight = dot(normal, normalised(centre - where));
    if (!(weight >= weight_threshold)) return {};
    const double world[3] = {where.x, where.y, where.z};
    double pixel[2];
    if (!fvv_camera_project(&camera, world, pixel, nullptr) || pixel[0] < 0 || pixel[1] < 0 ||
        pixel[0] >= camera.width || pixel[1] >= camera.height)
      return {};
    const bool front = dot(surface.face_normal(place.face), centre - where) > 0;
    return Judgement{where, weight, front, front && says(weights, surface, place),
                     front && !hidden_by_rays(centre, where, place.face, rays)};
  }
};

// All results of one frame.
struct Frame {
  Surface surface;
  RayCaster rays;
  std::vector<Place> places;
  std::vector<View> views;
  Frame(fvv_stream *stream, size_t number, const fvv_scene &scene)
      : surface(stream, number, scene), rays(surface.view()), places(places_on(surface)) {}
};

// How often the visibility of a place differs from that in the frame before, of the same place or, where
// faces differ, of the nearest one.
class Flicker {
public:
  void add(const Frame &before, const Frame &now);
  void report(nlohmann::ordered_json &out) const; // none for a single frame

private:
  double all = 0, bits = 0, rays = 0, needless = 0;
};

} // namespace visibility_bench
