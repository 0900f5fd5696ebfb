#include "geometry/src/track/patch.h"

#include <algorithm>
#include <cmath>

namespace fvv::track {

namespace {

constexpr uint32_t none = UINT32_MAX;
constexpr size_t least_island = 60;      // faces: a smaller part is not kept within what is left out
constexpr int attempts = 12;             // at corresponding borders
constexpr double largest_part = 1.0 / 3; // of the area
constexpr double facing_over_limit = 2;  // how far off a vertex of the substitute may be: it has an error too

std::vector<Vec3> places(const std::vector<uint32_t> &vertices, const std::vector<Vec3> &points) {
  std::vector<Vec3> out;
  for (const uint32_t v : vertices) out.push_back(points[v]);
  return out;
}

double mean_distance(const std::vector<Vec3> &from, const std::vector<Vec3> &to) {
  double sum = 0;
  for (const Vec3 &p : from) {
    double least = INFINITY;
    for (const Vec3 &q : to) least = std::min(least, dot(p - q, p - q));
    sum += std::sqrt(least);
  }
  return sum / double(from.size());
}

// For each border the one of others that is nearest to it, when it is also nearest to that; SIZE_MAX: none.
std::vector<size_t> pairs_of(const std::vector<Border> &borders, const std::vector<Vec3> &points,
                             const std::vector<Border> &others, const std::vector<Vec3> &other_points) {
  std::vector<size_t> best(borders.size(), SIZE_MAX), best_other(others.size(), SIZE_MAX);
  std::vector<double> least(borders.size(), INFINITY), least_other(others.size(), INFINITY);
  for (size_t i = 0; i < borders.size(); i++) {
    const std::vector<Vec3> here = places(borders[i].vertices, points);
    for (size_t j = 0; j < others.size(); j++) {
      if (others[j].closed != borders[i].closed) continue;
      const std::vector<Vec3> there = places(others[j].vertices, other_points);
      const double off = mean_distance(here, there) + mean_distance(there, here);
      if (off < least[i]) {
        least[i] = off;
        best[i] = j;
      }
      if (off < least_other[j]) {
        least_other[j] = off;
        best_other[j] = i;
      }
    }
  }
  for (size_t i = 0; i < borders.size(); i++)
    if (best[i] != SIZE_MAX && best_other[best[i]] != i) best[i] = SIZE_MAX;
  return best;
}

// Two borders side by side, and where the strip between them begins.
struct Strip {
  std::vector<uint32_t> a, b; // vertices, the first of closed ones at the end again
  std::vector<bool> along_a;  // each step: false is one along b
};

void rotate_to_nearest(Strip &strip, const std::vector<Vec3> &a_points, const std::vector<Vec3> &b_points) {
  size_t a_begin = 0, b_begin = 0;
  double least = INFINITY;
  for (size_t i = 0; i < strip.a.size(); i++)
    for (size_t j = 0; j < strip.b.size(); j++) {
      const Vec3 between = a_points[strip.a[i]] - b_points[strip.b[j]];
      if (!(dot(between, between) < least)) continue;
      least = dot(between, between);
      a_begin = i;
      b_begin = j;
    }
  std::rotate(strip.a.begin(), strip.a.begin() + std::ptrdiff_t(a_begin), strip.a.end());
  std::rotate(strip.b.begin(), strip.b.begin() + std::ptrdiff_t(b_begin), strip.b.end());
  strip.a.push_back(strip.a[0]);
  strip.b.push_back(strip.b[0]);
}

// The triangles with least area in all (Fuchs, Kedem, Uselton, "Optimal surface reconstruction from planar
// contours", CACM 20(10), 1977).
void find_steps(Strip &strip, const std::vector<Vec3> &a_points, const std::vector<Vec3> &b_points) {
  const std::vector<Vec3> a = places(strip.a, a_points), b = places(strip.b, b_points);
  const size_t n = a.size(), m = b.size();
  const auto area = [](Vec3 p, Vec3 q, Vec3 r) { return length(cross(q - p, r - p)); };
  std::vector<double> cost(n * m, INFINITY);
  std::vector<bool> along_a(n * m);
  cost[0] = 0;
  for (size_t i = 0; i < n; i++)
    for (size_t j = 0; j < m; j++) {
      const size_t here = i * m + j;
      if (i) {
        cost[here] = cost[here - m] + area(a[i - 1], a[i], b[j]);
        along_a[here] = true;
      }
      if (!j) continue;
      const double by_b = cost[here - 1] + area(b[j - 1], b[j], a[i]);
      if (i && !(by_b < cost[here])) continue;
      cost[here] = by_b;
      along_a[here] = false;
    }
  for (size_t i = n - 1, j = m - 1; i || j;) {
    strip.along_a.push_back(along_a[i * m + j]);
    along_a[i * m + j] ? i-- : j--;
  }
  std::reverse(strip.along_a.begin(), strip.along_a.end());
}

} // namespace

struct Patcher::Joint {
  std::vector<uint8_t> absent, in; // of the faces of the body and of the substitute
  std::vector<bool> taken;         // vertices of the substitute whose faces are in, wherever they are
  std::vector<bool> wanted;        // vertices of the substitute, whose parts are not dropped
  std::vector<Border> holes, rims; // of what remains of the body, of what is taken of the substitute
  std::vector<size_t> rim_of;      // of each hole
};

Patcher::Patcher(const RunMesh &run, const HalfEdges &run_edges, const std::vector<Vec3> &at,
                 const decimate::Reference &frame, const RunMesh &few)
    : body(run), edges(run_edges), points(at), source(frame), substitute(few), substitute_edges(few.faces),
      finder(run.triangles(at)), off(run.faces.size()), pixel(run.faces.size(), INFINITY) {
  render::ClosestPoint hit;
  for (size_t f = 0; f < off.size(); f++) {
    const auto &[a, b, c] = body.faces[f];
    const Vec3 p = points[a], q = points[b], r = points[c];
    for (const Vec3 &place :
         {(p + q + r) * (1.0 / 3), (p + q) * 0.5, (q + r) * 0.5, (r + p) * 0.5, p, q, r}) {
      hit = source.nearest(place, hit.face);
      const double size = source.pixel(source.mesh().faces[3 * size_t(hit.face)]);
      pixel[f] = std::min(pixel[f], size);
      off[f] = std::max(off[f], std::sqrt(hit.squared) / size);
    }
  }
  hit = {};
  for (const uint32_t v : source.along_surface()) {
    const double *p = &source.mesh().positions[3 * size_t(v)];
    hit = finder.nearest({p[0], p[1], p[2]}, hit.face);
    off[hit.face] = std::max(off[hit.face], std::sqrt(hit.squared) / source.pixel(v));
  }
  const FacingFinder faces(body.triangles(points));
  const std::vector<Vec3> normals = substitute.normals(substitute.points);
  for (size_t v = 0; v < normals.size(); v++) {
    facing.push_back(faces.nearest(substitute.points[v], normals[v], v ? facing.back().face : none));
    near.push_back(finder.nearest(substitute.points[v], facing.back().face));
  }
}

std::vector<uint8_t> Patcher::failing(double limit) const {
  std::vector<bool> touched(points.size());
  for (size_t f = 0; f < off.size(); f++)
    if (off[f] > limit)
      for (const uint32_t v : body.faces[f]) touched[v] = true;
  std::vector<uint8_t> out(off.size());
  add_faces_of(touched, out);
  return out;
}

void Patcher::add_faces_of(const std::vector<bool> &vertices, std::vector<uint8_t> &faces) const {
  for (size_t f = 0; f < faces.size(); f++)
    for (const uint32_t v : body.faces[f]) faces[f] |= uint8_t(vertices[v]);
}

bool Patcher::is_small(const std::vector<uint8_t> &faces) const {
  double area = 0, whole = 0;
  for (size_t f = 0; f < faces.size(); f++) {
    const auto &[a, b, c] = body.faces[f];
    const double here = length(cross(points[b] - points[a], points[c] - points[a]));
    whole += here;
    if (faces[f]) area += here;
  }
  return area <= largest_part * whole;
}

uint32_t Patcher::face_at(uint32_t vertex, double limit) const {
  const render::ClosestPoint &hit = facing[vertex];
  if (hit.face == none) return near[vertex].face;
  return std::sqrt(hit.squared) <= facing_over_limit * limit * pixel[hit.face] ? hit.face : near[vertex].face;
}

void Patcher::find_borders(double limit, Joint &joint) const {
  edges.fill(joint.absent, least_island);
  std::vector<uint8_t> kept(joint.absent.size());
  for (size_t f = 0; f < kept.size(); f++) kept[f] = !joint.absent[f];
  joint.holes = edges.borders(kept);
  joint.in.assign(substitute.faces.size(), 1);
  for (size_t f = 0; f < joint.in.size(); f++)
    for (const uint32_t v : substitute.faces[f])
      joint.in[f] &= uint8_t(joint.taken[v] || joint.absent[face_at(v, limit)]);
  substitute_edges.fill(joint.in, least_island);
  pair_borders(joint);
  if (drop_islands(joint)) pair_borders(joint);
}

void Patcher::pair_borders(Joint &joint) const {
  joint.rims = substitute_edges.borders(joint.in);
  joint.rim_of = pairs_of(joint.holes, points, joint.rims, substitute.points);
}

// Small parts of the substitute that no hole is for: they are on the run's mesh elsewhere. If the surface
// lacks them it is beyond the budget there, and what is around them is left out.
bool Patcher::drop_islands(Joint &joint) const {
  const std::vector<uint32_t> part = substitute_edges.parts(joint.in);
  std::vector<size_t> faces(part.size());
  std::vector<bool> has_rim(part.size()), needed(part.size());
  for (const uint32_t p : part) faces[p]++;
  for (const Border &rim : joint.rims) has_rim[part[rim.face]] = true;
  for (const size_t k : joint.rim_of)
    if (k != SIZE_MAX) needed[part[joint.rims[k].face]] = true;
  for (size_t f = 0; f < part.size() && !joint.wanted.empty(); f++)
    for (const uint32_t v : substitute.faces[f])
      if (joint.wanted[v]) needed[part[f]] = true;
  bool any = false;
  for (size_t f = 0; f < part.size(); f++)
    if (joint.in[f] && has_rim[part[f]] && !needed[part[f]] && faces[part[f]] < least_island) {
      joint.in[f] = 0;
      any = true;
    }
  return any;
}

// Grows both parts at borders that have no partner. False: all have one.
bool Patcher::grow(double limit, Joint &joint) const {
  std::vector<bool> touched(points.size()), has_hole(joint.rims.size());
  bool all = true;
  for (size_t k = 0; k < joint.holes.size(); k++)
    if (joint.rim_of[k] != SIZE_MAX) {
      has_hole[joint.rim_of[k]] = true;
    } else {
      all = false;
      for (const uint32_t v : joint.holes[k].vertices) touched[v] = true;
    }
  for (size_t k = 0; k < joint.rims.size(); k++) {
    if (has_hole[k]) continue;
    all = false;
    for (const uint32_t w : joint.rims[k].vertices)
      for (const uint32_t v : body.faces[face_at(w, limit)]) touched[v] = true;
  }
  if (all) return false;
  const auto count = std::count(joint.absent.begin(), joint.absent.end(), 1);
  add_faces_of(touched, joint.absent);
  if (std::count(joint.absent.begin(), joint.absent.end(), 1) > count) return true;
  // An island of the substitute that is on a part of the body elsewhere.
  for (size_t k = 0; k < joint.rims.size(); k++)
    for (size_t i = 0; i < joint.rims[k].vertices.size() && !has_hole[k]; i++) {
      const uint32_t v = joint.rims[k].vertices[i];
      joint.taken[v] = true;
      for (size_t n = substitute.first[v]; n < substitute.first[v + 1]; n++)
        joint.taken[substitute.neighbours[n]] = true;
    }
  return true;
}

std::optional<Patch> Patcher::make(double limit, const Wanted &wanted) const {
  Joint joint;
  joint.absent = failing(limit);
  for (size_t f = 0; f < wanted.absent.size(); f++) joint.absent[f] |= wanted.absent[f];
  joint.wanted = wanted.taken;
  joint.taken.resize(substitute.points.size());
  for (int attempt = 0; attempt < attempts && is_small(joint.absent); attempt++) {
    find_borders(limit, joint);
    if (!grow(limit, joint)) return joined(joint);
  }
  return {};
}

void Patcher::widen(const Patch &patch, const decimate::Outliers &beyond, Wanted &wanted) const {
  std::vector<uint32_t> remaining, close; // faces of the body
  for (uint32_t f = 0; f < patch.absent.size(); f++)
    if (!patch.absent[f]) remaining.push_back(f);
  for (const uint32_t f : beyond.faces)
    if (f < remaining.size()) close.push_back(remaining[f]);
  std::vector<bool> touched(points.size());
  for (const uint32_t f : beyond.faces)
    for (size_t k = 0; k < 3 && f >= remaining.size(); k++)
      if (const uint32_t v = patch.joins[patch.mesh.faces[3 * (f - remaining.size()) + k]]; v != none)
        touched[v] = true;
  wanted.taken.resize(substitute.points.size());
  render::ClosestPoint hit;
  for (const uint32_t v : beyond.vertices) {
    const double *p = &source.mesh().positions[3 * size_t(v)];
    hit = finder.nearest({p[0], p[1], p[2]}, hit.face);
    close.push_back(hit.face);
    wanted.taken[nearest_of_substitute({p[0], p[1], p[2]})] = true;
  }
  for (const uint32_t f : close)
    for (const uint32_t v : body.faces[f]) touched[v] = true;
  wanted.absent = patch.absent;
  add_faces_of(touched, wanted.absent);
  if (wanted.absent != patch.absent) return;
  // The patch itself is beyond the budget there.
  const std::vector<uint32_t> part = edges.parts(patch.absent);
  std::vector<bool> grows(part.size());
  for (const uint32_t f : close) grows[part[f]] = patch.absent[f];
  for (size_t f = 0; f < part.size(); f++)
    for (size_t k = 0; k < 3 && grows[part[f]]; k++) touched[body.faces[f][k]] = true;
  add_faces_of(touched, wanted.absent);
}

uint32_t Patcher::nearest_of_substitute(Vec3 place) const {
  uint32_t best = 0;
  double least = INFINITY;
  for (uint32_t v = 0; v < substitute.points.size(); v++) {
    const Vec3 between = substitute.points[v] - place;
    if (!(dot(between, between) < least)) continue;
    least = dot(between, between);
    best = v;
  }
  return best;
}

Patch Patcher::joined(const Joint &joint) const {
  Patch patch;
  patch.absent = joint.absent;
  std::vector<uint32_t> own(substitute.points.size(), none), joins(points.size(), none);
  const auto add = [&](Vec3 p, uint32_t join) {
    patch.mesh.positions.insert(patch.mesh.positions.end(), {p.x, p.y, p.z});
    patch.joins.push_back(join);
    return uint32_t(patch.joins.size() - 1);
  };
  const auto of_substitute = [&](uint32_t v) {
    if (own[v] == none) own[v] = add(substitute.points[v], none);
    return own[v];
  };
  const auto of_body = [&](uint32_t v) {
    if (joins[v] == none) joins[v] = add(points[v], v);
    return joins[v];
  };
  std::vector<uint32_t> &faces = patch.mesh.faces;
  for (size_t f = 0; f < joint.in.size(); f++)
    for (size_t k = 0; k < 3 && joint.in[f]; k++) faces.push_back(of_substitute(substitute.faces[f][k]));
  for (size_t k = 0; k < joint.holes.size(); k++) {
    // A hole has what remains to its left, and a rim what is taken: they run in opposite directions.
    Strip strip = {joint.holes[k].vertices, joint.rims[joint.rim_of[k]].vertices, {}};
    std::reverse(strip.b.begin(), strip.b.end());
    if (joint.holes[k].closed) rotate_to_nearest(strip, points, substitute.points);
    find_steps(strip, points, substitute.points);
    size_t i = 0, j = 0;
    for (const bool along_a : strip.along_a) {
      const uint32_t p = of_body(strip.a[i]), q = of_substitute(strip.b[j]);
      if (along_a)
        faces.insert(faces.end(), {of_body(strip.a[++i]), p, q});
      else
        faces.insert(faces.end(), {q, of_substitute(strip.b[++j]), p});
    }
  }
  return patch;
}

geometry::Mesh patched(const geometry::Mesh &mesh, const Patch &patch) {
  geometry::Mesh out;
  out.positions = mesh.positions;
  for (size_t i = 0; i < mesh.faces.size(); i++)
    if (!patch.absent[i / 3]) out.faces.push_back(mesh.faces[i]);
  const uint32_t before = mesh.vertex_count();
  for (const uint32_t v : patch.mesh.faces) out.faces.push_back(before + v);
  out.positions.insert(out.positions.end(), patch.mesh.positions.begin(), patch.mesh.positions.end());
  return out;
}

} // namespace fvv::track
