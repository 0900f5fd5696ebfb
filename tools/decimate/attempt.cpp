#include "decimate/attempt.h"

#include "decimate/pieces.h"

#include <algorithm>
#include <numeric>

namespace fvv::decimate {

namespace {

// Rings of faces around an outlier that stay with it: the surface there is as fine as it was, and what joins
// it to the coarse one lies beyond.
constexpr int rings = 2;
// Where more than one face in so many has to stay, the simplifier went too far.
constexpr size_t most_held = 16;

// Lattice points as whole numbers, of which areas are exact.
capture::Mesh on_points(const capture::Mesh &mesh, const capture::Lattice &lattice) {
  capture::Mesh points = mesh;
  for (size_t i = 0; i < points.positions.size(); i++)
    points.positions[i] = std::nearbyint((mesh.positions[i] - lattice.origin[i % 3]) / lattice.step) + 0.0;
  return points;
}

// The faces of a mesh that a canonical one on the lattice keeps: those with an area, each set of three points
// once. What it drops must not count as a surface that is there.
std::vector<uint32_t> lasting_faces(const capture::Mesh &mesh, const capture::Lattice &lattice) {
  const capture::Mesh points = on_points(mesh, lattice);
  const std::vector<uint32_t> place = first_alike(points, false);
  std::vector<std::array<uint32_t, 4>> sets; // sorted places, face
  for (uint32_t f = 0; f < points.face_count(); f++) {
    if (!(face_area(points, f) > 0)) continue;
    const uint32_t *c = &mesh.faces[3 * size_t(f)];
    std::array<uint32_t, 4> set = {place[c[0]], place[c[1]], place[c[2]], f};
    std::sort(set.begin(), set.begin() + 3);
    sets.push_back(set);
  }
  std::sort(sets.begin(), sets.end());
  const auto last = std::unique(sets.begin(), sets.end(), [](const auto &a, const auto &b) {
    return std::equal(a.begin(), a.begin() + 3, b.begin());
  });
  std::vector<uint32_t> faces;
  for (auto set = sets.begin(); set != last; ++set) faces.push_back((*set)[3]);
  std::sort(faces.begin(), faces.end());
  return faces;
}

// What a decoder will have of a mesh.
capture::Mesh rounded(const capture::Mesh &mesh, const capture::Lattice &lattice,
                      const std::vector<uint32_t> &lasting) {
  capture::Mesh out = mesh;
  for (size_t i = 0; i < out.positions.size(); i++) {
    const double origin = lattice.origin[i % 3];
    out.positions[i] = origin + lattice.step * std::nearbyint((mesh.positions[i] - origin) / lattice.step);
  }
  out.faces.clear();
  for (const uint32_t face : lasting)
    out.faces.insert(out.faces.end(), &mesh.faces[3 * size_t(face)], &mesh.faces[3 * size_t(face)] + 3);
  return out;
}

} // namespace

bool sound(const capture::Mesh &mesh) {
  if (!std::all_of(mesh.positions.begin(), mesh.positions.end(), [](double x) { return std::isfinite(x); }))
    return false;
  double area = 0;
  for (size_t f = 0; f < mesh.face_count(); f++) area += face_area(mesh, f);
  return area > 0 && std::isfinite(area);
}

std::vector<uint32_t> without_specks(const capture::Mesh &source, const Budget &budget, Report &report) {
  const Pieces pieces = find_pieces(source, first_alike(source, false));
  const capture::Mesh points = on_points(source, budget.lattice);
  std::vector<bool> there(pieces.faces.size());
  const auto piece_of = [&](size_t face) { return pieces.of_vertex[source.faces[3 * face]]; };
  const auto small = [&](size_t piece) { return pieces.faces[piece] < budget.min_piece; };
  for (size_t f = 0; f < source.face_count(); f++)
    if (!there[piece_of(f)] && !small(piece_of(f))) there[piece_of(f)] = face_area(points, f) > 0;
  std::vector<uint32_t> faces;
  for (size_t f = 0; f < source.face_count(); f++)
    if (there[piece_of(f)]) faces.insert(faces.end(), &source.faces[3 * f], &source.faces[3 * f] + 3);
  if (faces.empty()) return source.faces;
  for (size_t i = 0; i < there.size(); i++) {
    if (small(i)) {
      report.dropped_pieces++;
      report.dropped_faces += pieces.faces[i];
    } else if (!there[i] && pieces.area[i] > 0) {
      report.vanished.pieces++;
      report.vanished.area += pieces.area[i];
    }
  }
  return faces;
}

Decimated as_it_is(const capture::Mesh &source) {
  Decimated out;
  out.mesh = source;
  out.vertices.resize(source.vertex_count());
  std::iota(out.vertices.begin(), out.vertices.end(), 0);
  out.report.faces_before = out.report.faces_after = source.face_count();
  out.report.volume_before = out.report.volume_after = enclosed_volume(source);
  out.report.kept = true;
  return out;
}

Report look_at(const Reference &reference, const capture::Mesh &mesh, const Budget &budget,
               Outliers &outliers) {
  const std::vector<uint32_t> lasting = lasting_faces(mesh, budget.lattice);
  const capture::Mesh on_lattice = rounded(mesh, budget.lattice, lasting);
  Report report;
  report.faces_before = reference.mesh().face_count();
  report.faces_after = mesh.face_count();
  report.volume_before = enclosed_volume(reference.mesh());
  report.volume_after = enclosed_volume(on_lattice);
  const compare::Faces surface(on_lattice);
  if (!(surface.area() > 0)) {
    report.error = {INFINITY, INFINITY, INFINITY, INFINITY};
    return report;
  }
  report.error = reference.measure(surface, max_over_rms * budget.pixels, outliers);
  for (uint32_t &face : outliers.faces) face = lasting[face];
  report.thin_area = outliers.area;
  return report;
}

Lost vanished(const capture::Mesh &source, const capture::Mesh &mesh, const std::vector<uint32_t> &vertices,
              const Budget &budget) {
  const Pieces pieces = find_pieces(source, first_alike(source, false));
  std::vector<bool> there(pieces.faces.size());
  for (const uint32_t face : lasting_faces(mesh, budget.lattice))
    there[pieces.of_vertex[vertices[mesh.faces[3 * size_t(face)]]]] = true;
  Lost lost;
  for (size_t i = 0; i < there.size(); i++) {
    if (there[i] || !(pieces.area[i] > 0)) continue;
    lost.pieces++;
    lost.area += pieces.area[i];
  }
  return lost;
}

bool hold(const capture::Mesh &source, const std::vector<uint32_t> &alike, const capture::Mesh &decimated,
          const std::vector<uint32_t> &vertices, const Outliers &outliers, std::vector<bool> &held) {
  std::vector<bool> marked(source.vertex_count());
  for (const uint32_t v : outliers.vertices) marked[alike[v]] = true;
  for (const uint32_t f : outliers.faces)
    for (size_t k = 0; k < 3; k++) marked[alike[vertices[decimated.faces[3 * size_t(f) + k]]]] = true;
  const auto count = [&] { return std::count(held.begin(), held.end(), true); };
  const auto before = count();
  held.resize(source.face_count());
  for (int ring = 0; ring < rings; ring++) {
    std::vector<bool> wider = marked;
    for (size_t f = 0; f < source.face_count(); f++) {
      const uint32_t *c = &source.faces[3 * f];
      if (!marked[alike[c[0]]] && !marked[alike[c[1]]] && !marked[alike[c[2]]]) continue;
      held[f] = true;
      for (size_t k = 0; k < 3; k++) wider[alike[c[k]]] = true;
    }
    marked.swap(wider);
  }
  return count() > before && size_t(count()) <= source.face_count() / most_held;
}

double shorter(double reach, double pixels, const Budget &budget) {
  // The error grows with the reach, about as fast.
  return reach * std::clamp(0.98 * budget.pixels / pixels, 0.3, 0.95);
}

} // namespace fvv::decimate
