#include "fvv_geometry/pieces.h"
#include "fvv_geometry/decimate.h"
#include "fvv_render/vector.h"

#include <cmath>
#include <meshoptimizer.h>

namespace fvv::decimate {

namespace {

using render::Vec3;

Vec3 corner(const geometry::Mesh &mesh, size_t i) {
  const double *p = &mesh.positions[3 * size_t(mesh.faces[i])];
  return {p[0], p[1], p[2]};
}

uint32_t root_of(std::vector<uint32_t> &parent, uint32_t v) {
  while (parent[v] != v) v = parent[v] = parent[parent[v]];
  return v;
}

} // namespace

std::vector<uint32_t> first_alike(const geometry::Mesh &mesh, bool with_attributes) {
  const size_t count = mesh.vertex_count();
  std::vector<uint32_t> each(count), first(count);
  for (size_t v = 0; v < count; v++) each[v] = uint32_t(v);
  std::vector<meshopt_Stream> streams = {{mesh.positions.data(), 3 * sizeof(double), 3 * sizeof(double)}};
  if (with_attributes && !mesh.texture.empty())
    streams.push_back({mesh.texture.data(), 2 * sizeof(double), 2 * sizeof(double)});
  if (with_attributes && !mesh.normals.empty())
    streams.push_back({mesh.normals.data(), 3 * sizeof(double), 3 * sizeof(double)});
  // With an index buffer that names every vertex once, the shadow index is the first equal vertex. The
  // function needs whole triangles, so the last one is padded.
  while (each.size() % 3) each.push_back(uint32_t(count - 1));
  first.resize(each.size());
  meshopt_generateShadowIndexBufferMulti(first.data(), each.data(), each.size(), count, streams.data(),
                                         streams.size());
  first.resize(count);
  return first;
}

Pieces find_pieces(const geometry::Mesh &mesh, const std::vector<uint32_t> &alike) {
  std::vector<uint32_t> parent(alike);
  for (size_t f = 0; f < mesh.face_count(); f++)
    for (size_t k = 1; k < 3; k++) {
      const uint32_t a = root_of(parent, mesh.faces[3 * f]), b = root_of(parent, mesh.faces[3 * f + k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  Pieces pieces;
  pieces.of_vertex.assign(mesh.vertex_count(), UINT32_MAX);
  for (size_t f = 0; f < mesh.face_count(); f++) {
    const uint32_t root = root_of(parent, mesh.faces[3 * f]);
    uint32_t &number = pieces.of_vertex[root];
    if (number == UINT32_MAX) {
      number = uint32_t(pieces.faces.size());
      pieces.faces.push_back(0);
      pieces.area.push_back(0);
    }
    pieces.faces[number]++;
    pieces.area[number] += face_area(mesh, f);
    for (size_t k = 0; k < 3; k++) pieces.of_vertex[mesh.faces[3 * f + k]] = number;
  }
  return pieces;
}

namespace {

// What a piece encloses, of closed ones: there the vectors of all areas add up to nothing.
struct Shell {
  double volume = 0;
  Vec3 areas;
};

std::vector<Shell> shells_of(const geometry::Mesh &mesh, const Pieces &pieces) {
  std::vector<Shell> out(pieces.faces.size());
  std::vector<size_t> first(out.size(), SIZE_MAX);
  for (size_t i = 0; i + 2 < mesh.faces.size(); i += 3) {
    const uint32_t piece = pieces.of_vertex[mesh.faces[i]];
    if (first[piece] == SIZE_MAX) first[piece] = i;
    const Vec3 from = corner(mesh, first[piece]);
    const Vec3 a = corner(mesh, i) - from, b = corner(mesh, i + 1) - from, c = corner(mesh, i + 2) - from;
    out[piece].volume += dot(a, cross(b, c)) / 6;
    out[piece].areas += cross(b - a, c - a) * 0.5;
  }
  return out;
}

} // namespace

Lost flattened_pieces(const geometry::Mesh &source, const geometry::Lattice &lattice) {
  constexpr double least_area = 64; // square steps
  constexpr double closed = 1e-9;   // of the area, which rounding leaves
  constexpr double flat = 1e-9;     // steps; a sheet that is a surface twice had no thickness before
  geometry::Mesh exact = source;
  for (size_t i = 0; i < exact.positions.size(); i++)
    exact.positions[i] = (source.positions[i] - lattice.origin[i % 3]) / lattice.step;
  const Pieces pieces = find_pieces(exact, first_alike(exact, false));
  const std::vector<Shell> before = shells_of(exact, pieces);
  for (double &coordinate : exact.positions) coordinate = std::nearbyint(coordinate);
  const std::vector<Shell> after = shells_of(exact, pieces);
  std::vector<bool> there(before.size());
  for (size_t f = 0; f < exact.face_count(); f++)
    if (face_area(exact, f) > 0) there[pieces.of_vertex[exact.faces[3 * f]]] = true;
  Lost lost;
  for (size_t i = 0; i < there.size(); i++) {
    const double area = pieces.area[i], volume = before[i].volume;
    if (!there[i] || !(area >= least_area) || length(before[i].areas) > closed * area) continue;
    if (!(std::abs(volume) > flat * area) || !(after[i].volume / volume < 0.5)) continue;
    lost.pieces++;
    lost.area += area * lattice.step * lattice.step;
  }
  return lost;
}

double enclosed_volume(const geometry::Mesh &mesh) {
  if (mesh.faces.empty()) return 0;
  // From a corner of the surface: in coordinates of maps, parts seen from 0 cancel to nothing but rounding.
  const Vec3 from = corner(mesh, 0);
  double sum = 0;
  for (size_t i = 0; i + 2 < mesh.faces.size(); i += 3)
    sum += dot(corner(mesh, i) - from, cross(corner(mesh, i + 1) - from, corner(mesh, i + 2) - from));
  return sum / 6;
}

double face_area(const geometry::Mesh &mesh, size_t face) {
  const Vec3 a = corner(mesh, 3 * face);
  return length(cross(corner(mesh, 3 * face + 1) - a, corner(mesh, 3 * face + 2) - a)) / 2;
}

geometry::Mesh compact(const geometry::Mesh &mesh, const std::vector<uint32_t> &faces,
                       std::vector<uint32_t> &used) {
  std::vector<uint32_t> number(mesh.vertex_count(), UINT32_MAX);
  for (const uint32_t v : faces) number[v] = 0;
  geometry::Mesh out;
  used.clear();
  for (size_t v = 0; v < number.size(); v++) {
    if (number[v] == UINT32_MAX) continue;
    number[v] = uint32_t(used.size());
    used.push_back(uint32_t(v));
    out.positions.insert(out.positions.end(), &mesh.positions[3 * v], &mesh.positions[3 * v] + 3);
    if (!mesh.texture.empty())
      out.texture.insert(out.texture.end(), &mesh.texture[2 * v], &mesh.texture[2 * v] + 2);
    if (!mesh.normals.empty())
      out.normals.insert(out.normals.end(), &mesh.normals[3 * v], &mesh.normals[3 * v] + 3);
  }
  out.faces.reserve(faces.size());
  for (const uint32_t v : faces) out.faces.push_back(number[v]);
  return out;
}

} // namespace fvv::decimate
