#include "fvv_cxx/owned.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/verify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace fvv::mux {

namespace {

// Lattice and texture indices; the latter 0 without an atlas.
using Point = std::array<int32_t, 5>;
using Triangle = std::array<Point, 3>;
using Corner = std::pair<Point, std::array<uint32_t, 2>>; // with normal indices, 0 without
using Normal = std::array<float, 3>;

Point point_of(const fvv_mesh &mesh, uint32_t vertex) {
  const int32_t *p = mesh.lattice + 3 * size_t(vertex);
  if (!mesh.texture) return {p[0], p[1], p[2], 0, 0};
  const uint32_t *t = mesh.texture + 2 * size_t(vertex);
  return {p[0], p[1], p[2], int32_t(t[0]), int32_t(t[1])};
}

Corner corner_of(const fvv_mesh &mesh, uint32_t vertex) {
  if (!mesh.normals) return {point_of(mesh, vertex), {}};
  const uint32_t *n = mesh.normals + 2 * size_t(vertex);
  return {point_of(mesh, vertex), {n[0], n[1]}};
}

std::vector<Normal> normals_of(const fvv_mesh &mesh) {
  std::vector<Normal> normals(mesh.vertex_count);
  if (mesh.normals)
    fvv_normals_to_floats(mesh.normal_bits, mesh.normals, mesh.vertex_count, normals[0].data());
  return normals;
}

// By clauses 8.2 and 8.6 alone, without the canonicaliser.
std::vector<Point> points_of(const Plan &plan, const geometry::Mesh &source) {
  const geometry::Lattice &lattice = plan.lattice.lattice;
  const double texture_steps = std::ldexp(1.0, int(plan.texture_bits));
  std::vector<Point> points(source.vertex_count());
  for (size_t v = 0; v < points.size(); v++) {
    for (size_t k = 0; k < 3; k++)
      points[v][k] =
          int32_t(std::nearbyint((source.positions[3 * v + k] - lattice.origin[k]) / lattice.step));
    for (size_t k = 0; plan.texture_bits && k < 2; k++)
      points[v][3 + k] =
          int32_t(std::nearbyint(std::clamp(source.texture[2 * v + k], 0.0, 1.0) * texture_steps));
  }
  return points;
}

// Degrees between the normal of vertex v of the source and a decoded one.
double angle(const geometry::Mesh &source, size_t v, const Normal &found) {
  const double *wanted = &source.normals[3 * v];
  double dot = 0, squares = 0;
  for (size_t k = 0; k < 3; k++) {
    const size_t a = (k + 1) % 3, b = (k + 2) % 3;
    const double part = wanted[a] * double(found[b]) - wanted[b] * double(found[a]);
    dot += wanted[k] * double(found[k]);
    squares += part * part;
  }
  return std::atan2(std::sqrt(squares), dot) * 180 / std::acos(-1.0);
}

// How far a point is from where vertex v of the source lies.
void measure(const Plan &plan, const geometry::Mesh &source, size_t v, const Point &point,
             MeshVerdict &verdict) {
  const geometry::Lattice &lattice = plan.lattice.lattice;
  double metres[3];
  fvv_lattice_to_metres(lattice.origin, lattice.step, point.data(), metres);
  for (size_t k = 0; k < 3; k++)
    verdict.max_vertex_error =
        std::max(verdict.max_vertex_error, std::abs(source.positions[3 * v + k] - metres[k]));
  for (size_t k = 0; plan.texture_bits && k < 2; k++)
    verdict.max_texture_error =
        std::max(verdict.max_texture_error,
                 std::abs(source.texture[2 * v + k] - std::ldexp(point[3 + k], -int(plan.texture_bits))));
}

// Decoders may number vertices and faces otherwise and begin a face at another corner.
template <class Corners> Corners begun_at_least(Corners t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

std::vector<std::array<Corner, 3>> sorted_triangles(const fvv_mesh &mesh) {
  std::vector<std::array<Corner, 3>> triangles;
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    const uint32_t *corners = mesh.faces + 3 * size_t(f);
    triangles.push_back(begun_at_least(std::array<Corner, 3>{
        corner_of(mesh, corners[0]), corner_of(mesh, corners[1]), corner_of(mesh, corners[2])}));
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

MeshVerdict verify_alone(const Plan &plan, size_t frame, const PreparedMesh &from, const fvv_mesh &decoded) {
  OwnedMesh expected;
  fvv_mesh_report unused;
  canonicalise(plan, frame, from, expected, unused);
  if (sorted_triangles(decoded) != sorted_triangles(expected))
    throw MeshMismatch("the decoded mesh has other faces than " +
                       plan.capture.mesh_path(plan.capture.frames.number(int64_t(frame))));
  const geometry::Mesh &source = from.mesh;
  const std::vector<Normal> normals = normals_of(decoded);
  using Found = std::pair<Point, Normal>;
  std::vector<Found> found;
  for (uint32_t v = 0; v < decoded.vertex_count; v++) found.push_back({point_of(decoded, v), normals[v]});
  std::sort(found.begin(), found.end());
  std::vector<bool> met(found.size());
  const std::vector<Point> points = points_of(plan, source);
  MeshVerdict verdict;
  for (size_t v = 0; v < points.size(); v++) {
    const auto range = std::equal_range(found.begin(), found.end(), Found{points[v], {}},
                                        [](const Found &a, const Found &b) { return a.first < b.first; });
    if (range.first == range.second) continue; // the canonicaliser dropped it with its faces
    std::fill(met.begin() + (range.first - found.begin()), met.begin() + (range.second - found.begin()),
              true);
    measure(plan, source, v, points[v], verdict);
    if (!plan.normals.bits) continue;
    double nearest = 180; // at a hard edge there are several
    for (auto one = range.first; one != range.second; ++one)
      nearest = std::min(nearest, angle(source, v, one->second));
    verdict.max_normal_error = std::max(verdict.max_normal_error, nearest);
  }
  if (std::find(met.begin(), met.end(), false) != met.end())
    throw MeshMismatch("a decoded vertex is no vertex of the source");
  return verdict;
}

bool has_area(const Triangle &t) {
  int64_t u[3], v[3];
  for (size_t k = 0; k < 3; k++) {
    u[k] = int64_t(t[1][k]) - t[0][k];
    v[k] = int64_t(t[2][k]) - t[0][k];
  }
  return u[1] * v[2] != u[2] * v[1] || u[2] * v[0] != u[0] * v[2] || u[0] * v[1] != u[1] * v[0];
}

// Checks that the faces of the decoded mesh are triangles of the source, and the reverse.
void compare_faces(const Plan &plan, const geometry::Mesh &source, const std::vector<Point> &points,
                   const fvv_mesh &decoded, const MeshOrigins &origins) {
  std::vector<Triangle> wanted, found;
  for (size_t f = 0; f < source.face_count(); f++) {
    const uint32_t *corners = &source.faces[3 * f];
    wanted.push_back(begun_at_least(Triangle{points[corners[0]], points[corners[1]], points[corners[2]]}));
  }
  const std::vector<uint32_t> &origin = *origins.vertices;
  for (uint32_t f = 0; f < decoded.face_count; f++) {
    const uint32_t *corners = decoded.faces + 3 * size_t(f);
    found.push_back(begun_at_least(
        Triangle{points[origin[corners[0]]], points[origin[corners[1]]], points[origin[corners[2]]]}));
  }
  std::sort(wanted.begin(), wanted.end());
  std::sort(found.begin(), found.end());
  const auto has = [](const std::vector<Triangle> &all, const Triangle &t) {
    return std::binary_search(all.begin(), all.end(), t);
  };
  const auto turned = [](const Triangle &t) { return begun_at_least(Triangle{t[0], t[2], t[1]}); };
  size_t flipped = 0;
  for (const Triangle &t : found) {
    if (has(wanted, t)) continue;
    if (!has(wanted, turned(t))) throw MeshMismatch("a decoded face is none of the source's");
    flipped += has_area(t);
  }
  if (flipped > origins.flipped_faces)
    throw MeshMismatch(std::to_string(flipped) + " decoded faces are turned round, the encoder turned " +
                       std::to_string(origins.flipped_faces));
  if (plan.options.min_component) return; // small pieces are missing
  for (const Triangle &t : wanted)
    if (has_area(t) && !has(found, t) && !has(found, turned(t)))
      throw MeshMismatch("a face of the source is missing");
}

MeshVerdict verify_run(const Plan &plan, const MeshTrack &track, const geometry::Mesh &source,
                       const fvv_mesh &decoded, const MeshOrigins &origins) {
  const std::vector<uint32_t> &origin = *origins.vertices;
  if (origin.size() != decoded.vertex_count)
    throw MeshMismatch("expected " + std::to_string(origin.size()) + " vertices, found " +
                       std::to_string(decoded.vertex_count));
  const std::vector<Point> points = points_of(plan, source);
  const std::vector<Normal> normals = normals_of(decoded);
  MeshVerdict verdict;
  for (uint32_t v = 0; v < decoded.vertex_count; v++) {
    const Point point = point_of(decoded, v);
    if (point[3] != points.at(origin[v])[3] || point[4] != points[origin[v]][4])
      throw MeshMismatch("decoded vertex " + std::to_string(v) +
                         " has other texture coordinates than vertex " + std::to_string(origin[v]) +
                         " of the source");
    MeshVerdict one;
    measure(plan, source, origin[v], point, one);
    if (plan.normals.bits) one.max_normal_error = angle(source, origin[v], normals[v]);
    if (one.max_vertex_error > track.lattice.error() * (1 + 1e-9)) {
      char text[160];
      std::snprintf(text, sizeof text,
                    "decoded vertex %u is %g off vertex %u of the source, expected at most %g", v,
                    one.max_vertex_error, origin[v], track.lattice.error());
      throw MeshMismatch(text);
    }
    verdict.add(one);
  }
  compare_faces(plan, source, points, decoded, origins);
  return verdict;
}

} // namespace

MeshVerdict verify_mesh(const Plan &plan, const MeshTrack &track, size_t frame, const fvv_mesh &decoded,
                        const MeshOrigins &origins) {
  if (decoded.texture_bits != plan.texture_bits)
    throw MeshMismatch("the decoded mesh has texture coordinates of " + std::to_string(decoded.texture_bits) +
                       " bits, expected " + std::to_string(plan.texture_bits));
  if (decoded.normal_bits != plan.normals.bits)
    throw MeshMismatch("the decoded mesh has normals of " + std::to_string(decoded.normal_bits) +
                       " bits, expected " + std::to_string(plan.normals.bits));
  const PreparedMesh source = prepare_mesh(plan, track, frame);
  return origins.vertices ? verify_run(plan, track, source.mesh, decoded, origins)
                          : verify_alone(plan, frame, source, decoded);
}

} // namespace fvv::mux
