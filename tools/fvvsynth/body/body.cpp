// The figure's parts, triangles from an implicit surface, and the meshes that bones carry.
#include "fvvsynth/body/body.h"

#include "fvv_geometry/hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <vector>

namespace fvv::synth {

namespace {

constexpr double blend[layer_count] = {0.030, 0.015, 0.030, 0.045,
                                       0.025}; // metres over which parts flow together
constexpr double layer_blend = 0.006;          // cloth lies on skin with a visible edge
constexpr double far_away = 1e3;

double part_distance(const Part &part, Vec3 p) {
  Vec3 from = p - part.a;
  const Vec3 span = part.b - part.a;
  if (part.squash != 1) from += part.squash_axis * (dot(part.squash_axis, from) * (1 / part.squash - 1));
  const double size = dot(span, span);
  const double t = size > 0 ? std::clamp(dot(from, span) / size, 0.0, 1.0) : 0;
  double d = length(from - span * t) - (part.radius_a + (part.radius_b - part.radius_a) * t);
  d *= 0.5 * (1 + part.squash); // keeps the slope near 1 on average over the thin and the wide side
  return std::max(d, dot(part.cut_normal, p) - part.cut_offset);
}

// Polynomial smooth minimum: min, lowered by at most k / 4 where the two are within k.
double smooth_minimum(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k * 0.25;
}

void add_head(std::vector<Part> &parts, Hair style) {
  parts.push_back({head, skin, {0, 1.765, -0.015}, {0, 1.775, 0.010}, 0.098, 0.094, {1, 0, 0}, 0.80});
  parts.push_back({head, skin, {0, 1.700, 0.034}, {0, 1.674, 0.060}, 0.064, 0.041, {1, 0, 0}, 0.95});
  parts.push_back({head, skin, {0, 1.765, 0.094}, {0, 1.730, 0.105}, 0.009, 0.016});
  for (const int side : {1, -1})
    parts.push_back({head,
                     skin,
                     {side * 0.083, 1.765, -0.012},
                     {side * 0.080, 1.73, -0.006},
                     0.026,
                     0.018,
                     {1, 0, 0},
                     0.45});
  parts.push_back({head, skin, {0, 1.54, -0.020}, {0, 1.69, -0.004}, 0.068, 0.060});
  // Hair ends at the hairline: a plane that rises towards the face.
  const Vec3 line = normalised(Vec3{0, -0.62, 0.78});
  const double offset = dot(line, {0, 1.815, 0.072});
  if (style == Hair::afro)
    parts.push_back(
        {head, hair, {0, 1.80, -0.028}, {0, 1.82, -0.01}, 0.122, 0.118, {1, 0, 0}, 0.92, line, offset});
  else
    parts.push_back(
        {head, hair, {0, 1.775, -0.022}, {0, 1.785, 0.004}, 0.105, 0.101, {1, 0, 0}, 0.80, line, offset});
}

void add_torso(std::vector<Part> &parts) {
  const Vec3 front{0, 0, 1};
  // Skin at the top, where the jersey leaves it free.
  parts.push_back({chest, skin, {-0.15, 1.465, -0.015}, {0.15, 1.465, -0.015}, 0.060, 0.060});
  for (const int side : {1, -1}) {
    parts.push_back({chest, skin, {side * 0.02, 1.565, -0.02}, {side * 0.16, 1.485, -0.02}, 0.048, 0.046});
    parts.push_back(
        {chest, jersey, {side * 0.075, 1.38, 0.030}, {side * 0.085, 1.37, 0.030}, 0.095, 0.090, front, 0.85});
  }
  parts.push_back({chest, jersey, {0, 1.30, -0.012}, {0, 1.405, -0.015}, 0.178, 0.172, front, 0.64});
  parts.push_back({spine, jersey, {0, 1.14, -0.005}, {0, 1.28, -0.010}, 0.158, 0.174, front, 0.70});
  // The loose end of the jersey over the shorts.
  parts.push_back(
      {pelvis, jersey, {0, 0.94, 0}, {0, 1.12, -0.003}, 0.188, 0.162, front, 0.76, {0, -1, 0}, -0.925});
  parts.push_back({pelvis, shorts, {-0.07, 0.965, 0}, {0.07, 0.965, 0}, 0.108, 0.108, front, 1.05});
  parts.push_back({pelvis, shorts, {-0.06, 0.95, -0.045}, {0.06, 0.95, -0.045}, 0.090, 0.090});
}

void add_arm(std::vector<Part> &parts, int side) {
  const auto &joint = rest_joints();
  const size_t upper = side > 0 ? left_upper_arm : right_upper_arm;
  const Joint bone[3] = {Joint(upper), Joint(upper + 1), Joint(upper + 2)};
  const Vec3 shoulder = joint[upper], elbow = joint[upper + 1], wrist = joint[upper + 2],
             along = rest_arm(side);
  const Vec3 front{0, 0, 1}, palm = rest_palm(side);
  parts.push_back({bone[0], skin, shoulder + along * 0.02, elbow, 0.060, 0.041});
  parts.push_back({bone[0], skin, shoulder + along * 0.12 + front * 0.010,
                   elbow - along * 0.08 + front * 0.008, 0.050, 0.044});
  parts.push_back({bone[1], skin, elbow, wrist, 0.041, 0.029});
  parts.push_back({bone[1], skin, elbow + along * 0.05, elbow + along * 0.13, 0.045, 0.040});
  parts.push_back({bone[2], skin, wrist + along * 0.035, wrist + along * 0.085, 0.036, 0.043, palm, 0.60});
  parts.push_back({bone[2], skin, wrist + along * 0.09 + palm * 0.004, wrist + along * 0.165 + palm * 0.016,
                   0.043, 0.036, palm, 0.60});
  parts.push_back({bone[2], skin, wrist + along * 0.035 + front * 0.022,
                   wrist + along * 0.085 + front * 0.060 + palm * 0.012, 0.021, 0.020});
}

void add_leg(std::vector<Part> &parts, int side) {
  const auto &joint = rest_joints();
  const size_t thigh = side > 0 ? left_thigh : right_thigh;
  const Joint bone[3] = {Joint(thigh), Joint(thigh + 1), Joint(thigh + 2)};
  const Vec3 hip = joint[thigh], knee = joint[thigh + 1], ankle = joint[thigh + 2], along = rest_leg(side);
  const Vec3 front{0, 0, 1};
  parts.push_back({bone[0],
                   shorts,
                   hip + along * 0.02,
                   hip + along * 0.40,
                   0.112,
                   0.118,
                   {1, 0, 0},
                   1,
                   along,
                   dot(along, hip) + 0.385});
  parts.push_back({bone[0], skin, hip + along * 0.10, knee, 0.092, 0.060});
  parts.push_back({bone[1], skin, knee, ankle, 0.057, 0.038});
  parts.push_back({bone[1], skin, knee + along * 0.08 - front * 0.018, knee + along * 0.20 - front * 0.014,
                   0.056, 0.046});
  const Vec3 ground{ankle.x, 0, ankle.z};
  parts.push_back(
      {bone[2], shoes, ankle + Vec3{0, 0.025, -0.008}, ankle + Vec3{0, -0.02, -0.01}, 0.047, 0.052});
  parts.push_back({bone[2], shoes, ground + Vec3{0, 0.038, -0.045}, ground + Vec3{side * 0.008, 0.030, 0.115},
                   0.046, 0.050});
  parts.push_back({bone[2], shoes, ground + Vec3{0, 0.055, 0.02}, ground + Vec3{side * 0.005, 0.028, 0.150},
                   0.044, 0.042});
}

} // namespace

std::vector<Part> make_parts(Hair style) {
  std::vector<Part> parts;
  add_head(parts, style);
  add_torso(parts);
  for (const int side : {1, -1}) {
    add_arm(parts, side);
    add_leg(parts, side);
  }
  return parts;
}

double Figure::distance(Vec3 p) const {
  std::array<double, layer_count> nearest;
  nearest.fill(far_away);
  for (const Part &part : parts) {
    double &d = nearest[part.layer];
    d = smooth_minimum(d, part_distance(part, p), blend[part.layer] * rounding);
  }
  if (displacement)
    for (size_t layer = 0; layer < layer_count; layer++)
      if (nearest[layer] < 0.05) nearest[layer] += displacement(Layer(layer), p);
  double d = far_away;
  for (const double layer : nearest) d = smooth_minimum(d, layer, layer_blend);
  return std::max(d, -p.y); // soles are flat
}

Vec3 Figure::outwards(Vec3 p) const {
  constexpr double h = 1e-3;
  return normalised(Vec3{distance({p.x + h, p.y, p.z}) - distance({p.x - h, p.y, p.z}),
                         distance({p.x, p.y + h, p.z}) - distance({p.x, p.y - h, p.z}),
                         distance({p.x, p.y, p.z + h}) - distance({p.x, p.y, p.z - h})});
}

Joint Figure::bone(Vec3 p) const {
  const auto nearer = [&](const Part &a, const Part &b) { return part_distance(a, p) < part_distance(b, p); };
  return std::min_element(parts.begin(), parts.end(), nearer)->bone;
}

namespace {

using hull::Surface;

using render::Vec3;

using hull::Grid;
using hull::grid_over;

constexpr uint32_t no_vertex = UINT32_MAX;
constexpr int evening_rounds = 6;

class Net {
public:
  Net(const std::function<double(Vec3)> &distance, const Grid &points) : grid(points), count(grid.count) {
    value.reserve(grid.points());
    for (size_t k = 0; k < count[2]; k++)
      for (size_t j = 0; j < count[1]; j++)
        for (size_t i = 0; i < count[0]; i++)
          value.push_back(distance(grid.point(double(i), double(j), double(k))));
    vertex.assign(value.size(), no_vertex);
    compose_well(grid, value);
  }

