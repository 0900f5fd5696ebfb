// Players and ball as triangle meshes. The rest shape of a player is an implicit surface: rounded cones, each
// carried by a bone, joined smoothly within a layer (skin, shorts, jersey, shoes).
#pragma once

#include "fvv_geometry/hull.h"
#include "fvvsynth/body/skeleton.h"

#include <array>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace fvv::synth {

using hull::Surface;

enum Layer : uint8_t { skin, hair, shorts, jersey, shoes, layer_count };

// The points whose distance from segment a-b is below a radius that goes from radius_a to radius_b.
struct Part {
  Joint bone;
  Layer layer;
  Vec3 a, b;
  double radius_a, radius_b;
  Vec3 squash_axis{0, 0, 1}; // unit vector, across which
  double squash = 1;         // the part is this much thinner
  // The part ends at the plane dot(cut_normal, p) = cut_offset; the default cuts nothing off.
  Vec3 cut_normal{};
  double cut_offset = std::numeric_limits<double>::infinity();
};

enum class Hair { short_cut, afro };

// Of one body, all layers.
std::vector<Part> make_parts(Hair hair);

// What is taken off a layer at a point, in metres: folds and hollows.
using Displacement = std::function<double(Layer, Vec3)>;

class Figure {
public:
  // flow: how far parts flow together, times the usual.
  explicit Figure(std::vector<Part> of, Displacement taken_off = {}, double flow = 1)
      : parts(std::move(of)), displacement(std::move(taken_off)), rounding(flow) {}
  // About the distance from the surface in metres, negative inside.
  double distance(Vec3 p) const;
  // Unit vector of its steepest rise: outwards.
  Vec3 outwards(Vec3 p) const;
  // The bone that carries the surface there: that of the nearest part.
  Joint bone(Vec3 p) const;

private:
  std::vector<Part> parts;
  Displacement displacement;
  double rounding;
};

struct Influence { // of bones on a vertex; weights sum to 1
  std::array<Joint, 4> joint;
  std::array<float, 4> weight;
};

struct Body {
  Surface rest;
  std::vector<Influence> influences; // one per vertex
  std::vector<float> exposure;       // one per vertex: how open the rest shape is there, 0..1
};

// How a figure becomes triangles: inside which box, which it must not touch, with how long edges (metres),
// and how many edges away a joint is felt.
struct Sampling {
  Vec3 low, high;
  double cell;
  int diffusion_rounds;
};
// One connected closed surface if the figure is.
Body make_body(const Figure &figure, const Sampling &sampling);
// The player of the practice: about 16,500 triangles.
Body make_body(Hair hair);

// Linear-blend skinning: the vertices of body carried by bones, appended to positions (x y z, metres).
void carry(const Body &body, const Bones &bones, std::vector<float> &positions);

// A sphere of radius 1 of 20 n^2 triangles of almost equal size (subdivided icosahedron).
Surface make_ball(uint32_t n);

} // namespace fvv::synth
