#include "fvv_geometry/surface.h"

#include <algorithm>
#include <tuple>

namespace fvv::compare {

namespace {

using Triangle = render::TriangleTree::Triangle;

// Twice the area, in the direction of the normal.
Vec3 area_vector(const Triangle &t) {
  return cross(t[1] - t[0], t[2] - t[0]);
}

std::vector<Triangle> triangles_of(const geometry::Mesh &mesh) {
  std::vector<Triangle> out(mesh.face_count());
  for (size_t i = 0; i < mesh.faces.size(); i++) {
    const double *p = &mesh.positions[3 * size_t(mesh.faces[i])];
    out[i / 3][i % 3] = {p[0], p[1], p[2]};
  }
  return out;
}

// The places of vertices that faces use, each once, and the corners of faces as indices of those. A place has
// several vertices at the seams of an atlas, say, where normals must not break.
std::vector<Vec3> used_places(const geometry::Mesh &mesh, std::vector<std::array<uint32_t, 3>> &corners) {
  const std::vector<Vec3> all = positions_of(mesh);
  std::vector<uint32_t> sorted(mesh.faces);
  const auto order = [&](uint32_t v, uint32_t w) {
    return std::tie(all[v].x, all[v].y, all[v].z) < std::tie(all[w].x, all[w].y, all[w].z);
  };
  std::sort(sorted.begin(), sorted.end(),
            [&](uint32_t v, uint32_t w) { return order(v, w) || (!order(w, v) && v < w); });
  std::vector<uint32_t> first(all.size()); // the lowest vertex in the same place
  for (size_t i = 0; i < sorted.size(); i++)
    first[sorted[i]] = i && !order(sorted[i - 1], sorted[i]) ? first[sorted[i - 1]] : sorted[i];
  std::sort(sorted.begin(), sorted.end());
  std::vector<uint32_t> index(all.size());
  std::vector<Vec3> used;
  for (size_t i = 0; i < sorted.size(); i++) {
    const uint32_t v = sorted[i];
    if (first[v] != v || (i && sorted[i - 1] == v)) continue;
    index[v] = uint32_t(used.size());
    used.push_back(all[v]);
  }
  corners.resize(mesh.face_count());
  for (size_t i = 0; i < mesh.faces.size(); i++) corners[i / 3][i % 3] = index[first[mesh.faces[i]]];
  return used;
}

// The k-th element of the sequence in one dimension.
double low_discrepancy(size_t k, double step) {
  const double value = 0.5 + double(k) * step;
  return value - std::floor(value);
}

// 1 / g, 1 / g^2 and 1 / g^3 for the root g of x^4 = x + 1.
constexpr double step_strip = 0.8191725133961644, step_u = 0.671043606703789, step_v = 0.5497004779019701;

} // namespace

std::vector<Vec3> positions_of(const geometry::Mesh &mesh) {
  std::vector<Vec3> out(mesh.vertex_count());
  for (size_t v = 0; v < out.size(); v++)
    out[v] = {mesh.positions[3 * v], mesh.positions[3 * v + 1], mesh.positions[3 * v + 2]};
  return out;
}

std::vector<Triangle> as_triangles(const std::vector<Vec3> &points) {
  std::vector<Triangle> out;
  out.reserve(points.size());
  for (const Vec3 &p : points) out.push_back({p, p, p});
  return out;
}

Faces::Faces(const geometry::Mesh &mesh) : triangles(triangles_of(mesh)), faces_tree(triangles) {
  double sum = 0;
  for (const Triangle &t : triangles) cumulative.push_back(sum += length(area_vector(t)) / 2);
}

Surface::Surface(const geometry::Mesh &mesh)
    : Faces(mesh), used(used_places(mesh, corners)), points_tree(as_triangles(used)) {
  used_normals.resize(used.size());
  for (size_t f = 0; f < triangles.size(); f++)
    for (const uint32_t v : corners[f]) used_normals[v] += area_vector(triangles[f]);
  for (Vec3 &normal : used_normals) normal = normalised(normal);
  for (size_t i = 0; !mesh.normals.empty() && i < mesh.faces.size(); i++) {
    if (i % 3 == 0) own_normals.emplace_back();
    const double *n = &mesh.normals[3 * size_t(mesh.faces[i])];
    own_normals.back()[i % 3] = normalised(Vec3{n[0], n[1], n[2]});
  }
}

Vec3 Faces::face_normal(uint32_t face) const {
  return normalised(area_vector(triangles[face]));
}

Vec3 Surface::smooth_normal(uint32_t face, const std::array<double, 3> &barycentric) const {
  if (!own_normals.empty()) {
    const auto &[a, b, c] = own_normals[face];
    return normalised(a * barycentric[0] + b * barycentric[1] + c * barycentric[2]);
  }
  const auto &[a, b, c] = corners[face];
  return normalised(used_normals[a] * barycentric[0] + used_normals[b] * barycentric[1] +
                    used_normals[c] * barycentric[2]);
}

std::vector<Sample> Faces::sample(size_t count) const {
  std::vector<Sample> out(count);
  size_t face = 0;
  for (size_t k = 0; k < count; k++) {
    const double at = area() * (double(k) + low_discrepancy(k, step_strip)) / double(count);
    while (face + 1 < cumulative.size() && cumulative[face] <= at) face++;
    // Uniform over the triangle: Osada et al., "Shape distributions", ACM TOG 21(4), 2002.
    const double root = std::sqrt(low_discrepancy(k, step_u)), v = low_discrepancy(k, step_v);
    const std::array<double, 3> weights = {1 - root, root * (1 - v), root * v};
    const auto &[a, b, c] = triangles[face];
    out[k] = {uint32_t(face), weights, a * weights[0] + b * weights[1] + c * weights[2]};
  }
  return out;
}

Surface::Box Surface::box() const {
  Box box{used.front(), used.front()};
  for (const Vec3 &p : used) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return box;
}

} // namespace fvv::compare
