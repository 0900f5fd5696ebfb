#include "geometry/src/track/run_mesh.h"
#include "fvv_geometry/pieces.h"

#include <algorithm>
#include <cmath>

namespace fvv::track {

RunMesh::RunMesh(const geometry::Mesh &mesh) {
  geometry::Mesh welded;
  welded.positions = mesh.positions;
  const std::vector<uint32_t> alike = decimate::first_alike(mesh, false);
  std::vector<uint32_t> kept;
  for (size_t f = 0; f < mesh.face_count(); f++) {
    const uint32_t a = alike[mesh.faces[3 * f]], b = alike[mesh.faces[3 * f + 1]],
                   c = alike[mesh.faces[3 * f + 2]];
    if (a != b && b != c && c != a) kept.insert(kept.end(), {a, b, c});
  }
  std::vector<uint32_t> vertices;
  welded = decimate::compact(welded, kept, vertices);
  std::vector<uint32_t> numbers(mesh.vertex_count(), UINT32_MAX);
  for (uint32_t v = 0; v < vertices.size(); v++) numbers[vertices[v]] = v;
  for (const uint32_t v : alike) number.push_back(numbers[v]);
  points = compare::positions_of(welded);
  areas.resize(points.size());
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  for (size_t f = 0; f < welded.face_count(); f++) {
    faces.push_back({welded.faces[3 * f], welded.faces[3 * f + 1], welded.faces[3 * f + 2]});
    const double third = decimate::face_area(welded, f) / 3;
    area += 3 * third;
    for (size_t k = 0; k < 3; k++) {
      areas[faces[f][k]] += third;
      edges.emplace_back(faces[f][k], faces[f][(k + 1) % 3]);
      edges.emplace_back(faces[f][(k + 1) % 3], faces[f][k]);
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  first.assign(points.size() + 1, 0);
  for (const auto &[from, to] : edges) {
    first[from + 1]++;
    neighbours.push_back(to);
  }
  for (size_t v = 0; v < points.size(); v++) first[v + 1] += first[v];
  std::vector<uint32_t> each(points.size());
  for (uint32_t v = 0; v < each.size(); v++) each[v] = v;
  const decimate::Pieces pieces = decimate::find_pieces(welded, each);
  piece = pieces.of_vertex;
  piece_areas = pieces.area;
}

double RunMesh::unit() const {
  constexpr double person = 2e6;    // square millimetres
  constexpr double most_pieces = 8; // of one size; sheets in many patches are one thing
  const double largest = piece_areas.empty() ? 0 : *std::max_element(piece_areas.begin(), piece_areas.end());
  return std::sqrt(std::max(largest, area / most_pieces) / person);
}

geometry::Mesh RunMesh::at(const std::vector<Vec3> &places) const {
  geometry::Mesh mesh;
  for (const Vec3 &p : places) mesh.positions.insert(mesh.positions.end(), {p.x, p.y, p.z});
  for (const auto &face : faces) mesh.faces.insert(mesh.faces.end(), face.begin(), face.end());
  return mesh;
}

std::vector<Vec3> RunMesh::normals(const std::vector<Vec3> &places) const {
  std::vector<Vec3> out(places.size());
  for (const auto &[a, b, c] : faces) {
    const Vec3 normal = cross(places[b] - places[a], places[c] - places[a]);
    for (const uint32_t v : {a, b, c}) out[v] += normal;
  }
  for (Vec3 &normal : out) normal = normalised(normal);
  return out;
}

std::vector<render::TriangleTree::Triangle> RunMesh::triangles(const std::vector<Vec3> &places) const {
  std::vector<render::TriangleTree::Triangle> out;
  out.reserve(faces.size());
  for (const auto &[a, b, c] : faces) out.push_back({places[a], places[b], places[c]});
  return out;
}

} // namespace fvv::track