  Surface surface() {
    Surface out;
    for (size_t k = 0; k + 1 < count[2]; k++)
      for (size_t j = 0; j + 1 < count[1]; j++)
        for (size_t i = 0; i + 1 < count[0]; i++) add_vertex(i, j, k, out);
    for (size_t k = 1; k + 1 < count[2]; k++)
      for (size_t j = 1; j + 1 < count[1]; j++)
        for (size_t i = 1; i + 1 < count[0]; i++)
          for (int axis = 0; axis < 3; axis++) add_quadrilateral({i, j, k}, axis, out);
    return out;
  }

private:
  // The mean of the points where edges of the cell cross the surface.
  void add_vertex(size_t i, size_t j, size_t k, Surface &out) {
    Vec3 sum;
    int crossings = 0;
    for (int a = 0; a < 8; a++)
      for (int bit = 1; bit < 8; bit *= 2) {
        if (a & bit) continue;
        const int b = a | bit;
        const auto corner = [&](int c) {
          return value[grid.at(i + size_t(c & 1), j + size_t(c >> 1 & 1), k + size_t(c >> 2))];
        };
        const double va = corner(a), vb = corner(b);
        if ((va < 0) == (vb < 0)) continue;
        const double t = va / (va - vb);
        sum += Vec3{double(a & 1), double(a >> 1 & 1), double(a >> 2)} +
               Vec3{double(bit & 1), double(bit >> 1 & 1), double(bit >> 2)} * t;
        crossings++;
      }
    if (crossings == 0) return;
    const Vec3 mean = sum * (1.0 / crossings);
    vertex[grid.at(i, j, k)] = uint32_t(out.vertices.size());
    out.vertices.push_back(grid.point(double(i) + mean.x, double(j) + mean.y, double(k) + mean.z));
  }

