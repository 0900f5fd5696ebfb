#include "visibility_places.h"

#include "fvv_render/triangle_tree.h"

namespace visibility_bench {

namespace {

bool same_faces(const fvv_mesh &a, const fvv_mesh &b) {
  return a.vertex_count == b.vertex_count && a.face_count == b.face_count &&
         std::equal(a.faces, a.faces + 3 * size_t(a.face_count), b.faces);
}

// Where the places of now lay on the surface before.
std::vector<Place> former_places(const Frame &before, const Frame &now) {
  if (same_faces(before.surface.mesh, now.surface.mesh)) return now.places;
  std::vector<TriangleTree::Triangle> triangles;
  for (uint32_t f = 0; f < before.surface.mesh.face_count; f++)
    triangles.push_back(
        {before.surface.corner(f, 0), before.surface.corner(f, 1), before.surface.corner(f, 2)});
  const ClosestFinder finder(triangles);
  std::vector<Place> out;
  for (const Place &place : now.places) {
    const Surface &s = now.surface;
    const ClosestPoint found = finder.nearest(
        mixed(place, s.corner(place.face, 0), s.corner(place.face, 1), s.corner(place.face, 2)),
        out.empty() ? UINT32_MAX : out.back().face);
    out.push_back({found.face, {found.barycentric[0], found.barycentric[1], found.barycentric[2]}});
  }
  return out;
}

} // namespace

void Flicker::add(const Frame &before, const Frame &now) {
  const std::vector<Place> former = former_places(before, now);
  for (const View &view : now.views)
    for (const View &old : before.views) {
      if (old.camera.id != view.camera.id) continue;
      for (size_t i = 0; i < former.size(); i++) {
        const auto then = old.judge(before.surface, before.rays, former[i]);
        const auto here = view.judge(now.surface, now.rays, now.places[i]);
        if (!then || !here) continue;
        all++;
        bits += then->given != here->given;
        rays += then->truth != here->truth;
        needless += then->given != here->given && then->truth == here->truth;
      }
    }
}

void Flicker::report(nlohmann::ordered_json &out) const {
  if (!all) return;
  out["flips_percent"] = 100 * bits / all;
  out["ray_flips_percent"] = 100 * rays / all;
  out["needless_flips_percent"] = 100 * needless / all;
}

} // namespace visibility_bench
