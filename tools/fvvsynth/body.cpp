// Body: surface, skinning weights, exposure.
#include "fvvsynth/body.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace fvv::synth {

namespace {

constexpr double cell = 0.0200;      // metres: gives the number of triangles that the scene wants
constexpr int diffusion_rounds = 18; // spreads a joint over about 8 cm

// Every vertex belongs to its nearest bone; then weights flow along the surface. Distance within space would
// tie an arm to the hip beside it, distance along the surface does not.
std::vector<Influence> influences(const Figure &figure, const Surface &surface) {
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

Body make_body(Hair style) {
  const Figure figure(style);
  Body body;
  body.rest = extract([&](Vec3 p) { return figure.distance(p); }, {-48 * cell, -0.06, -0.30},
                      {48 * cell, 2.02, 0.32}, cell);
  body.influences = influences(figure, body.rest);
  body.exposure.reserve(body.rest.vertices.size());
  for (const Vec3 p : body.rest.vertices) body.exposure.push_back(exposure(figure, p));
  return body;
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
