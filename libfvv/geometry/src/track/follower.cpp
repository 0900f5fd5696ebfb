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
constexpr Stage fine_stages[] = {{40, 0.5}, {28, 0.2}, {20, 0.1}};
// More solves follow more of the noise: with five the captured player takes 2 % more bytes at 1 mm.
constexpr int offset_solves = 3;
// A little of the way to the point itself, so that borders stay where they are.
constexpr double offset_reach = 25, offset_to_point = 0.03;
// Of others, times the square of what they may be off: that much of a frame is noise. Motion that is smooth
// takes fewer bytes.
constexpr double offset_smoothness = 0.25, least_smoothness = 0.01, most_smoothness = 1;
constexpr double memory_over_smoothness = 0.3;

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

std::vector<std::pair<uint32_t, uint32_t>> first_ring(const RunMesh &mesh) {
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  for (uint32_t v = 0; v < mesh.points.size(); v++)
    for (size_t i = mesh.first[v]; i < mesh.first[v + 1]; i++) pairs.emplace_back(v, mesh.neighbours[i]);
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

Follower::Follower(const geometry::Mesh &key, std::optional<double> off, std::function<void()> check)
    : body(key), unit(body.unit()), error(off ? std::optional<double>(*off / unit) : std::nullopt),
      coarse(body, coarse_spacing * unit), fine(body, fine_spacing * unit),
      coarse_system(coarse.vertices.size(), 6, Deformation::pairs(coarse)),
      fine_system(fine.vertices.size(), 6, Deformation::pairs(fine)),
      offset_system(body.points.size(), 3, first_ring(body)), shape(fine, body.points),
      check_cancelled(std::move(check)) {}

Follower::Firmness Follower::firmness(const Approach &approach) const {
  // Hulls are other ones in each frame: what they do beyond the motion is mostly noise.
  if (!error) return approach.steady ? Firmness{1, 0.1, 2} : Firmness{0.1, 0.005, 5};
  const double smoothness =
      std::clamp(offset_smoothness * *error * *error, least_smoothness, most_smoothness);
  return {smoothness, memory_over_smoothness * smoothness, offset_solves};
}

Posture Follower::start() const {
  return {shape.still(), std::vector<Vec3>(body.points.size()), body.points};
}

std::vector<Vec3> Follower::points_of(const Pose &pose, const std::vector<Vec3> &offsets) const {
  std::vector<Vec3> points = shape.apply(pose);
  for (uint32_t v = 0; v < points.size(); v++) points[v] += shape.rotation(pose, v) * offsets[v];
  return points;
}

// The motion goes on as it was.
Pose Follower::extrapolated(const Pose &last, const Pose &before) {
  Pose out = last;
  for (size_t k = 0; k < out.places.size(); k++) {
    const Mat3 turn = last.rotations[k] * transposed(before.rotations[k]);
    out.rotations[k] = turn * last.rotations[k];
    out.places[k] += last.places[k] - before.places[k];
  }
  return out;
}

Pose Follower::before_start(const Follower &other, const Posture &last, const Posture &before,
                            const std::vector<uint32_t> &like) const {
  const auto nearest_like = [&](uint32_t v) {
    uint32_t best = v;
    double least = INFINITY;
    for (uint32_t w = 0; w < like.size(); w++) {
      const Vec3 between = body.points[w] - body.points[v];
      if (like[w] == UINT32_MAX || !(dot(between, between) < least)) continue;
      least = dot(between, between);
      best = w;
    }
    return best;
  };
  Pose out = shape.still();
  for (size_t k = 0; k < fine.vertices.size(); k++) {
    const uint32_t v = fine.vertices[k], w = like[v] == UINT32_MAX ? like[nearest_like(v)] : like[v];
    if (w == UINT32_MAX) continue; // nothing is left of the other
    const Mat3 back = other.shape.rotation(before.pose, w) * transposed(other.shape.rotation(last.pose, w));
    out.rotations[k] = back;
    out.places[k] = before.points[w] + back * (out.places[k] - last.points[w]);
  }
  return out;
}

namespace {

// Of places on a mesh, with the normals of its vertices.
Vec3 mean_normal(const std::array<uint32_t, 3> &corners, const std::array<double, 3> &barycentric,
                 const std::vector<Vec3> &normals) {
  Vec3 out;
  for (size_t k = 0; k < 3; k++) out += normals[corners[k]] * barycentric[k];
  return normalised(out);
}

// Places of a mesh and points of a target that may be the same.
class Pairs {
public:
  Pairs(double furthest, const Target &of) : reach(furthest), target(of) {}

  // The point of the target that is nearest to a place. weight: of it. guess: where it was last time.
  void add_nearest(const std::array<uint32_t, 3> &corners, const std::array<double, 3> &barycentric,
                   Vec3 place, Vec3 normal, double weight, uint32_t &guess) {
    const render::ClosestPoint hit = target.finder.nearest(place, normal, guess == UINT32_MAX ? last : guess);
    if (hit.face == UINT32_MAX) return;
    last = guess = hit.face;
    const Vec3 there = mean_normal(target.mesh.faces[hit.face], hit.barycentric, target.normals);
    add({corners, barycentric, place, hit.point, there, weight}, normal, hit.squared);
  }

  void add(const Correspondence &pair, Vec3 normal, double squared) {
    const double cosine = dot(normal, pair.normal), distance = std::sqrt(squared);
    if (!(cosine > least_agreement) || !(distance < reach) || !(pair.weight > 0)) return;
    out.push_back(pair);
    out.back().weight *= cosine;
    distances.push_back(distance);
  }

  // Weighted as Geman and McClure do. By the median alone fast limbs would be outliers and stay behind.
  std::vector<Correspondence> weighted() {
    const double scale = std::max(3 * median_of(distances), reach / 4);
    for (size_t i = 0; i < out.size(); i++) {
      const double ratio = scale * scale / (scale * scale + distances[i] * distances[i]);
      out[i].weight *= ratio * ratio;
    }
    return std::move(out);
  }

private:
  const double reach;
  const Target &target;
  uint32_t last = UINT32_MAX;
  std::vector<Correspondence> out;
  std::vector<double> distances;
};

} // namespace

// From the mesh to the target, and from every stride-th vertex of the target.
std::vector<Correspondence> Follower::correspondences(const std::vector<Vec3> &points, const Target &target,
                                                      double reach, size_t stride, Places places,
                                                      Guesses &guesses) const {
  Pairs pairs(reach, target);
  guesses.vertices.resize(body.points.size(), UINT32_MAX);
  guesses.places.resize(3 * body.faces.size(), UINT32_MAX);
  guesses.target.resize(target.order.size(), UINT32_MAX);
  const std::vector<Vec3> normals = body.normals(points);
  for (uint32_t v = 0; places == Places::vertices && v < points.size(); v++)
    pairs.add_nearest({v, v, v}, {1, 0, 0}, points[v], normals[v], vertex_weight * body.areas[v] / body.area,
                      guesses.vertices[v]);
  for (size_t f = 0; places == Places::faces && f < body.faces.size(); f++) {
    const auto &[a, b, c] = body.faces[f];
    const double area = length(cross(points[b] - points[a], points[c] - points[a])) / 2;
    for (size_t k = 0; k < 3; k++) {
      std::array<double, 3> at = {1.0 / 6, 1.0 / 6, 1.0 / 6};
      at[k] = 2.0 / 3;
      pairs.add_nearest(body.faces[f], at, points[a] * at[0] + points[b] * at[1] + points[c] * at[2],
                        mean_normal(body.faces[f], at, normals), area / 3 / body.area,
                        guesses.places[3 * f + k]);
    }
  }
  guesses.moved = FacingFinder(body.triangles(points), guesses.moved ? &*guesses.moved : nullptr);
  uint32_t last = UINT32_MAX;
  for (size_t i = 0; i < target.order.size(); i += stride) {
    const uint32_t v = target.order[i];
    uint32_t &guess = guesses.target[i];
    const render::ClosestPoint hit =
        guesses.moved->nearest(target.mesh.points[v], target.normals[v], guess == UINT32_MAX ? last : guess);
    if (hit.face == UINT32_MAX) continue;
    last = guess = hit.face;
    pairs.add({body.faces[hit.face], hit.barycentric, hit.point, target.mesh.points[v], target.normals[v],
               double(stride) * target.mesh.areas[v] / target.mesh.area},
              mean_normal(body.faces[hit.face], hit.barycentric, normals), hit.squared);
  }
  return pairs.weighted();
}

// By coarse nodes, from the shape that the mesh has now.
bool Follower::move_coarse(const Target &target, Posture &posture, Guesses &guesses) {
  const Deformation change(coarse, posture.points);
  Pose pose = change.still();
  const size_t stride = 1 + target.order.size() / coarse_targets;
  std::vector<Vec3> points = posture.points;
  for (const Stage &stage : coarse_stages) {
    check_cancelled();
    if (!change.step(coarse_system,
                     correspondences(points, target, stage.reach * unit, stride, Places::vertices, guesses),
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

bool Follower::move_fine(const Target &target, Posture &posture, Guesses &guesses) {
  guesses.moved.reset();
  for (const Stage &stage : fine_stages) {
    check_cancelled();
    if (!shape.step(fine_system,
                    correspondences(posture.points, target, stage.reach * unit, 1, Places::vertices, guesses),
                    stage.rigidity, posture.pose))
      return false;
    posture.points = points_of(posture.pose, posture.offsets);
  }
  return true;
}

// Each vertex by itself, by what remains. That neighbours go the same way keeps vertices apart.
bool Follower::move_offsets(const Target &target, const Firmness &firm, Posture &posture, Guesses &guesses) {
  guesses.moved.reset();
  const size_t count = body.points.size();
  for (int solve = 0; solve < firm.solves; solve++) {
    check_cancelled();
    offset_system.clear();
    for (const Correspondence &c :
         correspondences(posture.points, target, offset_reach * unit, 1, Places::faces, guesses))
      add_pull(c, double(count));
    for (uint32_t v = 0; v < count; v++) {
      const double each = firm.smoothness / double(body.first[v + 1] - body.first[v]);
      for (size_t i = body.first[v]; i < body.first[v + 1]; i++) {
        const uint32_t w = body.neighbours[i];
        for (size_t axis = 0; axis < 3; axis++) {
          offset_system.at(v, v)[4 * axis] += each;
          offset_system.at(w, w)[4 * axis] += each;
          offset_system.at(std::max(v, w), std::min(v, w))[4 * axis] -= each;
        }
      }
      for (size_t axis = 0; axis < 3; axis++) offset_system.at(v, v)[4 * axis] += firm.memory;
    }
    const std::vector<double> moves = offset_system.solve();
    if (moves.empty() || !std::all_of(moves.begin(), moves.end(), [](double x) { return std::isfinite(x); }))
      return false;
    for (size_t v = 0; v < count; v++)
      posture.points[v] += Vec3{moves[3 * v], moves[3 * v + 1], moves[3 * v + 2]};
  }
  const std::vector<Vec3> base = shape.apply(posture.pose);
  for (uint32_t v = 0; v < count; v++)
    posture.offsets[v] = transposed(shape.rotation(posture.pose, v)) * (posture.points[v] - base[v]);
  return true;
}

// Towards the target's plane.
void Follower::add_pull(const Correspondence &c, double times) {
  const Vec3 pull = c.target - c.point;
  const double weight = times * c.weight, wanted = dot(pull, c.normal);
  for (size_t i = 0; i < 3; i++) {
    const uint32_t v = c.vertices[i];
    if (!(c.barycentric[i] > 0)) continue;
    for (int axis = 0; axis < 3; axis++)
      offset_system.right()[3 * size_t(v) + size_t(axis)] +=
          weight * c.barycentric[i] *
          (axis_of(c.normal, axis) * wanted + offset_to_point * axis_of(pull, axis));
    for (size_t j = 0; j < 3; j++) {
      if (!(c.barycentric[j] > 0) || v < c.vertices[j]) continue;
      double *to = offset_system.at(v, c.vertices[j]);
      for (int column = 0; column < 3; column++)
        for (int row = 0; row < 3; row++)
          to[3 * column + row] +=
              weight * c.barycentric[i] * c.barycentric[j] *
              (axis_of(c.normal, row) * axis_of(c.normal, column) + (row == column ? offset_to_point : 0));
    }
  }
}

std::optional<Posture> Follower::follow(const Posture &last, const Approach &approach, const Target &target) {
  Posture next = last;
  if (approach.before) {
    next.pose = extrapolated(last.pose, *approach.before);
    next.points = points_of(next.pose, next.offsets);
  }
  Guesses guesses;
  if ((!approach.near && !move_coarse(target, next, guesses)) || !move_fine(target, next, guesses) ||
      !move_offsets(target, firmness(approach), next, guesses))
    return {};
  return next;
}

} // namespace fvv::track
