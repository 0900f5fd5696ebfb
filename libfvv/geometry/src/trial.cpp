#include "geometry/src/trial.h"

#include <algorithm>

namespace fvv::decimate {

namespace {

constexpr uint32_t none = UINT32_MAX;

} // namespace

Outliers Trial::look(const geometry::Mesh &mesh, const std::vector<uint32_t> &vertices,
                     const compare::Faces &surface) {
  std::vector<Key> fresh;
  for (uint32_t f = 0; f < mesh.face_count(); f++) {
    const uint32_t *c = &mesh.faces[3 * size_t(f)];
    Key key = {vertices[c[0]], vertices[c[1]], vertices[c[2]], f};
    std::rotate(key.begin(), std::min_element(key.begin(), key.begin() + 3), key.begin() + 3);
    fresh.push_back(key);
  }
  std::sort(fresh.begin(), fresh.end());
  std::vector<uint32_t> now(keys.size(), none); // the same face in this mesh
  const auto less = [](const Key &a, const Key &b) {
    return std::lexicographical_compare(a.begin(), a.begin() + 3, b.begin(), b.begin() + 3);
  };
  for (size_t i = 0, j = 0; i < keys.size() && j < fresh.size();) {
    if (less(keys[i], fresh[j])) {
      i++;
    } else if (less(fresh[j], keys[i])) {
      j++;
    } else {
      now[keys[i++][3]] = fresh[j++][3];
    }
  }

  Outliers outliers;
  const geometry::Mesh &source = reference.mesh();
  near.resize(source.vertex_count(), none);
  render::ClosestPoint hit; // the search begins with that of the point before
  for (const uint32_t v : reference.along_surface()) {
    if (near[v] != none && (near[v] = now[near[v]]) != none) continue;
    const double *p = &source.positions[3 * size_t(v)], size = limit * reference.pixel(v);
    hit = surface.nearest({p[0], p[1], p[2]}, hit.face, size * size);
    if (hit.squared <= size * size) {
      near[v] = hit.face;
    } else {
      outliers.vertices.push_back(v);
      outliers.area += reference.area(v);
    }
  }

  std::vector<bool> known(mesh.face_count());
  for (size_t f = 0; f < now.size(); f++)
    if (now[f] != none) known[now[f]] = fine[f];
  const std::vector<render::Vec3> positions = compare::positions_of(mesh);
  const double least = limit * reference.sharpest();
  hit = {};
  fine.assign(mesh.face_count(), true);
  for (const uint32_t f : surface.along_surface()) {
    for (size_t k = 0; k < 3 && !known[f]; k++) {
      const uint32_t a = mesh.faces[3 * size_t(f) + k], b = mesh.faces[3 * size_t(f) + (k + 1) % 3];
      if (a > b) continue; // the face on the other side checks it
      hit = reference.nearest((positions[a] + positions[b]) * 0.5, hit.face, least * least);
      const uint32_t *corners = &source.faces[3 * size_t(hit.face)];
      if (!(std::sqrt(hit.squared) > limit * reference.pixel(corners[0]))) continue;
      outliers.vertices.insert(outliers.vertices.end(), corners, corners + 3);
      outliers.faces.push_back(f);
      fine[f] = false;
    }
  }
  keys.swap(fresh);
  return outliers;
}

} // namespace fvv::decimate