  void add_quadrilateral(std::array<size_t, 3> p, int axis, Surface &out) {
    std::array<size_t, 3> next = p;
    next[size_t(axis)]++;
    const bool inside = value[grid.at(p[0], p[1], p[2])] < 0;
    if (inside == (value[grid.at(next[0], next[1], next[2])] < 0)) return;
    // The four cells around the edge, in the turn of a right hand whose thumb points along the axis.
    const size_t u = size_t(axis + 1) % 3, v = size_t(axis + 2) % 3;
    std::array<uint32_t, 4> corner;
    for (size_t c = 0; c < 4; c++) {
      std::array<size_t, 3> q = p;
      q[u] -= c == 0 || c == 3;
      q[v] -= c < 2;
      corner[c] = vertex[grid.at(q[0], q[1], q[2])];
    }
    if (!inside) std::swap(corner[1], corner[3]);
    const auto span = [&](size_t a, size_t b) {
      return length(out.vertices[corner[a]] - out.vertices[corner[b]]);
    };
    const size_t first = span(0, 2) <= span(1, 3) ? 0 : 1; // split along the shorter diagonal
    for (size_t t = 0; t < 2; t++)
      for (const size_t c : {first, first + 1 + t, first + 2 + t}) out.faces.push_back(corner[c % 4]);
  }

