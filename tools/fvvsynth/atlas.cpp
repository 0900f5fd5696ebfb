#include "fvvsynth/atlas.h"

#include "fvvsynth/bake.h"

#include <algorithm>

namespace fvv::synth {

namespace {

// The pieces of a player that are cut off from each other: limbs, which are straight at rest, with hands and
// feet, and the rest with the head.
enum Piece : uint8_t { trunk, left_arm, right_arm, left_leg, right_leg, piece_count };

constexpr Piece piece_of(Joint joint) {
  return joint < left_upper_arm    ? trunk
         : joint < right_upper_arm ? left_arm
         : joint < left_thigh      ? right_arm
         : joint < right_thigh     ? left_leg
                                   : right_leg;
}

// y against the direction of a limb, z as near to the player's front as it can be.
Mat3 limb_axes(Vec3 direction) {
  const Vec3 y = -direction, front{0, 0, 1};
  const Vec3 z = normalised(front - y * dot(front, y));
  return {cross(y, z), y, z};
}

// Which of a player's pieces a face belongs to: the one whose bones carry most of it.
Piece piece_of(const Body &body, size_t face) {
  std::array<double, piece_count> weight{};
  for (size_t c = 0; c < 3; c++) {
    const Influence &influence = body.influences[body.rest.faces[3 * face + c]];
    for (size_t k = 0; k < 4; k++) weight[piece_of(influence.joint[k])] += double(influence.weight[k]);
  }
  return Piece(std::max_element(weight.begin(), weight.end()) - weight.begin());
}

} // namespace

Atlas make_atlas(const Scene &scene, uint32_t size, uint32_t threads) {
  Surface surface;
  surface.faces = scene.faces();
  std::vector<uint8_t> region;
  for (const Body &body : scene.players()) {
    surface.vertices.insert(surface.vertices.end(), body.rest.vertices.begin(), body.rest.vertices.end());
    for (size_t face = 0; face < body.rest.faces.size() / 3; face++) region.push_back(piece_of(body, face));
  }
  region.resize(surface.faces.size() / 3, trunk); // the ball, whose axes are the trunk's
  const std::vector<float> &solid = scene.solid();
  const auto place = [&](uint32_t vertex) {
    return Vec3{solid[3 * vertex], solid[3 * vertex + 1], solid[3 * vertex + 2]};
  };
  while (surface.vertices.size() < scene.vertex_count())
    surface.vertices.push_back(place(uint32_t(surface.vertices.size())) * ball_radius);

  Atlas atlas;
  atlas.charts = make_charts(surface, region,
                             {Mat3{}, limb_axes(rest_arm(1)), limb_axes(rest_arm(-1)), limb_axes(rest_leg(1)),
                              limb_axes(rest_leg(-1))});
  atlas.layout = lay_out(surface, atlas.charts, size);
  atlas.picture = bake(
      atlas.charts, atlas.layout,
      [&](uint32_t face, const std::array<double, 3> &weights) {
        Vec3 at;
        for (size_t c = 0; c < 3; c++) at += place(scene.faces()[3 * face + c]) * weights[c];
        return scene.reflectance(face, at).colour;
      },
      threads);
  return atlas;
}

} // namespace fvv::synth
