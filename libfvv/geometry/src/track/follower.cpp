#include "geometry/src/track/follower.h"

#include <algorithm>
#include <cmath>

namespace fvv::track {

namespace {

// Lengths are in RunMesh::unit(), millimetres of a person.
constexpr double coarse_spacing = 120, fine_spacing = 50;

// One step: how far correspondences reach, and how rigid the edges are.
struct Stage {
  double reach, rigidity;
};
constexpr Stage coarse_stages[] = {{150, 4}, {110, 2}, {80, 1}, {60, 0.5}, {45, 0.5}};
constexpr Stage fine_stages[] = {{40, 0.5}, {28, 0.2}, {20, 0.1}, {20, 0.1}, {20, 0.1}};
constexpr int offset_solves = 3;
constexpr double offset_reach = 25, offset_memory = 0.005;
// Hulls are other ones in each frame: what they do beyond the motion is mostly noise.
constexpr double offset_smoothness = 0.05, offset_smoothness_of_hulls = 0.5;
// Of the vertices, against the points of the target: a surface of chords fits best where its vertices lie
// outside of a convex one.
constexpr double vertex_weight = 0.1;
// Cosine between the normals of two surfaces that may be one.
constexpr double least_agreement = 0.5;
constexpr size_t coarse_targets = 6000; // about as many vertices of the target are looked at

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<std::pair<uint32_t, uint32_t>> second_ring(const RunMesh &mesh) {
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  for (uint32_t v = 0; v < mesh.points.size(); v++)
    for (size_t i = mesh.first[v]; i < mesh.first[v + 1]; i++) {
      pairs.emplace_back(v, mesh.neighbours[i]);
      for (size_t j = mesh.first[v]; j < i; j++) pairs.emplace_back(mesh.neighbours[j], mesh.neighbours[i]);
    }
  return pairs;
}

} // namespace

Target::Target(const geometry::Mesh &of)
    : mesh(of), normals(mesh.normals(mesh.points)), finder(mesh.triangles(mesh.points)) {
  std::vector<bool> known(mesh.points.size());
  const render::ClosestFinder all(mesh.triangles(mesh.points));
  for (const uint32_t f : all.along_surface())
    for (const uint32_t v : mesh.faces[f])
      if (!known[v]) {
        known[v] = true;
        order.push_back(v);
      }
}

Follower::Follower(const geometry::Mesh &key, bool hulls, std::function<void()> check)
    : body(key), unit(body.unit()), smoothness(hulls ? offset_smoothness_of_hulls : offset_smoothness),
      coarse(body, coarse_spacing * unit), fine(body, fine_spacing * unit),
      coarse_system(coarse.vertices.size(), 6, Deformation::pairs(coarse)),
      fine_system(fine.vertices.size(), 6, Deformation::pairs(fine)),
      offset_system(body.points.size(), 1, second_ring(body)), shape(fine, body.points),
      check_cancelled(std::move(check)) {}

Posture Follower::start() const {
  return {shape.still(), std::vector<double>(body.points.size()), body.points};
}

std::vector<Vec3> Follower::points_of(const Pose &pose, const std::vector<double> &offsets) const {
  std::vector<Vec3> points = shape.apply(pose);
  const std::vector<Vec3> normals = body.normals(points);
  for (size_t v = 0; v < points.size(); v++) points[v] += normals[v] * offsets[v];
  return points;
}

// The motion goes on as it was.
Pose Follower::extrapolated(const Posture &last, const Posture &before) const {
  Pose out = last.pose;
  for (size_t k = 0; k < out.places.size(); k++) {
    const Mat3 turn = last.pose.rotations[k] * transposed(before.pose.rotations[k]);
    out.rotations[k] = turn * last.pose.rotations[k];
    out.places[k] += last.pose.places[k] - before.pose.places[k];
  }
  return out;
}

// From the vertices to the target, and from every stride-th vertex of the target.
std::vector<Correspondence> Follower::correspondences(const std::vector<Vec3> &points, const Target &target,
                                                      double reach, size_t stride) const {
  std::vector<Correspondence> out;
  std::vector<double> distances;
  const auto add = [&](const Correspondence &c, Vec3 normal, double squared, double weight) {
    const double cosine = dot(normal, c.normal), distance = std::sqrt(squared);
    if (!(cosine > least_agreement) || !(distance < reach) || !(weight > 0)) return;
    out.push_back(c);
    out.back().weight = weight * cosine;
    distances.push_back(distance);
  };
  const std::vector<Vec3> normals = body.normals(points);
  uint32_t guess = UINT32_MAX;
  for (uint32_t v = 0; v < points.size(); v++) {
    const render::ClosestPoint hit = target.finder.nearest(points[v], normals[v], guess);
    if (hit.face == UINT32_MAX) continue;
    guess = hit.face;
    const auto &corners = target.mesh.faces[hit.face];
    Vec3 normal;
    for (size_t k = 0; k < 3; k++) normal += target.normals[corners[k]] * hit.barycentric[k];
    add({{v, v, v}, {1, 0, 0}, points[v], hit.point, normalised(normal), 0}, normals[v], hit.squared,
        vertex_weight * body.areas[v] / body.area);
  }
  const FacingFinder finder(body.triangles(points));
  for (size_t i = 0; i < target.order.size(); i += stride) {
    const uint32_t v = target.order[i];
    const render::ClosestPoint hit = finder.nearest(target.mesh.points[v], target.normals[v], guess);
    if (hit.face == UINT32_MAX) continue;
    guess = hit.face;
    const auto &corners = body.faces[hit.face];
    Vec3 normal;
    for (size_t k = 0; k < 3; k++) normal += normals[corners[k]] * hit.barycentric[k];
    add({corners, hit.barycentric, hit.point, target.mesh.points[v], target.normals[v], 0},
        normalised(normal), hit.squared, double(stride) * target.mesh.areas[v] / target.mesh.area);
  }
  // Geman and McClure. By the median alone fast limbs would be outliers and stay behind.
  const double scale = std::max(3 * median_of(distances), reach / 4);
  for (size_t i = 0; i < out.size(); i++) {
    const double ratio = scale * scale / (scale * scale + distances[i] * distances[i]);
    out[i].weight *= ratio * ratio;
  }
  return out;
}

// By coarse nodes, from the shape that the mesh has now.
bool Follower::move_coarse(const Target &target, Posture &posture) {
  const Deformation change(coarse, posture.points);
  Pose pose = change.still();
  const size_t stride = 1 + target.order.size() / coarse_targets;
  std::vector<Vec3> points = posture.points;
  for (const Stage &stage : coarse_stages) {
    check_cancelled();
    if (!change.step(coarse_system, correspondences(points, target, stage.reach * unit, stride),
                     stage.rigidity, pose))
      return false;
    points = change.apply(pose);
  }
  // The fine nodes take part.
  const std::vector<Vec3> before = shape.apply(posture.pose);
  for (size_t k = 0; k < fine.vertices.size(); k++) {
    const uint32_t v = fine.vertices[k];
    const Mat3 turn = change.rotation(pose, v);
    posture.pose.rotations[k] = turn * posture.pose.rotations[k];
    // The node lies where its vertex is, less the offset of that.
    posture.pose.places[k] = points[v] + turn * (posture.pose.places[k] - posture.points[v]);
  }
  posture.points = points_of(posture.pose, posture.offsets);
  return true;
}

bool Follower::move_fine(const Target &target, Posture &posture) {
  for (const Stage &stage : fine_stages) {
    check_cancelled();
    if (!shape.step(fine_system, correspondences(posture.points, target, stage.reach * unit, 1),
                    stage.rigidity, posture.pose))
      return false;
    posture.points = points_of(posture.pose, posture.offsets);
  }
  return true;
}

// Along the normals, by what remains; smooth against the offsets of the frame before.
bool Follower::move_offsets(const Target &target, const std::vector<double> &last, Posture &posture) {
  const std::vector<Vec3> base = shape.apply(posture.pose), normals = body.normals(base);
  const size_t count = base.size();
  for (int solve = 0; solve < offset_solves; solve++) {
    check_cancelled();
    const std::vector<Correspondence> found = correspondences(posture.points, target, offset_reach * unit, 1);
    SparseSystem &system = offset_system;
    system.clear();
    std::vector<double> &right = system.right();
    for (const Correspondence &c : found) {
      double along[3];
      Vec3 still; // where the point would be without offsets
      for (size_t k = 0; k < 3; k++) {
        along[k] = c.barycentric[k] * dot(normals[c.vertices[k]], c.normal);
        still += base[c.vertices[k]] * c.barycentric[k];
      }
      const double wanted = dot(c.target - still, c.normal), weight = c.weight * double(count);
      for (size_t i = 0; i < 3; i++) {
        if (!(c.barycentric[i] > 0)) continue;
        right[c.vertices[i]] += weight * along[i] * wanted;
        for (size_t j = 0; j < 3; j++)
          if (c.barycentric[j] > 0 && c.vertices[i] >= c.vertices[j])
            *system.at(c.vertices[i], c.vertices[j]) += weight * along[i] * along[j];
      }
    }
    // The Laplacian of what changes.
    for (uint32_t v = 0; v < count; v++) {
      const size_t degree = body.first[v + 1] - body.first[v];
      std::vector<std::pair<uint32_t, double>> row = {{v, 1.0}};
      for (size_t i = body.first[v]; i < body.first[v + 1]; i++)
        row.emplace_back(body.neighbours[i], -1.0 / double(degree));
      double before = 0;
      for (const auto &[w, value] : row) before += value * last[w];
      for (const auto &[a, x] : row) {
        right[a] += smoothness * x * before;
        for (const auto &[b, y] : row)
          if (a >= b) *system.at(a, b) += smoothness * x * y;
      }
      *system.at(v, v) += offset_memory;
      right[v] += offset_memory * last[v];
    }
    std::vector<double> offsets = system.solve();
    if (offsets.empty() ||
        !std::all_of(offsets.begin(), offsets.end(), [](double x) { return std::isfinite(x); }))
      return false;
    posture.offsets = std::move(offsets);
    posture.points = points_of(posture.pose, posture.offsets);
  }
  return true;
}

std::optional<Posture> Follower::follow(const Posture &last, const Posture *before, const Target &target) {
  Posture next = last;
  if (before) {
    next.pose = extrapolated(last, *before);
    next.points = points_of(next.pose, next.offsets);
  }
  if (!move_coarse(target, next) || !move_fine(target, next) || !move_offsets(target, last.offsets, next))
    return {};
  return next;
}

} // namespace fvv::track