  const Grid grid;
  const std::array<size_t, 3> &count;
  std::vector<double> value;
  std::vector<uint32_t> vertex; // of the cell whose lowest corner is this point
};

Vec3 gradient(const std::function<double(Vec3)> &distance, Vec3 p) {
  constexpr double h = 1e-3;
  return Vec3{distance({p.x + h, p.y, p.z}) - distance({p.x - h, p.y, p.z}),
              distance({p.x, p.y + h, p.z}) - distance({p.x, p.y - h, p.z}),
              distance({p.x, p.y, p.z + h}) - distance({p.x, p.y, p.z - h})} *
         (0.5 / h);
}

// For each vertex the vertices that share an edge with it, in rising order.
std::vector<std::vector<uint32_t>> neighbours(const Surface &surface) {
  std::vector<std::vector<uint32_t>> result(surface.vertices.size());
  for (size_t i = 0; i < surface.faces.size(); i += 3)
    for (size_t c = 0; c < 3; c++) {
      const uint32_t a = surface.faces[i + c], b = surface.faces[i + (c + 1) % 3];
      result[a].push_back(b);
      result[b].push_back(a);
    }
  for (auto &list : result) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return result;
}

// Triangles of the surface distance(p) = 0 inside the box low..high, which it must not touch: one vertex for
// each cell of the grid that the surface passes (Gibson, "Constrained elastic surface nets", 1998), evened
// out along the surface and moved onto it. Always closed and a manifold; details narrower than a cell go.
Surface extract(const std::function<double(Vec3)> &distance, Vec3 low, Vec3 high, double cell) {
  Surface surface = Net(distance, grid_over(low, high, cell)).surface();
  const auto around = neighbours(surface);
  for (int round = 0; round < evening_rounds; round++) {
    std::vector<Vec3> moved = surface.vertices;
    for (size_t i = 0; i < moved.size(); i++) {
      Vec3 mean;
      for (const uint32_t n : around[i]) mean += surface.vertices[n];
      const Vec3 slope = gradient(distance, moved[i]);
      const Vec3 normal = normalised(slope);
      const Vec3 step = mean * (1.0 / double(around[i].size())) - moved[i];
      // Half a step of evening out within the tangent plane, then at most a quarter of a cell towards the
      // surface.
      Vec3 p = moved[i] + (step - normal * dot(normal, step)) * 0.5;
      const double off = distance(p) / std::max(length(slope), 0.3);
      moved[i] = p - normal * std::clamp(off, -0.25 * cell, 0.25 * cell);
    }
    surface.vertices = moved;
  }
  return surface;
}

constexpr double practice_cell = 0.0200; // metres: gives the number of triangles that the scene wants
constexpr int practice_rounds = 18;      // spreads a joint over about 8 cm

// Every vertex belongs to its nearest bone; then weights flow along the surface. Distance within space would
// tie an arm to the hip beside it, distance along the surface does not.
std::vector<Influence> influences(const Figure &figure, const Surface &surface, int diffusion_rounds) {
  using Weights = std::array<double, joint_count>;
  std::vector<Weights> weights(surface.vertices.size(), Weights{});
  for (size_t i = 0; i < weights.size(); i++) weights[i][figure.bone(surface.vertices[i])] = 1;
  const auto around = neighbours(surface);
  for (int round = 0; round < diffusion_rounds; round++) {
    std::vector<Weights> next = weights;
    for (size_t i = 0; i < weights.size(); i++)
      for (size_t j = 0; j < joint_count; j++) {
        double sum = 0;
        for (const uint32_t n : around[i]) sum += weights[n][j];
        next[i][j] = 0.5 * weights[i][j] + 0.5 * sum / double(around[i].size());
      }
    weights = next;
  }
  std::vector<Influence> result(weights.size());
  for (size_t i = 0; i < weights.size(); i++) {
    std::array<Joint, joint_count> order;
    for (size_t j = 0; j < joint_count; j++) order[j] = Joint(j);
    std::stable_sort(order.begin(), order.end(),
                     [&](Joint a, Joint b) { return weights[i][a] > weights[i][b]; });
    double sum = 0;
    for (size_t k = 0; k < 4; k++) sum += weights[i][order[k]];
    for (size_t k = 0; k < 4; k++) {
      result[i].joint[k] = order[k];
      result[i].weight[k] = float(weights[i][order[k]] / sum);
    }
  }
  return result;
}

// Ambient occlusion from the distance field: where the surface's surroundings are nearer than the way walked
// along the normal, something shadows it (Evans, "Fast approximations for global illumination", 2006).
float exposure(const Figure &figure, Vec3 p) {
  const Vec3 normal = figure.outwards(p);
  double occlusion = 0, share = 0.5;
  for (const double way : {0.02, 0.05, 0.10, 0.18}) {
    occlusion += share * std::clamp((way - figure.distance(p + normal * way)) / way, 0.0, 1.0);
    share *= 0.7;
  }
  return float(std::clamp(1 - 0.85 * occlusion, 0.2, 1.0));
}

} // namespace

Body make_body(const Figure &figure, const Sampling &sampling) {
  Body body;
  body.rest = extract([&](Vec3 p) { return figure.distance(p); }, sampling.low, sampling.high, sampling.cell);
  body.influences = influences(figure, body.rest, sampling.diffusion_rounds);
  body.exposure.reserve(body.rest.vertices.size());
  for (const Vec3 p : body.rest.vertices) body.exposure.push_back(exposure(figure, p));
  return body;
}

Body make_body(Hair style) {
  return make_body(Figure(make_parts(style)), {{-48 * practice_cell, -0.06, -0.30},
                                               {48 * practice_cell, 2.02, 0.32},
                                               practice_cell,
                                               practice_rounds});
}

void carry(const Body &body, const Bones &bones, std::vector<float> &positions) {
  const auto &joints = rest_joints();
  for (size_t i = 0; i < body.rest.vertices.size(); i++) {
    const Influence &influence = body.influences[i];
    Vec3 sum;
    for (size_t k = 0; k < 4; k++) {
      const Joint j = influence.joint[k];
      const Vec3 moved =
          bones.rotation[j] * (body.rest.vertices[i] - joints[j]) * bones.scale + bones.position[j];
      sum += moved * double(influence.weight[k]);
    }
    for (const double value : {sum.x, sum.y, sum.z}) positions.push_back(float(value));
  }
}

Surface make_ball(uint32_t n) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  const Vec3 corner[12] = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                           {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  const uint32_t side[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  Surface ball;
  // A point is named by its integer weights at the corners of the icosahedron: shared edges share points.
  std::map<std::array<uint32_t, 12>, uint32_t> known;
  for (const auto &triangle : side) {
    const auto point = [&](uint32_t a, uint32_t b) {
      std::array<uint32_t, 12> key{};
      key[triangle[0]] += n - a - b;
      key[triangle[1]] += a;
      key[triangle[2]] += b;
      const auto [entry, added] = known.try_emplace(key, uint32_t(ball.vertices.size()));
      if (added) {
        Vec3 sum;
        for (size_t c = 0; c < 12; c++) sum += corner[c] * double(key[c]);
        ball.vertices.push_back(normalised(sum));
      }
      return entry->second;
    };
    for (uint32_t a = 0; a < n; a++)
      for (uint32_t b = 0; a + b < n; b++) {
        ball.faces.insert(ball.faces.end(), {point(a, b), point(a + 1, b), point(a, b + 1)});
        if (a + b + 1 < n)
          ball.faces.insert(ball.faces.end(), {point(a + 1, b), point(a + 1, b + 1), point(a, b + 1)});
      }
  }
  return ball;
}

} // namespace fvv::synth
